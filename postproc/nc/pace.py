"""What blocks say of time: how fast the spindle turns, how a feed is counted, and how long a dwell rests.

The filter's motions carry the F number; whether it counts per minute or per turn, and what M3, S and G96 make of the spindle, is
read here, for the simulator and for the program's own clock.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.nc.batch import written_codes
from postproc.nc.columns import hold_last, hold_last_float
from postproc.nc.dialects import Dialect
from postproc.nc.lexer import KEYWORD_LETTER, Words

SECONDS = {  # dialect (its first word) to the letters of a dwell and the seconds of one unit of each
    "fanuc": {"P": 1e-3, "X": 1.0, "U": 1.0}, "haas": {"P": 1.0}, "linuxcnc": {"P": 1.0}, "grbl": {"P": 1.0},
    "grblhal": {"P": 1.0}, "fluidnc": {"P": 1.0}, "marlin": {"P": 1e-3, "S": 1.0}, "reprap": {"P": 1e-3, "S": 1.0},
    "siemens": {"F": 1.0}, "heidenhain": {"F": 1.0},
}  # fmt: skip
PER_TURN, SURFACE = 950, 960  # G95, G96
DWELL = 40  # G4
LONGEST = 1e7  # s: a longer dwell has the wrong unit


@dataclass(frozen=True)
class Spoken:
    """What holds behind a block. rpm: the S number; turning: 1 behind M3 and M4; mode: of feeds; surface: of the spindle."""

    rpm: float = 0.0
    turning: int = 0
    mode: int = 940
    surface: int = 970


@dataclass(frozen=True)
class Spindle:
    """At each block (B,): number, the S that holds (1/min, under G96 m/min); on, whether it turns; mode, the code of the feeds'
    unit; surface, whether G96 holds."""

    number: np.ndarray
    on: np.ndarray
    mode: np.ndarray
    surface: np.ndarray

    @property
    def rpm(self) -> np.ndarray:
        """(B,) turns per minute, 0 where it rests or G96 makes them hang on the diameter."""
        return np.where(self.on & ~self.surface, self.number, 0.0)


def spindle(words: Words, dialect: Dialect, before: Spoken) -> tuple[Spindle, Spoken]:
    """How the spindle turns at each block, and what the next batch must know."""
    n = words.blocks
    place = np.flatnonzero((words.letter == ord("G")) | (words.letter == KEYWORD_LETTER))
    number = written_codes(words, place)
    number = np.where(number >= 0, dialect.meant[np.maximum(number, 0)], -1)
    mode, surface = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for codes, column in (((930, 940, 950), mode), ((960, 970), surface)):
        of = np.isin(number, codes)
        column[words.block[place[of]]] = number[of]
    mode, surface = hold_last(mode, before.mode), hold_last(surface, before.surface)
    speed = np.full(n, np.nan)
    turns = np.flatnonzero(words.letter == ord("S"))
    turns = turns[~np.isin(words.block[turns], words.block[place[number == DWELL]])]
    speed[words.block[turns]] = words.mantissa[turns] / 10.0 ** words.decimals[turns]
    speed = hold_last_float(speed, before.rpm)
    on = np.full(n, -1, np.int64)
    for k in np.flatnonzero(words.letter == ord("M")):
        code = int(words.mantissa[k])
        if words.decimals[k] == 0 and code in (3, 4, 5):
            on[words.block[k]] = code != 5
    on = hold_last(on, before.turning)
    after = Spoken(float(speed[-1]), int(on[-1]), int(mode[-1]), int(surface[-1])) if n else before
    return Spindle(speed, on == 1, mode, surface == SURFACE), after


def dwells(words: Words) -> list[int]:
    """The blocks that rest (G4), in order."""
    place = np.flatnonzero(words.letter == ord("G"))
    return [int(b) for b in words.block[place[written_codes(words, place) == DWELL]]]


def live(words: Words, dialect: Dialect) -> int:
    """The block behind which nothing is read."""
    m = np.flatnonzero(
        (words.letter == ord("M")) & np.isin(words.mantissa, dialect.ends) & (words.decimals == 0)
    )
    return int(words.block[m[0]]) if len(m) else words.blocks


def letters_of_dwell(dialect: Dialect) -> dict[str, float]:
    """The letters of a dwell's time on this control, with the seconds of one unit; none where it is not known."""
    return SECONDS.get(dialect.name.partition("-")[0], {})


def seconds(words: Words, block: int, dialect: Dialect) -> float:
    """How long a G4 block rests, s; nan where it does not say."""
    units = letters_of_dwell(dialect)
    low, high = (int(np.searchsorted(words.block, b)) for b in (block, block + 1))
    for k in range(low, high):
        letter = chr(words.letter[k])
        if letter in units:
            value = float(words.mantissa[k]) / 10.0 ** float(words.decimals[k]) * units[letter]
            if not words.pointed[k] and (
                dialect.name.startswith("haas")
                or (letter in "XU" and dialect.integers == "least increments")
            ):
                value *= 1e-3
            return value
    return float("nan")
