"""`gcomp explain FILE --machine M`: what each block does, in words, and what was changed in it and
why.

The words are pygcode's, an interpreter of its own: where it reads other numbers than gcomp does,
that is said.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from typing import Any

import numpy as np

from postproc import ports
from postproc.commands import as_json, compensate, expansion, option_text, reading, reading_options
from postproc.machine import growth
from postproc.machine.contributions import contributions
from postproc.machine.model import Machine
from postproc.machine.seen import seen_in
from postproc.machine.tip import TipMachine
from postproc.machine.uncertainty import MapUncertainty, micrometres
from postproc.motions import FOREIGN, Motions
from postproc.nc.lexer import Words
from postproc.pieces import Pieces
from postproc.units import TICKS_PER_MM, UM

HELP = "say in words what each block does and what is changed in it"
EXAMPLE = "gcomp explain part.nc --machine studer-s36"
SMALLEST_UM = 0.05
FORMAT = "gcomp-explain/1"


OPTIONS = f"""
--json FILE  all of it as JSON ({FORMAT}); - for standard output
file? FILE  the program; standard input if missing
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    reading_options.arguments(parser)
    option_text.add(parser, OPTIONS)


def run(options: argparse.Namespace) -> int:
    machine = reading.machine_of(options)
    known = MapUncertainty(machine)
    seen: list[tuple[Words, Motions, Pieces]] = []
    with ports.opened(options.file) as (source, name, _):
        head = ports.head(source)
        filter_ = reading.filter_of(options, machine, head)
        filter_.name = name
        filter_.watchers.append(
            lambda words, motions, pieces, output, line: seen.append((words, motions, pieces))
        )
        lines: Iterable[bytes] = source
        if options.expand:
            written = expansion.written_out(filter_, source, options)
            lines = (line for portion in written for line in portion.splitlines(keepends=True))
        kept = []
        for number, line in enumerate(lines, 1):
            one = {"line": number, **_explained(filter_, known, seen, line)}
            seen.clear()
            if options.json:
                kept.append(one)
            if options.json != "-":
                _print(one)
        compensate.warn_of_nothing(filter_, name)
        as_json.put(
            options.json,
            {
                "format": FORMAT,
                "program": name,
                "machine": machine.name,
                "map": machine.digest,
                "lines": kept,
            },
        )
    return 0


def _explained(
    filter_, known: MapUncertainty, seen: list[tuple[Words, Motions, Pieces]], line: bytes
) -> dict[str, Any]:
    """One line, and what becomes of it. seen: what the filter makes of it, filled by its
    watcher."""
    # Line by line: what the filter adds to its notices meanwhile is about this one.
    said = len(filter_.notices)
    output = filter_.feed(line)
    if not line.endswith(b"\n"):
        output += filter_.finish()
    return {
        "text": line.decode("latin-1").rstrip(),
        "says": [
            sentence
            for words, motions, pieces in seen
            for block in range(words.blocks)
            for sentence in _block(filter_, known, words, motions, pieces, block)
        ],
        "becomes": _lines(output) if seen and output != line else None,
        "notices": [notice.message for notice in filter_.notices[said:]],
    }


def _lines(output: bytes) -> list[str]:
    return output.decode("latin-1").rstrip().splitlines()


def _print(one: dict[str, Any]) -> None:
    """A line for a person."""
    print(f"{one['line']:>5}  {one['text']}")
    for sentence in one["says"]:
        print(f"       | {sentence}")
    if one["becomes"] is not None:
        print("       > " + "\n       > ".join(one["becomes"]))
    for notice in one["notices"]:
        print(f"       ! {notice}")


def _block(
    filter_, known: MapUncertainty, words: Words, motions: Motions, pieces: Pieces, block: int
) -> list[str]:
    """Sentences about one block."""
    text = words.text[words.block_start[block] : words.block_stop[block]].decode("latin-1")
    mine: dict[str, list[float]] = {}
    for w in np.flatnonzero(words.block == block):
        mine.setdefault(chr(words.letter[w]), []).append(
            int(words.mantissa[w]) / 10.0 ** int(words.decimals[w])
        )
    if not mine:
        return []
    says = [_second_opinion(re.sub(r"\([^)]*\)", "", text), mine)]
    for i in np.flatnonzero(motions.block == block):
        says += _motion(filter_, known, motions, pieces, int(i))
    return says


def _second_opinion(text: str, mine: dict[str, list[float]]) -> str:
    """What pygcode makes of a block, and whether it read the same numbers."""
    from pygcode import Line
    from pygcode.exceptions import GCodeParameterError, GCodeWordStrError

    theirs: dict[str, list[float]] = {}
    try:
        line = Line(text.strip().lstrip("/"))
        for word in line.block.words:
            theirs.setdefault(word.letter, []).append(float(word.value))
    except (
        GCodeParameterError,
        GCodeWordStrError,
        AssertionError,
        ValueError,
        TypeError,
        IndexError,
    ) as error:
        return f"pygcode can not read this block ({type(error).__name__}); gcomp reads " + " ".join(
            f"{k}{v:g}" for k, vs in mine.items() for v in vs
        )
    names = [_described(g) for g in line.block.gcodes] or ["modal: goes on as before"]
    says = "; ".join(dict.fromkeys(names))
    if {k: sorted(v) for k, v in theirs.items()} != {k: sorted(v) for k, v in mine.items()}:
        says += f"  [pygcode reads {theirs}, gcomp {mine}]"
    return says


def _described(code: Any) -> str:
    """The words of a code, its name before them: some of pygcode's have it, some have not."""
    words = str(code.description)
    return words if re.match(r"[A-Z][\d.]*: ", words) else f"{code.word}: {words}"


def _shown(machine: Machine, place: np.ndarray) -> str:
    """A place (A, 1) in words."""
    return " ".join(f"{x} {place[k, 0]:.4f}" for k, x in enumerate(machine.letters))


def _named(parts: list[tuple[str, np.ndarray]], row: int) -> str:
    """The parts of a deviation along one axis, in brackets; "": none is large enough."""
    named = ", ".join(
        f"{name} {value[row, 0] / UM:+.1f}"
        for name, value in parts
        if abs(value[row, 0]) > SMALLEST_UM * UM
    )
    return f" ({named})" if named else ""


def _motion(filter_, known: MapUncertainty, motions: Motions, pieces: Pieces, i: int) -> list[str]:
    """Where a motion goes, what the machine would make of it, and what is written for it."""
    machine = filter_.machine
    if motions.code[i] == FOREIGN or not motions.target_known[list(machine.corrected), i].all():
        return ["its place is not known: left as it is"]
    target = motions.target[:, i : i + 1] / TICKS_PER_MM
    length, space = motions.length[:, i] / TICKS_PER_MM, motions.spaces[int(motions.space[i])]
    if machine.growth:
        machine = growth.grown(machine, machine.growth, motions.heat[:, i] * filter_.heat.step)
    machine = seen_in(machine, length, space, filter_.options.orientation)
    says, slides = [f"to {_shown(machine, target)} (slide position, mm)"], target
    if isinstance(machine, TipMachine):
        slides = machine.slides(target)
        says = [f"to {_shown(machine, target)} (tool tip, mm); slides to {_shown(machine, slides)}"]
    if machine.is_zero:
        return says
    # (A, 1): from which side each slide bears now, behind this block
    turn = filter_.carry.sides.side[:, None].astype(float)
    total = machine.deviation(target, turn)[:, 0]
    # Told along the words of the tip, what an axis errs by has no direction of its own.
    parts = [] if isinstance(machine, TipMachine) else contributions(machine, target, turn)
    says += [
        f"without correction {machine.letters[row]} would be off by {total[row] / UM:+.1f} um"
        f"{_named(parts, row)}"
        for row in machine.corrected
    ]
    if known.parts:
        u = float(known.length(slides, turn)[0])
        says.append(f"the map itself is known to +- {micrometres(u)} um (95 %) there")
    return says + _blocks(pieces, i)


def _blocks(pieces: Pieces, i: int) -> list[str]:
    """How many blocks a motion became, where it is more than one."""
    n = int((pieces.motion == i).sum())
    turns = int(pieces.take_up[pieces.motion == i].sum())
    round_ = f", {turns} of them to turn a slide round" if turns else ""
    return [f"written as {n} blocks{round_}"] if n > 1 else []
