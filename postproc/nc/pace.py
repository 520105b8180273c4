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
from postproc.nc.codes import spindle_codes
from postproc.nc.columns import hold_last, hold_last_float
from postproc.nc.dialects import Dialect
from postproc.nc.grammar import KEYWORD_LETTER, PARAMETER
from postproc.nc.lexer import Words
from postproc.units import TICKS_PER_MM

# By the first word of a dialect's name: the letters of a dwell's time (G4) and the seconds of one
# unit of each; of two in a block the first here holds. Sources, where the dialect's file names
# none: Autodesk's okuma.cps and centroid.cps (onDwell); OSP-P200L programming manual, section 2-3,
# UNIT: one unit of time is 1 s where one of length is 1 mm; Klipper, klippy/toolhead.py, cmd_G4 (P
# alone); Smoothieware, Robot.cpp, on_gcode_received, case 4; marlinfw.org, G4: S before P.
SECONDS = {
    "fanuc": {"P": 1e-3, "X": 1.0, "U": 1.0},
    "haas": {"P": 1.0},
    "linuxcnc": {"P": 1.0},
    "grbl": {"P": 1.0},
    "grblhal": {"P": 1.0},
    "fluidnc": {"P": 1.0},
    "marlin": {"S": 1.0, "P": 1e-3},
    "reprap": {"S": 1.0, "P": 1e-3},
    "siemens": {"F": 1.0},
    "heidenhain": {"F": 1.0},
    "centroid": {"P": 1.0},
    "fadal": {"P": 1e-3},
    "fagor": {"K": 1.0},
    "klipper": {"P": 1e-3},
    "okuma": {"F": 1.0},
    "smoothie": {"S": 1.0},
}
# What is not known of a dwell's time, and what to do. K of Fagor: Autodesk's fagor.cps for the 8037
# and 8055 ("centiseconds", whole numbers) and the one for the 8058 to 8070 ("seconds"). Mach3:
# mach3mill.cps, dwellInSeconds. P of Smoothieware: is_grbl_mode in Robot.cpp.
UNTIMED = {
    "fagor": (
        "K without a decimal point is hundredths of a second on the 8055 and seconds on the 8065:"
        " write seconds with a point"
    ),
    "klipper": "S is not read: write P, which is milliseconds",
    "mach3": "P is seconds or milliseconds by a setting: seconds are read under --dialect linuxcnc",
    "smoothie": "P is seconds or milliseconds by a setting: write S, which is seconds",
    "siemens": "S is turns of the spindle: write F, which is seconds",
}
POINTED = ("fagor",)  # a number without a decimal point is not known
WHOLE = ("smoothie",)  # what stands behind the decimal point is dropped
# By the first word: the letter of the fastest that G96 turns, and ten times the codes beside which
# it stands. D: LinuxCNC, and grblHAL's gcode.c; Sinumerik has LIMS= too.
LIMITS = {
    "fanuc": ("S", (500, 920)),
    "haas": ("S", (500, 920)),
    "okuma": ("S", (500, 920)),
    "fagor": ("S", (920,)),
    "linuxcnc": ("D", (960,)),
    "grblhal": ("D", (960,)),
    "siemens": ("S", (260,)),
}
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
        # m/min over the circumference in m: S200 at 50 mm diameter is 1273 turns a minute
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
        # a full circle ends where it begins, and a hole's way down is in no target
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
    # where S may be a dwell's time or its turns; the least speed beside G25 of Sinumerik
    beside = [
        DWELL if "S" in dialect.dwell else -1,
        250 if first_word(dialect) == "siemens" else -1,
    ]
    others = (number >= 0) & np.isin(number, beside)
    turns = turns[~np.isin(words.block[turns], words.block[place[others]])]
    cap = np.full(n, np.nan)
    limits = _limits(words, dialect, number, place, turns)
    cap[words.block[limits]] = words.mantissa[limits] / 10.0 ** words.decimals[limits]
    cap = hold_last_float(cap, before.cap)
    turns = np.setdiff1d(turns, limits)
    speed[words.block[turns]] = words.mantissa[turns] / 10.0 ** words.decimals[turns]
    speed = hold_last_float(speed, before.rpm)
    on = np.full(n, -1, np.int64)
    turns_by = spindle_codes(dialect.m_codes)
    for k in np.flatnonzero(words.letter == ord("M")):
        code = int(words.mantissa[k])
        if words.decimals[k] == 0 and code in turns_by:
            on[words.block[k]] = turns_by[code] != 5
    on = hold_last(on, before.turning)
    if not n:
        return Spindle(speed, on == 1, mode, surface == SURFACE, cap), before
    after = Spoken(float(speed[-1]), int(on[-1]), int(mode[-1]), int(surface[-1]), float(cap[-1]))
    return Spindle(speed, on == 1, mode, surface == SURFACE, cap), after


def _limits(
    words: Words, dialect: Dialect, number: np.ndarray, place: np.ndarray, turns: np.ndarray
) -> np.ndarray:
    """Words that say how fast G96 may turn the spindle, and are no speed (LIMITS)."""
    name = first_word(dialect)
    if name not in LIMITS:
        return np.zeros(0, np.int64)
    letter, beside = LIMITS[name]
    letters = turns if letter == "S" else np.flatnonzero(words.letter == ord(letter))
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


def first_word(dialect: Dialect) -> str:
    """By which the tables here, and the tests' programs (simulate/writer.py), know it."""
    return dialect.name.partition("-")[0]


def letters_of_dwell(dialect: Dialect) -> dict[str, float]:
    """The letters of a dwell's time on this control, with the seconds of one unit; none where it is
    not known."""
    units = SECONDS.get(first_word(dialect), {})
    return {letter: unit for letter, unit in units.items() if letter in dialect.dwell}


def seconds(words: Words, block: int, dialect: Dialect) -> float:
    """How long a G4 block rests, s; nan where it does not say, or in a unit that is not known."""
    units = letters_of_dwell(dialect)
    low, high = (int(np.searchsorted(words.block, b)) for b in (block, block + 1))
    given = {chr(words.letter[k]): k for k in range(low, high)}
    if any(letter in given and letter not in units for letter in dialect.dwell):
        return float("nan")
    for letter in (x for x in units if x in given):
        k = given[letter]
        value = float(words.mantissa[k]) / 10.0 ** float(words.decimals[k]) * units[letter]
        if not words.pointed[k]:
            value *= without_a_point(dialect, letter)
        return float(int(value) if first_word(dialect) in WHOLE else value)
    return float("nan")


def without_a_point(dialect: Dialect, letter: str) -> float:
    """By what a dwell's number without a decimal point is to be multiplied; nan: not known."""
    name, counts = first_word(dialect), dialect.integers == "least increments"
    if name in POINTED or (name == "okuma" and counts):  # 0.01 s or 0.1 s there
        return float("nan")
    # P500 of a Haas without a point is milliseconds, P0.5 seconds
    return 1e-3 if name == "haas" or (letter in "XU" and counts) else 1.0


def told_by(dialect: Dialect) -> str:
    """How a dwell's time is written on this control, for a person."""
    if dialect.grammar.klartext:
        return "seconds behind cycle 9 or FUNCTION DWELL TIME; --expand puts in Q parameters"
    letters = ", ".join(letters_of_dwell(dialect)) or "none is known"
    reason = UNTIMED.get(first_word(dialect), "")
    return f"letters: {letters}" + (f"; {reason}" if reason else "")
