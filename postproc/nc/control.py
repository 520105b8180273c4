"""One control: a dialect on a machine, and which letters it reads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from postproc.errors import GcompError
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import ABSOLUTE, AXES, RELATIVE
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM

# Haas, G110 to G129: G154 P1 to P20 (mill operator's manual 96-8210, "G110-G129", "G154")
ALSO = {f"G{109 + p}": f"G54.1 P{p}" for p in range(1, 21)}
PARAMETERS = "NOGMFSTDHLPQ"


def spelled(how: int, letter: str) -> str:
    """The letter under which X=AC() or X=IC() comes."""
    return chr(how + AXES.index(letter)) if letter in AXES else ""


class Control:
    """rows: axis letter to its row; increment_rows: U and its kin likewise; letters: those that a
    program may use; spellings: axis, its letters for a place, its letters for an increment."""

    def __init__(self, dialect: Dialect, setup: Setup):
        setup = _with_own_names(dialect, setup)
        self.dialect, self.setup = dialect, setup
        self.rows = {letter: i for i, letter in enumerate(setup.axes)}
        for own in (x for x in dialect.increments if x in self.rows):
            raise GcompError(
                f"the machine has an axis {own}, and {own} is an increment of"
                f" {dialect.increments[own]} on {dialect.title}",
                "name the dialect in which that axis is programmed: --dialect",
            )
        self.increment_rows = {
            u: self.rows[x] for u, x in dialect.increments.items() if x in self.rows
        }
        self.letters = (
            set(PARAMETERS + "IJKR")
            | set(self.rows)
            | set(self.increment_rows)
            | set(dialect.letters)
            | (set("YV") if dialect.polar == "Y" and "C" in self.rows else set())
        )
        # units and diameters to scales that hold for them (measures.py)
        self.measures: dict[tuple[int, int], tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        self.zero: Any = None  # the zero worked out last (zeros.py)
        # X, X=AC() and, as a distance, U, X=IC()
        letter = {row: u for u, row in self.increment_rows.items()}
        self.spellings = [
            (x, (x, spelled(ABSOLUTE, x)), (letter.get(row, ""), spelled(RELATIVE, x)))
            for x, row in self.rows.items()
        ]

    def stands(self) -> tuple[np.ndarray, np.ndarray]:
        """(A,) ticks, where the slides stand before the first block, and whether that is known."""
        stands = {**self.setup.home, **self.setup.start} if self.dialect.homes else self.setup.start
        start = [round(stands.get(x, 0.0) * TICKS_PER_MM) for x in self.setup.axes]
        return np.array(start, np.int64), np.array(
            [x in stands or x in self.dialect.carried for x in self.setup.axes]
        )


def _with_own_names(dialect: Dialect, setup: Setup) -> Setup:
    """What is stated of G154 P1 to P20 under their other names too."""
    names = {code.word for code in dialect.codes if code.group == "work offset"} & set(ALSO)
    own = {x: setup.offsets[ALSO[x]] for x in names if ALSO[x] in setup.offsets}
    return replace(setup, offsets={**own, **setup.offsets}) if own else setup
