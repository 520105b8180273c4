"""What blocks say of time: how fast the spindle turns, how a feed is counted, and how long a dwell
rests.

The filter's motions carry the F number; whether it counts per minute or per turn, and what M3, S
and G96 make of the spindle, is read here, for the simulator and for the program's own clock.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.motions import Motions
from postproc.nc.coded import written_codes
from postproc.nc.columns import hold_last, hold_last_float
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import KEYWORD_LETTER, PARAMETER
from postproc.nc.lexer import Words
from postproc.units import TICKS_PER_MM

# dialect (its first word) to the letters of a dwell and the seconds of one unit of each
SECONDS = {
    "fanuc": {"P": 1e-3, "X": 1.0, "U": 1.0},
    "haas": {"P": 1.0},
    "linuxcnc": {"P": 1.0},
    "grbl": {"P": 1.0},
    "grblhal": {"P": 1.0},
    "fluidnc": {"P": 1.0},
    "marlin": {"P": 1e-3, "S": 1.0},
    "reprap": {"P": 1e-3, "S": 1.0},
    "siemens": {"F": 1.0},
    "heidenhain": {"F": 1.0},
}
LIMITED = ("fanuc", "haas", "okuma", "fagor")  # G50 S or G92 S is the fastest that G96 turns
PER_TURN, SURFACE = 950, 960  # G95, G96
DWELL = 40  # G4
# mm: radius below which G96 does not turn a spindle any faster, where no limit is told
SMALLEST = 1.0
LONGEST = 1e7  # s: a longer dwell has the wrong unit


@dataclass(frozen=True)
class Spoken:
    """What holds behind a block. rpm: the S number; turning: 1 behind M3 and M4; mode: of feeds;
    surface: of the spindle; cap: turns per minute that G96 does not go beyond, inf where none was
    told."""

    rpm: float = 0.0
    turning: int = 0
    mode: int = 940
    surface: int = 970
    cap: float = np.inf


@dataclass(frozen=True)
class Spindle:
    """At each block (B,): number, the S that holds (1/min, under G96 m/min); on, whether it turns;
    mode, the code of the feeds' unit; surface, whether G96 holds; cap, turns per minute that G96
    does not go beyond, inf where none is told."""

    number: np.ndarray
    on: np.ndarray
    mode: np.ndarray
    surface: np.ndarray
    cap: np.ndarray

    @property
    def rpm(self) -> np.ndarray:
        """(B,) turns per minute, 0 where it rests or G96 makes them hang on the diameter."""
        return np.where(self.on & ~self.surface, self.number, 0.0)

    def turns(self, block: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """(K,) turns per minute in blocks (K,); under G96 by the radius (K,) mm at which each
        cuts."""
        number = self.number[block]
        by_surface = number * 1000.0 / (2 * np.pi * np.maximum(radius, SMALLEST))
        by_surface = np.minimum(by_surface, self.cap[block])
        turning = np.where(self.surface[block], by_surface, number)
        return np.where(self.on[block], turning, 0.0)


def unit_of_feed(motions: Motions) -> np.ndarray:
    """(N,) mm of one unit of F: of an inch where a slide moves in inches; degrees stay degrees."""
    known = motions.start_known & motions.target_known
    moves = np.where(known, motions.target != motions.start, motions.word >= 0)
    arcs, holes = motions.arcs, motions.holes
    for rows in (arcs.first, arcs.second):
        moves[rows, arcs.motion] = True
    moves[holes.axis, holes.motion] = True
    return np.where(((motions.scale > TICKS_PER_MM) & moves).any(axis=0), 25.4, 1.0)


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
    cap = np.full(n, np.nan)
    limits = _limits(words, dialect, number, place, turns)
    cap[words.block[limits]] = words.mantissa[limits] / 10.0 ** words.decimals[limits]
    cap = hold_last_float(cap, before.cap)
    turns = np.setdiff1d(turns, limits)
    speed[words.block[turns]] = words.mantissa[turns] / 10.0 ** words.decimals[turns]
    speed = hold_last_float(speed, before.rpm)
    on = np.full(n, -1, np.int64)
    for k in np.flatnonzero(words.letter == ord("M")):
        code = int(words.mantissa[k])
        if words.decimals[k] == 0 and code in (3, 4, 5):
            on[words.block[k]] = code != 5
    on = hold_last(on, before.turning)
    if not n:
        return Spindle(speed, on == 1, mode, surface == SURFACE, cap), before
    after = Spoken(float(speed[-1]), int(on[-1]), int(mode[-1]), int(surface[-1]), float(cap[-1]))
    return Spindle(speed, on == 1, mode, surface == SURFACE, cap), after


def _limits(
    words: Words, dialect: Dialect, number: np.ndarray, place: np.ndarray, turns: np.ndarray
) -> np.ndarray:
    """Words that say how fast G96 may turn the spindle, and are no speed: S beside G50 or G92
    (Fanuc, Haas, Okuma, Fagor), S beside G26 and LIMS= (Sinumerik), D beside G96 (LinuxCNC)."""
    name = dialect.name.partition("-")[0]
    if name == "linuxcnc":
        letters = np.flatnonzero(words.letter == ord("D"))
        beside: tuple[int, ...] = (SURFACE,)
    else:
        letters = turns
        beside = {"siemens": (260,)}.get(name, (500, 920) if name in LIMITED else ())
    blocks = words.block[place[np.isin(number, beside)]]
    found = letters[np.isin(words.block[letters], blocks)]
    if name != "siemens":
        return found
    spelled = np.flatnonzero(words.letter == PARAMETER)
    lims = [
        k for k in spelled if words.text[words.start[k] : words.start[k] + 4].upper() == b"LIMS"
    ]
    return np.sort(np.concatenate([found, np.array(lims, np.int64)]))


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
    """The letters of a dwell's time on this control, with the seconds of one unit; none where it is
    not known."""
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
            return float(value)
    return float("nan")
