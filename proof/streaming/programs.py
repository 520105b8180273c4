"""Twelve programs that a GRBL takes, each with the way that the tool must make, worked out beside
the text and not from it."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

INCH = 25.4
CHORD = 0.5  # mm: of a way, between two places that are asked for
PLANES = {17: (0, 1), 18: (2, 0), 19: (1, 2)}  # first and second axis of G2 and G3 (RS274NGC)


@dataclass
class Program:
    """text; places: (M, 3) mm, work coordinates of G54, in order, at most CHORD apart, every vertex
    among them; motion: (M,) which of the programmed motions leads to each; cuts: mm, work
    coordinates: above this Z nothing is cut."""

    name: str
    text: str
    places: np.ndarray
    motion: np.ndarray
    cuts: float


@dataclass
class Pen:
    """Writes blocks, and keeps where they lead. unit: mm; relative: G91; shift: of the work offset
    in force against G54."""

    rows: list[str] = field(default_factory=lambda: ["G21 G90 G94 G17", "G54"])
    unit: float = 1.0
    relative: bool = False
    digits: int = 3
    at: list[float] = field(default_factory=lambda: [math.nan] * 3)
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    places: list[tuple[float, ...]] = field(default_factory=list)
    motion: list[int] = field(default_factory=list)
    count: int = 0

    def say(self, *rows: str) -> None:
        """Blocks that move nothing."""
        self.rows += rows

    def _target(self, words: dict[str, float]) -> tuple[str, list[float]]:
        """The axis words as written, and where they lead (mm, G54) with the digits that are
        written."""
        text, to = "", list(self.at)
        for i, axis in enumerate("XYZ"):
            if axis not in words:
                continue
            start = (self.at[i] - self.shift[i]) / self.unit if self.relative else 0.0
            said = round(words[axis] / self.unit - start, self.digits)
            text += f" {axis}{said:.{self.digits}f}"
            to[i] = (said + start) * self.unit + self.shift[i]
        return text, to

    def _reach(self, places: list[list[float]]) -> None:
        self.count += 1
        for place in places:
            self.places.append(tuple(place))
            self.motion.append(self.count)
        self.at = list(places[-1])

    def line(self, code: str = "G1", feed: float = 0.0, **words: float) -> None:
        """A straight motion; words: mm, in the work offset in force."""
        text, to = self._target(words)
        self.rows.append(f"{code}{text}" + (f" F{feed / self.unit:g}" if feed else ""))
        if any(map(math.isnan, (*self.at, *to))):
            self.count += 1
            self.at = to
            return
        n = max(1, math.ceil(math.dist(self.at, to) / CHORD))
        pairs = list(zip(self.at, to, strict=True))
        self._reach([[a + (b - a) * k / n for a, b in pairs] for k in range(1, n + 1)])

    def arc(self, code: str, centre: tuple[float, float], plane: int = 17, **words: float) -> None:
        """An arc about a centre (mm from where it begins, in the plane's axes)."""
        first, second = PLANES[plane]
        text, to = self._target(words)
        letters = ("IJK"[first], "IJK"[second])
        said = [round(v / self.unit, self.digits) for v in centre]
        rows = sorted(zip(letters, said, strict=True))
        self.rows.append(f"{code}{text} " + " ".join(f"{k}{v:.{self.digits}f}" for k, v in rows))
        middle = [self.at[first] + said[0] * self.unit, self.at[second] + said[1] * self.unit]
        begin = math.atan2(self.at[second] - middle[1], self.at[first] - middle[0])
        sweep = (math.atan2(to[second] - middle[1], to[first] - middle[0]) - begin) % math.tau
        whole = min(sweep, math.tau - sweep) < 1e-6
        if code == "G2":
            sweep = -math.tau if whole else sweep - math.tau
        elif whole:
            sweep = math.tau
        radius = math.hypot(self.at[first] - middle[0], self.at[second] - middle[1])
        n = max(2, math.ceil(abs(sweep) * radius / CHORD))
        places = []
        for k in range(1, n + 1):
            place = [a + (b - a) * k / n for a, b in zip(self.at, to, strict=True)]
            place[first] = middle[0] + radius * math.cos(begin + sweep * k / n)
            place[second] = middle[1] + radius * math.sin(begin + sweep * k / n)
            places.append(place)
        places[-1] = to
        self._reach(places)

    def program(self, name: str, cuts: float = 1.0) -> Program:
        text = "\n".join([*self.rows, "M2", ""])
        return Program(name, text, np.array(self.places), np.array(self.motion), cuts)


def begun(depth: float = -3.0, feed: float = 1500.0) -> Pen:
    """Above the zero, the spindle on, and down."""
    pen = Pen()
    pen.line("G0", Z=5.0)
    pen.line("G0", X=0.0, Y=0.0)
    pen.say("M3 S1000")
    pen.line("G1", feed, Z=depth)
    return pen


def ended(pen: Pen, name: str, cuts: float = 1.0) -> Program:
    pen.line("G0", Z=5.0 + pen.shift[2])
    pen.say("M5")
    return pen.program(name, cuts)


def zigzag() -> Program:
    """3 mm to and fro, the feed in a block of its own before every motion."""
    pen = begun()
    for i in range(48):
        pen.say("F3000")
        pen.line("G1", X=1.5 * (i % 2) + 0.8 * i, Y=2.5 * (i % 2))
    return ended(pen, "zigzag")


def _wave(pen: Pen, step: float, feed: float, n: int, radius: float = 5.0) -> None:
    x = y = way = 0.0
    for i in range(n):
        way += step / radius * (1 if int(i * step / (radius * math.pi)) % 2 == 0 else -1)
        x, y = x + step * math.cos(way), y + step * math.sin(way)
        pen.line("G1", feed, X=x, Y=y)


def fine() -> Program:
    """Half circles in pieces of 0.1 mm at F1000: 6 ms a motion."""
    pen = begun()
    _wave(pen, 0.1, 1000, 700)
    return ended(pen, "fine")


def fast() -> Program:
    """Pieces of 0.5 mm at F5000: the machine is a planner's length behind the answers."""
    pen = begun()
    _wave(pen, 0.5, 5000, 420, 6.0)
    return ended(pen, "fast")


def no_block() -> Program:
    """Between motions words that make no block, and motions below a step of the motors, which are
    answered at once."""
    pen, r = begun(), random.Random(3)
    x = y = way = 0.0
    for i in range(320):
        way += 0.1 * (1 if i // 31 % 2 == 0 else -1)
        x, y = x + 0.4 * math.cos(way), y + 0.4 * math.sin(way)
        pen.line("G1", 3000, X=x, Y=y)
        below = f"G1 Z{r.choice(('-3.0004', '-3.0'))}"
        pen.say(*r.choice(([], ["G94"], ["F3000", "G90"], [below], ["M3"])))
    return ended(pen, "no block")


def slots() -> Program:
    """A slot in G2 and G3 at three depths."""
    pen = begun(-1.0)
    for depth in (-1.0, -2.0, -3.0):
        pen.line("G1", 800, Z=depth)
        for _ in range(2):
            pen.line("G1", 2000, X=20.0, Y=0.0)
            pen.arc("G3", (0.0, 4.0), X=20.0, Y=8.0)
            pen.line("G1", X=0.0, Y=8.0)
            pen.arc("G3", (0.0, -4.0), X=0.0, Y=0.0)
    return ended(pen, "slots")


def helix() -> Program:
    """A bore by whole turns, down 0.5 mm each."""
    pen = begun(0.0)
    pen.line("G1", 1800, X=6.0, Y=0.0)
    for turn in range(1, 9):
        pen.arc("G2", (-6.0, 0.0), X=6.0, Y=0.0, Z=-0.5 * turn)
    pen.arc("G2", (-6.0, 0.0), X=6.0, Y=0.0)
    pen.line("G1", X=0.0, Y=0.0)
    return ended(pen, "helix")


def inch() -> Program:
    """A contour in inches."""
    pen = Pen(["G20 G90 G94 G17", "G54"], INCH, digits=4)
    pen.line("G0", Z=5.08)
    pen.line("G0", X=0.0, Y=0.0)
    pen.say("M3 S1000")
    pen.line("G1", 1500, Z=-2.54)
    for i in range(60):
        angle = i * 0.21
        pen.line("G1", 2500, X=(4 + 0.2 * i) * math.cos(angle), Y=(4 + 0.2 * i) * math.sin(angle))
    pen.line("G0", Z=5.08)
    pen.say("M5")
    return pen.program("inch")


def increments() -> Program:
    """G91: every block counts from where the one before ended."""
    pen = begun()
    pen.say("G91")
    pen.relative = True
    for i in range(70):
        pen.line("G1", 2400, X=pen.at[0] + 0.7, Y=pen.at[1] + (1.9 if i % 2 else -1.7))
    pen.say("G90")
    pen.relative = False
    return ended(pen, "increments")


def surface() -> Program:
    """Three axes at once: rows over a wave, 0.4 mm a piece."""
    pen = begun(-1.0)
    for row in range(5):
        xs = [0.4 * i for i in range(46)]
        for x in xs if row % 2 == 0 else xs[::-1]:
            pen.line("G1", 1800, X=x, Y=0.6 * row, Z=-1.5 + math.sin(x / 3) * math.cos(row / 2))
    return ended(pen, "surface")


def holes() -> Program:
    """Pecks by G0 and G1, as a system writes them for a control without cycles."""
    pen = begun(2.0)
    for i in range(6):
        pen.line("G0", Z=2.0)
        pen.line("G0", X=5.0 * (i % 3), Y=6.0 * (i // 3))
        for depth in (-1.0, -2.0, -3.0):
            pen.line("G1", 600, Z=depth)
            pen.line("G0", Z=2.0)
            pen.line("G0", Z=depth + 0.3)
        pen.line("G1", 600, Z=-3.5)
        pen.line("G0", Z=2.0)
    return ended(pen, "holes")


def offsets() -> Program:
    """The same contour in G54 and in G55, which lies 20 mm off; dwells, coolant."""
    pen = begun()
    for shift, word in (((0.0, 0.0, 0.0), "G54"), ((20.0, 10.0, 0.0), "G55")):
        pen.line("G0", Z=5.0)
        pen.say(word, "M8", "G4 P0.2")
        pen.shift = shift
        pen.line("G0", X=0.0, Y=0.0)
        pen.line("G1", 900, Z=-3.0)
        for i in range(24):
            pen.line("G1", 2000, X=8 * math.sin(i * 0.8), Y=8 - 8 * math.cos(i * 0.5))
        pen.line("G0", Z=5.0)
        pen.say("M9")
    return ended(pen, "offsets")


def planes() -> Program:
    """Arcs in G18 and G19, and rapids between them."""
    pen = begun(0.0)
    for i in range(6):
        y = 2.0 * i
        pen.line("G0", Z=3.0)
        pen.line("G0", X=0.0, Y=y)
        pen.line("G1", 900, Z=0.0)
        pen.say("G18")
        pen.arc("G3" if i % 2 else "G2", (0.0, 4.0), 18, X=8.0, Z=0.0)
        pen.say("G17")
    pen.line("G1", 1500, X=12.0)
    pen.say("G19")
    pen.arc("G3", (-3.0, 0.0), 19, Y=pen.at[1] - 6.0, Z=0.0)
    pen.say("G17")
    return ended(pen, "planes", 4.5)


ALL: tuple[Callable[[], Program], ...] = (
    zigzag, fine, fast, no_block, slots, helix, inch, increments, surface, holes, offsets, planes,
)  # fmt: skip


def short(number: int) -> Program:
    """One of twenty jobs of pieces of 0.1 to 1 mm at F1000 to F5000."""
    r = random.Random(number)
    step, feed = round(r.uniform(0.1, 1.0), 2), r.choice((1000, 1500, 2000, 3000, 4000, 5000))
    pen = begun()
    _wave(pen, step, feed, min(900, int(6 * feed / 60 / step)), r.choice((4.0, 6.0, 9.0)))
    return ended(pen, f"{step} mm at F{feed}")
