"""A batch in which nothing moves."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.motions import Motions, no_motions, no_presets
from postproc.nc import dialects

MACHINES = Path(__file__).resolve().parents[1] / "machines"


def filter_of(name: str, dialect: str) -> Filter:
    machine = read_machine(MACHINES / name)
    return Filter(machine, dialects.load(dialect), setup_of(machine))


@pytest.mark.parametrize(
    ("name", "dialect"), [("example-mill", "linuxcnc"), ("studer-s36", "fanuc-lathe")]
)
def test_columns_are_of_the_kinds_that_motions_have(name, dialect):
    """Joined with those of another segment they must not change its numbers."""
    seen: list[Motions] = []
    filter_ = filter_of(name, dialect)
    filter_.watchers.append(lambda words, motions, *_: seen.append(motions))
    axes = " ".join(f"{x}5." for x in filter_.machine.letters)
    filter_.feed(f"G21 G90 G0 {axes}\nG1 X20. Z6. F100.\n".encode())
    some, none = (
        seen[0].part(0, 0),
        no_motions(len(filter_.machine.letters), [], no_presets(), None),
    )
    for field in fields(Motions):
        one, other = getattr(some, field.name), getattr(none, field.name)
        if isinstance(one, np.ndarray) and field.name != "heat":
            assert (one.dtype, one.shape) == (other.dtype, other.shape), field.name


def test_what_holds_behind_it_is_kept():
    """F, a motion code, a work offset and a presetting in lines by themselves."""
    text = b"G21 G90 G0 X1 Y1 Z1\nF500\nG1\nG4 P1\nX20 Y9\nG92 X0\nM0\nX30\nG3\nX40 Y9 R6\n"
    one, other = filter_of("example-mill", "linuxcnc"), filter_of("example-mill", "linuxcnc")
    whole = one.feed(text) + one.finish()
    assert whole == b"".join(other.feed(line) for line in text.splitlines(keepends=True))
    assert len(whole.splitlines()) > len(text.splitlines())
