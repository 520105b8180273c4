"""Random valid programs: what the laws are tried on.

One generator draws from any `random.Random`: from a seeded one for fixed examples, from hypothesis'
own for laws. It keeps its own account of the control's state in exact fractions, so every point
that it writes lies in its site.
"""

from __future__ import annotations

import math
import os
import random
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from hypothesis import strategies as st

INCH = Fraction(254, 10)
PLANES = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
CENTRE = {"X": "I", "Y": "J", "Z": "K"}
INCREMENT = {"X": "U", "Y": "V", "Z": "W"}
COMMENTS = ("", "TURN BACK", "X1 Y2 (", "g1 ; not a block", "100 % N5")


@dataclass(frozen=True)
class Site:
    """Where programs may go: slide range of each axis, mm; places to stop at; zeros of work
    offsets, mm and radius."""

    dialect: str
    ranges: Mapping[str, tuple[float, float]]
    nodes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    diameter: tuple[str, ...] = ()
    offsets: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Taste:
    """How awkward a program is. late: not every axis is placed at once; away: G28 and G53 in the
    middle; arcs: share of arcs among feeds; radius: mm, of the smallest; tiny: motions of
    micrometres, and small arcs as often as large ones; zero: motions that go nowhere; full: whole
    circles; helix: arcs that move the third axis too; codes: M and S words in motion blocks;
    layout: odd spacing, comments, several blocks in a line, CRLF; decimals: of axis words; sparse:
    share of motions that name their code; inverse: G93; modes: changes of G90 G20 G7 G17 G90.1
    ..."""

    blocks: int = 12
    late: bool = False
    away: bool = False
    arcs: float = 0.3
    radius: float = 0.3
    tiny: bool = False
    zero: bool = True
    full: bool = True
    helix: bool = True
    codes: bool = True
    layout: bool = True
    decimals: tuple[int, ...] = (0, 1, 2, 3, 3, 4, 4, 5, 6)
    sparse: float = 0.5
    inverse: bool = True
    modes: bool = True


def program(rng: random.Random, site: Site, taste: Taste = Taste()) -> bytes:
    """A valid program of about `taste.blocks` blocks."""
    return Writer(rng, site, taste).text()


def seeded(seed: int, site: Site, taste: Taste = Taste()) -> bytes:
    """The same program for the same seed."""
    return program(random.Random(seed), site, taste)


def dice() -> st.SearchStrategy[random.Random]:
    """What programs are drawn with. With GCOMP_FUZZ hypothesis draws every number, so that a
    program that fails shrinks towards few short blocks; else a seed alone, in a tenth of the
    time."""
    return st.randoms(use_true_random=not os.environ.get("GCOMP_FUZZ"))


def programs(site: Site, **taste) -> st.SearchStrategy[bytes]:
    """A hypothesis strategy of programs; `taste`: fields of Taste."""
    blocks = st.integers(1, taste.pop("blocks", 12))
    return st.builds(
        lambda rng, n: program(rng, site, Taste(blocks=n, **taste)),
        dice(),
        blocks,
    )


class Writer:
    """Writes one program; `place` is where the slides stand, mm in machine coordinates, None where
    not known."""

    def __init__(self, rng: random.Random, site: Site, taste: Taste):
        self.rng, self.site, self.taste = rng, site, taste
        self.fanuc = site.dialect == "fanuc-lathe"
        self.ranges = {
            a: (Fraction(str(low)), Fraction(str(high))) for a, (low, high) in site.ranges.items()
        }
        self.place: dict[str, Fraction | None] = dict.fromkeys(site.ranges)
        self.unit, self.by, self.absolute_centre = Fraction(1), False, False
        self.diameter = set(site.diameter)
        self.plane = "G18" if self.fanuc else "G17"
        self.planes = [code for code, letters in PLANES.items() if set(letters) <= set(site.ranges)]
        self.motion, self.inverse, self.fed, self.offset = "", False, False, "G54"
        self.lines: list[list[str]] = []

    def often(self, share: float) -> bool:
        # 0 is no: so examples shrink towards plain programs
        return self.rng.random() >= 1.0 - share

    # -- the course of a program -------------------------------------------------------------------

    def text(self) -> bytes:
        self.head()
        while len(self.lines) < self.taste.blocks:
            self.step()
        if self.often(0.5):
            end = self.rng.choice(("M30", "M2"))
            if (
                self.taste.codes
                and self.often(0.3)
                and self.lines[-1]
                and "G4" not in self.lines[-1]
            ):
                self.lines[-1].append(end)
            else:
                self.lines.append([end])
        return self.laid_out()

    def head(self) -> None:
        words = []
        if self.plane not in self.planes:
            self.plane = self.rng.choice(self.planes)
            words.append(self.plane)
        if words:
            self.lines.append(words)
        axes = list(self.ranges)
        self.rng.shuffle(axes)
        groups = [[axis] for axis in axes] if self.taste.late else [axes]
        for group in groups:
            self.straight(
                "G0" if len(groups) > 1 or self.often(0.8) else "G1", group, absolute=True
            )
            if self.taste.late and self.often(0.3):
                self.modes()

    def step(self) -> None:
        roll = self.rng.random()
        if roll < 0.12 and self.taste.modes:
            self.modes()
        elif roll < 0.18:
            self.lines.append([self.rng.choice(("M3", "M5", "M8", "M9", "M1"))])
        elif roll < 0.22:
            time = (
                self.rng.choice(("P500", "X2", "X.5", "U1.5"))
                if self.fanuc
                else self.rng.choice(("P0.5", "P1"))
            )
            self.lines.append(["G4", time])
        elif roll < 0.25:
            self.lines.append([])
        elif roll < 0.30 and self.taste.away:
            self.go_away()
        elif roll < 0.45:
            self.straight("G0")
        elif self.often(self.taste.arcs):
            self.arc()
        else:
            self.straight("G1")

    def modes(self) -> None:
        words = []
        if self.often(0.4):
            self.by = not self.by
            words.append("G91" if self.by else "G90")
        if self.often(0.3):
            self.unit = INCH if self.unit == 1 else Fraction(1)
            words.append("G20" if self.unit == INCH else "G21")
        if len(self.planes) > 1 and self.often(0.4):
            self.plane = self.rng.choice(self.planes)
            words.append(self.plane)
        if not self.fanuc and "X" in self.ranges and self.often(0.3):
            self.diameter = set() if "X" in self.diameter else {"X"}
            words.append("G7" if self.diameter else "G8")
        if not self.fanuc and self.often(0.3):
            self.absolute_centre = not self.absolute_centre
            words.append("G90.1" if self.absolute_centre else "G91.1")
        if self.taste.inverse and self.often(0.25):
            self.inverse, self.fed = not self.inverse, False
            words.append("G93" if self.inverse else "G94")
        if len(self.site.offsets) > 1 and self.often(0.3):
            self.offset = self.rng.choice(sorted(self.site.offsets))
            words.append(self.offset)
        if words:
            self.rng.shuffle(words)
            self.lines.append(words)

    def go_away(self) -> None:
        """G53, or home and back: by a rapid in absolute words, since a feed from nowhere is
        none."""
        axes = list(self.ranges)
        if self.often(0.5) and not self.by:
            if self.motion not in ("G0", "G1"):
                self.motion = "G0"
            words = ["G53", self.motion] if self.motion == "G0" else ["G53", self.motion, "F10"]
            for axis in axes:
                if self.often(0.7) or axis == axes[-1]:
                    word, self.place[axis] = self.word(
                        axis, self.goal(axis), self.decimals(), False, machine=True
                    )
                    words.append(word)
            self.lines.append(words)
            return
        axis = self.rng.choice(axes)
        if self.fanuc:
            self.lines.append(["G28", f"{INCREMENT[axis]}0"])
            self.place[axis] = None
        else:
            self.lines.append(["G28"])
            self.place = dict.fromkeys(self.place)
        self.straight("G0", [axis for axis, at in self.place.items() if at is None], absolute=True)

    # -- motions -----------------------------------------------------------------------------------

    def goal(self, axis: str) -> Fraction:
        """A place to go to: anywhere, near, the same, a node, an end."""
        low, high = self.ranges[axis]
        at, roll = self.place[axis], self.rng.random()
        if at is not None and (roll < 0.15 or (self.taste.tiny and roll < 0.6)):
            size = self.rng.choice((0.0001, 0.001, 0.002, 0.01, 0.1, 1.0))
            return min(max(at + Fraction(round(self.rng.uniform(-size, size), 6)), low), high)
        if at is not None and roll < 0.25 and self.taste.zero:
            return at
        if roll < 0.4 and self.site.nodes.get(axis):
            return Fraction(str(self.rng.choice(self.site.nodes[axis])))
        if roll < 0.45:
            return self.rng.choice((low, high))
        return low + (high - low) * self.rng.randint(0, 10**6) / 10**6

    def decimals(self) -> int:
        return self.rng.choice(self.taste.decimals)

    def scale(self, axis: str) -> Fraction:
        """mm of slide travel of one whole unit of an axis word."""
        return self.unit / (2 if axis in self.diameter else 1)

    def word(
        self, axis: str, goal: Fraction, decimals: int, by: bool, machine=False, letter=""
    ) -> tuple[str, Fraction]:
        """The word for an axis, rounded into its range, and where that leads."""
        zero = self.place[axis] if by else Fraction(0) if machine else self.zero(axis)
        low, high = self.ranges[axis]
        scale, step = self.scale(axis), Fraction(1, 10**decimals)
        value = round((goal - zero) / scale / step) * step
        while zero + value * scale > high:
            value -= step
        while zero + value * scale < low:
            value += step
        if zero + value * scale > high:
            return self.word(axis, goal, decimals + 1, by, machine, letter)
        return (letter or axis) + self.number(value, decimals), zero + value * scale

    def zero(self, axis: str) -> Fraction:
        return Fraction(str(self.site.offsets.get(self.offset, {}).get(axis, 0)))

    def number(self, value: Fraction, decimals: int) -> str:
        """A number in one of the ways in which people write it."""
        whole = str(abs(round(value * 10**decimals))).rjust(decimals + 1, "0")
        whole = whole[:-decimals] + "." + whole[-decimals:] if decimals else whole
        sign = "-" if value < 0 else self.rng.choice(("", "", "", "+")) if self.taste.layout else ""
        style = self.rng.randint(0, 5) if self.taste.layout else 0
        if style == 1 and "." in whole:
            whole = whole.rstrip("0")
        elif style == 2 and whole.startswith("0."):
            whole = whole[1:]
        elif style == 3 and "." not in whole:
            whole += "."
        elif style == 4:
            whole = "0" + whole
        return sign + whole

    def axis_words(
        self, axes, goals: Mapping[str, Fraction], absolute=False, decimals: int | None = None
    ) -> list[str]:
        words = []
        for axis in axes:
            digits = self.decimals() if decimals is None else decimals
            short = (
                self.fanuc and not absolute and self.place[axis] is not None and self.often(0.25)
            )
            by = (self.by and not absolute) or short
            text, self.place[axis] = self.word(
                axis, goals[axis], digits, by, letter=INCREMENT[axis] if short else ""
            )
            words.append(text)
        return words

    def straight(self, code: str, axes: list[str] | None = None, absolute=False) -> None:
        if axes is None:
            axes = [axis for axis in self.ranges if self.often(0.6)] or [
                self.rng.choice(list(self.ranges))
            ]
        words = []
        if absolute and self.by:
            self.by = False
            words.append("G90")
        self.block(
            code, words + self.axis_words(axes, {axis: self.goal(axis) for axis in axes}, absolute)
        )

    def block(self, code: str, words: list[str]) -> None:
        """A motion block: its code unless it holds, its F where it needs one, at times an M
        code."""
        if code != self.motion or self.often(self.taste.sparse):
            words.insert(
                self.rng.randint(0, len(words)) if self.often(0.2) else 0, self.spelled(code)
            )
        self.motion = code
        if code != "G0" and (self.inverse or not self.fed or self.often(0.2)):
            words.append(
                "F"
                + self.rng.choice(
                    ("5", "0.8", "12.5", "3.25") if self.inverse else ("100", "250.", "80.5")
                )
            )
            self.fed = True
        if self.taste.codes and self.often(0.1):
            words.append(self.rng.choice(("M3", "M5", "M8", "M9", "S800")))
        self.lines.append(words)

    def spelled(self, code: str) -> str:
        return code[0] + "0" + code[1:] if self.taste.layout and self.often(0.2) else code

    def arc(self) -> None:
        """An arc whose whole circle lies in the ranges; a straight line where there is none."""
        letters = PLANES[self.plane]
        start = [self.place[a] for a in letters]
        circle = None
        for _ in range(8):
            circle = circle or self.circle(letters, start)
        if circle is None:
            self.straight("G1")
            return
        arm, digits = circle
        centre = [p + a for p, a in zip(start, arm, strict=True)]
        radius, angle = math.hypot(*arm), math.atan2(-arm[1], -arm[0])
        code = self.rng.choice(("G2", "G3"))
        sweep = self.sweep()
        rest = [a for a in self.ranges if a not in letters and self.taste.helix and self.often(0.4)]
        if sweep is None:
            shown = [a for a in letters if self.often(0.3)]
            words = (
                self.axis_words(shown, dict(zip(letters, start, strict=True)), decimals=digits)
                if shown
                else []
            )
            if any(self.place[a] != s for a, s in zip(letters, start, strict=True)):
                shown, words = [], []  # it can not be said in so few digits
                self.place.update(zip(letters, start, strict=True))
            self.block(
                code,
                words
                + self.axis_words(rest, {a: self.goal(a) for a in rest})
                + self.centre(arm, centre, digits),
            )
            return
        end = angle + (sweep if code == "G3" else -sweep)
        goals = {
            a: Fraction(round(float(c) + radius * f(end), 9))
            for a, c, f in zip(letters, centre, (math.cos, math.sin), strict=True)
        }
        words = self.axis_words(letters, goals, decimals=digits)
        chord = math.dist([float(self.place[a]) for a in letters], [float(s) for s in start])
        if 0.001 < chord < 1.9 * radius and abs(sweep - math.pi) > 0.2 and self.often(0.4):
            r = Fraction(round(radius if sweep < math.pi else -radius, 9)) / self.unit
            centre_words = [
                "R" + self.number(round(r * 10**digits) * Fraction(1, 10**digits), digits)
            ]
        else:
            centre_words = self.centre(arm, centre, digits)
        self.block(
            code, words + self.axis_words(rest, {a: self.goal(a) for a in rest}) + centre_words
        )

    def sweep(self) -> float | None:
        """rad, or None for a full circle."""
        roll = self.rng.random()
        if roll < 0.15 and self.taste.full:
            return None
        if roll < 0.4:
            return math.radians(self.rng.choice((90, 180, 270, 45, 359.9, 0.5)))
        return math.radians(self.rng.uniform(1.0, 359.0))

    def circle(self, letters: str, start) -> tuple[list[Fraction], int] | None:
        """(from the start to the centre, decimals) of a circle within the ranges."""
        digits = (4 if self.unit == INCH else 3) + self.rng.choice((0, 0, 1, 2))
        room = min(float(high - low) for low, high in (self.ranges[a] for a in letters)) / 2
        least = self.taste.radius if self.taste.tiny else max(self.taste.radius, 0.05 * room)
        radius = 10 ** self.rng.uniform(math.log10(least), math.log10(0.9 * room))
        turn = (
            math.radians(self.rng.choice((0, 90, 180, 270)))
            if self.often(0.4)
            else self.rng.uniform(-3.2, 3.2)
        )
        step = self.unit / 10**digits
        arm = [round(Fraction(radius * f(turn)) / step) * step for f in (math.cos, math.sin)]
        radius = math.hypot(*arm)
        for a, p, r in zip(letters, start, arm, strict=True):
            low, high = self.ranges[a]
            if not float(low) + radius + 0.01 <= p + r <= float(high) - radius - 0.01:
                return None
        return (arm, digits) if radius >= self.taste.radius else None

    def centre(self, arm, centre, digits: int) -> list[str]:
        words = []
        for axis, a, c in zip(PLANES[self.plane], arm, centre, strict=True):
            if self.absolute_centre:
                value = (c - self.zero(axis)) / self.unit
                # exact where the start is: nine decimals hold every word of six
                text = f"{float(value):.9f}"
                words.append(CENTRE[axis] + text)
            elif a or all(v == 0 for v in arm) or self.often(0.5):
                words.append(CENTRE[axis] + self.number(a / self.unit, digits))
        return words

    # -- how it is laid out ------------------------------------------------------------------------

    def laid_out(self) -> bytes:
        """Lines to bytes, in one hand for the whole program."""
        if not self.taste.layout:
            return "".join(" ".join(words) + "\n" for words in self.lines).encode()
        rng = self.rng
        end = rng.choice(("\n", "\n", "\r\n"))
        # `;` at the end of blocks, at times several in a line
        ends = self.fanuc and self.often(0.4)
        numbered, spaced, lower = self.often(0.4), self.often(0.7), self.often(0.2)
        tape = self.often(0.15)
        text = "%" + end if tape else ""
        for i, words in enumerate(self.lines):
            last = i == len(self.lines) - 1
            line = self.one_line(list(words), (i + 1) * 10 if numbered else 0, spaced)
            line = line.lower() if lower else line
            if not ends:
                text += line + ("" if last and not tape and self.often(0.3) else end)
            elif self.often(0.3) and not last:
                text += line + rng.choice((";", "; "))
            else:
                text += line + ";" + ("" if last and not tape and self.often(0.3) else end)
        return (text + ("%" + end if tape else "")).encode()

    def one_line(self, words: list[str], number: int, spaced: bool) -> str:
        rng = self.rng
        if number and (words or self.often(0.5)):
            words.insert(0, f"N{number}")
        if spaced and self.often(0.15) and words:
            i = rng.randrange(len(words))
            words[i] = words[i][0] + rng.choice((" ", "\t", "  ")) + words[i][1:]
        if self.often(0.15):
            comment = rng.choice(COMMENTS).replace("(", "").replace("%", "pct")
            words.insert(rng.randint(0, len(words)), f"({comment})")
        line = (" " if spaced else "").join(words)
        if not self.fanuc and self.often(0.1):
            line += "; " + rng.choice(COMMENTS)
        if words and self.often(0.05):
            line = "/" + line
        return line + (" " if self.often(0.05) else "")
