"""gcomp stream --expand: the program is read whole and written out; every wire line still knows the
line written by hand."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from postproc.commands import expansion
from postproc.errors import ProgramError
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import ModalState
from postproc.streaming.lines import WireLine
from postproc.streaming.source import Source


class Standing(Interpreter):
    """An interpreter that begins where the controller stands, not where a program begins by
    itself."""

    def __init__(self, modal: ModalState, *of: Any):
        super().__init__(*of)
        self.modal = modal

    def initial(self) -> ModalState:
        return self.modal


def lines(
    source: Source, text: bytes, options: argparse.Namespace, library: dict[str, bytes | None]
) -> Iterator[list[WireLine]]:
    """Wire lines of a program that is written out, portion by portion. library: texts of
    subprograms as they were read first, which are not read again. Raises ProgramError at the line
    written by hand, behind what came before it."""
    filter_ = source.filter
    here = Path(options.file).parent if options.file not in (None, "-") else Path()
    files = expansion.Library([here, *map(Path, options.library)], filter_.notices)

    def subprogram(name: str) -> bytes | None:
        if name not in library:
            library[name] = files.text(name)
        return library[name]

    tracked = Standing(filter_.modal, filter_.dialect, filter_.setup)
    limits = Limits(options.max_steps, options.max_depth)
    program = Program(filter_.name, text, subprogram)
    written = Written(program, tracked, limits, filter_.compensator.keeps)
    # expansion.through feeds a filter and yields text; here it feeds the source, and yields wire
    # lines
    fed = SimpleNamespace(feed=source.feed, finish=source.finish, notices=filter_.notices)
    try:
        for batch in expansion.through(cast(Any, fed), written, lambda size: None):
            yield _by_hand(cast(list[WireLine], batch), written)
    except ProgramError:
        yield _by_hand(source.delivered, written)
        raise


def _by_hand(batch: list[WireLine], written: Written) -> list[WireLine]:
    where = [written.source(line.source) for line in batch]
    return [
        replace(line, source=n, file=file) for line, (n, file) in zip(batch, where, strict=True)
    ]
