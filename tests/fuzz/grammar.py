"""Random programs in every dialect that use everything at once, and hypothesis strategies of them.

A program is a row of snippets: motions, arcs, frames, holes, cutter compensation, macros, text of all kinds. What a
snippet says is meant to be right most of the time, so that programs are followed to their end; what follows what is left
to chance. Coordinates lie in the ranges of laws.WIDE for as long as no shift takes them elsewhere.
"""

from __future__ import annotations

import math
import random
import re
from functools import reduce
from operator import xor

from hypothesis import strategies as st

from fuzz.laws import LATHES
from postproc.nc import dialects

MILL = {"X": (0.0, 190.0), "Y": (-55.0, 55.0), "Z": (-35.0, 35.0)}
LATHE = {"X": (0.0, 160.0), "Z": (0.0, 480.0)}
PLANES = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
CENTRE = {"X": "I", "Y": "J", "Z": "K"}
NGC = ("linuxcnc", "grblhal", "fluidnc")
FANUC = ("fanuc-mill", "haas", "fanuc-lathe", "fanuc-lathe-a", "fanuc-lathe-c", "haas-lathe")
PRINTERS = ("marlin", "reprap")
EXTREMES = (
    "0", "-0", "0.", "-.0", "1e3", "999999999999999999", "9999999999999999999", "123456789012345678", "0.000000000000000001",
    "-99999.9999", "1000000", ".5", "+.5", "00000000000000000000000001", "2147483648", "4294967296", "9223372036854775807",
    "1.0000000001", "0.00005", "12.34567890123456", "99999999", "-123456.789", "",
)  # fmt: skip
CODE = re.compile(r"(?<![A-Z])G0*(\d+(?:\.\d)?)(?![\d.])|\b([A-Z]{3,}\d*)\b")
COMMENTS = (
    "",
    "TURN BACK",
    "X1 Y2",
    "g1 x",
    "100 % N5",
    "A (B",
    "*12",
    "/",
    "GCOMP",
    "#1=2",
    "O100",
    "\xe4",
)
TEXT = (
    "(",
    ")",
    ";",
    "%",
    "/",
    "*",
    "\t",
    "\r",
    "\0",
    "[",
    "]",
    "#",
    "=",
    "\xff",
    '"',
    "<",
    ">",
    ",",
    ".",
    "-",
    "+",
    "N",
    "O",
)


def program(rng: random.Random, dialect: str, blocks: int = 12, wild: float = 0.05) -> bytes:
    """A program of about so many blocks. wild: share of things that are wrong on purpose."""
    return Writer(rng, dialect, wild).text(blocks)


def programs(dialect: str, blocks: int = 14, wild: float = 0.05) -> st.SearchStrategy[bytes]:
    """A hypothesis strategy of programs; shrinks towards few blocks."""
    return st.builds(
        lambda rng, n: program(rng, dialect, n, wild),
        st.randoms(use_true_random=False),
        st.integers(1, blocks),
    )


def every() -> list[str]:
    """The dialects that there are."""
    return dialects.names()


class Writer:
    """Writes one program. `at`: where the program thinks it stands, in mm, where it knows."""

    def __init__(self, rng: random.Random, dialect: str, wild: float):
        self.rng, self.dialect, self.wild = rng, dialect, wild
        self.lathe = dialect in LATHES
        self.ranges = LATHE if self.lathe else MILL
        self.fanuc, self.ngc, self.printer = dialect in FANUC, dialect in NGC, dialect in PRINTERS
        self.siemens, self.din = dialect == "siemens", dialect == "heidenhain-iso"
        self.system_a = dialect in ("fanuc-lathe-a", "haas-lathe")
        spoken = dialects.load(dialect)
        self.known = {re.sub(r"^G(?=\d)", "", code.word) for code in spoken.codes} | {
            name for name, _ in spoken.grammar.spellings
        }
        self.refused = {re.sub(r"^G(?=\d)", "", code.word) for code in spoken.codes if code.refuses}
        self.turns = spoken.turns
        self.scale = 1.0  # mm of a unit
        self.plane = "G18" if self.lathe else "G17"
        self.cycle = False
        self.lines: list[str] = []
        self.tail: list[str] = []
        self.number = 100

    # -- small things --------------------------------------------------------------------------------------------------

    def often(self, share: float) -> bool:
        return self.rng.random() >= 1.0 - share

    def one(self, *choices):
        return self.rng.choice(choices)

    def num(self, value: float, decimals: int | None = None) -> str:
        """A number as people write it; at times one that nobody would."""
        if self.often(self.wild / 8):
            return self.rng.choice(EXTREMES)
        digits = self.one(0, 1, 2, 3, 3, 3, 4, 4, 5, 6) if decimals is None else decimals
        text = f"{value:.{digits}f}"
        if "." not in text:
            text += self.one(".", ".", ".", "", ".0")
        elif self.often(0.2):
            text = text.rstrip("0")
        if self.often(0.1):
            text = (
                text.replace("0.", ".", 1)
                if text.startswith(("0.", "-0."))
                else "0" + text
                if text[0] != "-"
                else text
            )
        return text

    def word(self, letter: str, value: float, decimals: int | None = None) -> str:
        number = self.num(value, decimals)
        if self.siemens and letter in "XYZIJKF" and self.often(0.25):
            inner = number
            if letter in "XYZ" and self.often(0.3):
                inner = f"{self.one('AC', 'AC', 'IC')}({number})"
            return f"{letter}{self.one('=', ' = ', '=')}{inner}"
        return letter + number

    def factor(self, axis: str) -> float:
        return (2.0 if self.lathe and axis == "X" else 1.0) / self.scale

    def goal(self, axis: str) -> float:
        """mm in the axis' range."""
        low, high = self.ranges[axis]
        roll = self.rng.random()
        if roll < 0.1:
            return self.one(low, high)
        if roll < 0.3:
            return low + (high - low) * self.rng.randint(0, 8) / 8
        return self.rng.uniform(low, high)

    def axes(self) -> list[str]:
        return [a for a in self.ranges if self.often(0.6)] or [self.rng.choice(list(self.ranges))]

    def coordinates(self, axes=None, size: float | None = None) -> list[str]:
        """Axis words, absolute ones or, with a size, small ones."""
        words = []
        for a in self.axes() if axes is None else axes:
            value = self.goal(a) if size is None else self.rng.uniform(-size, size)
            words.append(self.word(a, value * self.factor(a)))
        return words

    def add(self, *words: str) -> None:
        """A line, unless it has a code that the dialect does not know, or one that it refuses: these come seldom."""
        line = (" " if self.spaced else "").join(w for w in words if w)
        for code in (number or word for number, word in CODE.findall(line.upper())):
            unknown = code not in self.known
            if (unknown or code in self.refused) and not self.often(
                self.wild / 2 if unknown else self.wild * 2
            ):
                return
        self.lines.append(line)

    def g(self, code: str) -> str:
        return code[0] + "0" + code[1:] if len(code) == 2 and self.often(0.25) else code

    def absolute(self) -> str:
        return "" if self.system_a else "G90"

    # -- the course of a program ---------------------------------------------------------------------------------------

    def text(self, blocks: int) -> bytes:
        rng = self.rng
        self.spaced, self.numbered = self.often(0.8), self.often(0.3)
        self.sealed = self.printer and self.often(0.4)
        if self.often(0.15) and not self.din:
            self.lines.append("%")
        if self.fanuc and self.often(0.3):
            self.lines.append("O0001" + self.one("", " (PART)"))
        if self.din and self.often(0.5):
            self.lines.append("%PART G71 *")
        if self.often(0.9):
            self.add(self.absolute(), self.g("G0"), *self.coordinates(self.ranges))
        snippets = self.snippets()
        names, weights = list(snippets), list(snippets.values())
        while len(self.lines) < blocks:
            rng.choices(names, weights)[0]()
            if self.often(self.wild / 3):
                self.spoil()
        if self.tail or self.often(0.4):
            self.add(self.one("M30", "M30", "M2", "M17" if self.siemens else "M2"))
            if self.often(0.3):
                self.lines.append(self.one("G1 X5 F100", "garbage )", "%", "#"))
        self.lines += self.tail
        return self.laid_out()

    def snippets(self) -> dict:
        result = {
            self.straight: 24, self.small: 6, self.arc: 14, self.modes: 8, self.quiet: 6, self.offset: 3, self.frame: 8,
            self.away: 3, self.stops: 3, self.beside: 3, self.dwell: 1, self.junk: 2,
        }  # fmt: skip
        if not self.printer and not self.din:
            result[self.holes] = 8
            result[self.thread] = 2
            result[self.turned] = 2
            result[self.macro] = 5
        if self.lathe:
            result[self.increments] = 10
        if self.printer:
            result[self.extrude] = 20
        if self.siemens:
            result[self.by_keyword] = 8
            result[self.polynomial] = 4
        if self.dialect in ("fagor", "okuma"):
            result[self.own] = 14
        return result

    def straight(self) -> None:
        code = self.one("G0", "G1", "G1", "G1", "")
        if self.printer and not code:
            code = "G1"
        feed = (
            ["F" + self.one("100", "250.", "0.5", "3.25")]
            if code == "G1" and self.often(0.8)
            else []
        )
        self.add(
            self.g(code) if code else "",
            *self.coordinates(),
            *feed,
            self.one("", "", "", "", "M3", "M8", "M5", "M9", "S100"),
        )

    def small(self) -> None:
        """Increments and tiny moves."""
        if self.system_a:
            self.add(
                "G1",
                *[
                    f"{u}{self.num(self.rng.uniform(-0.01, 0.01), 4)}"
                    for u in "UW"
                    if self.often(0.7)
                ],
                "F50",
            )
            return
        size = self.one(0.0004, 0.003, 0.05, 2.0, 0.0)
        self.add("G91", self.g("G1"), *self.coordinates(size=size), "F200")
        for _ in range(self.rng.randint(0, 3)):
            self.add("G1" if self.printer else "", *self.coordinates(size=size))
        if self.often(0.8):
            self.add("G90")

    def increments(self) -> None:
        words = []
        for axis, letter in (("X", "U"), ("Z", "W")):
            roll = self.rng.random()
            if roll < 0.5:
                words.append(self.word(letter, self.rng.uniform(-6, 6)))
            elif roll < 0.8:
                words.append(self.word(axis, self.goal(axis) * self.factor(axis)))
        self.add(self.one("", "G1", "G0"), *words)

    def arc(self) -> None:
        """Onto a known place, then an arc or circle from there."""
        letters = PLANES[self.plane]
        if set(letters) - set(self.ranges):
            self.plane = "G18"
            self.add("G18")
            letters = PLANES[self.plane]
        low, high = zip(*(self.ranges[a] for a in letters), strict=True)
        room = min(h - lo for lo, h in zip(low, high, strict=True)) / 2
        radius = 10 ** self.rng.uniform(-2.0 if self.often(0.2) else 0.0, math.log10(0.8 * room))
        middle = [
            self.rng.uniform(lo + radius, h - radius) for lo, h in zip(low, high, strict=True)
        ]
        begin = self.one(0, 90, 180, 270) if self.often(0.4) else self.rng.uniform(0, 360)
        sweep = (
            360.0
            if self.often(0.2)
            else self.one(90, 180, 270, 0.5, 359.9)
            if self.often(0.4)
            else self.rng.uniform(1, 359)
        )
        if self.often(0.5):
            sweep = -sweep
        digits = self.one(3, 4, 5)
        unit = [self.factor(a) for a in letters]
        spot = [
            [round((c + radius * f(math.radians(turn))) * u, digits) for c, f, u in zip(middle, (math.cos, math.sin), unit, strict=True)]
            for turn in (begin, begin + sweep)
        ]  # fmt: skip
        first = [a + self.num(v, digits) for a, v in zip(letters, spot[0], strict=True)]
        self.add(self.absolute(), self.g(self.one("G0", "G1")), *first, self.one("", "F80"))
        for _ in range(self.one(1, 1, 1, 2)):
            code = "G3" if sweep > 0 else "G2"
            end = (
                [a + self.num(v, digits) for a, v in zip(letters, spot[1], strict=True)]
                if abs(sweep) < 360 or self.often(0.4)
                else []
            )
            arm = [(c - s / u) / self.scale for c, s, u in zip(middle, spot[0], unit, strict=True)]
            other = [a for a in self.ranges if a not in letters and self.often(0.3)]
            words = end + self.coordinates(other)
            whole = abs(sweep) >= 360
            if not whole and abs(abs(sweep) - 180) > 1 and self.often(0.4):
                r = radius / self.scale * (1 if abs(sweep) < 180 else -1)
                words.append(f"CR={r:.{digits + 1}f}" if self.siemens else f"R{r:.{digits + 1}f}")
            elif self.din:
                self.add(
                    *[
                        CENTRE[a] + self.num(c * u, digits)
                        for a, c, u in zip(letters, middle, unit, strict=True)
                    ]
                )
            else:
                words += [
                    CENTRE[a] + self.num(v, digits) for a, v in zip(letters, arm, strict=True)
                ]
            if self.often(0.15 if self.turns else self.wild):
                count = (
                    self.one(1, 2, 3, 0, 99)
                    if not self.often(self.wild)
                    else self.one(100000, 999999999, 10**17)
                )
                words.append(f"TURN={count}" if self.siemens else f"P{count}")
            feed = self.one("", "F60", "F5")
            self.add(self.g(code), *words, feed)
            spot = [spot[1], spot[0]]
            begin, sweep = begin + sweep, -sweep
        if self.printer and self.lines and self.often(0.5):
            self.lines[-1] += " E1.5"

    def modes(self) -> None:
        codes = []
        if self.often(0.3) and not self.system_a:
            codes.append(self.one("G91", "G90", "G90"))
        if self.often(0.25):
            inch = self.often(0.5)
            self.scale = 25.4 if inch else 1.0
            if self.siemens or self.din:
                codes.append(
                    self.one("G70", "G700")[: 4 if self.siemens else 3]
                    if inch
                    else self.one("G71", "G710")[: 4 if self.siemens else 3]
                )
            else:
                codes.append("G20" if inch else "G21")
        if self.often(0.3) and not self.lathe:
            self.plane = self.rng.choice(list(PLANES))
            codes.append(self.plane)
        if self.often(0.3):
            codes.append(
                self.one("G94", "G93", "G95") if not self.system_a else self.one("G98", "G99")
            )
        if self.often(0.15):
            codes.append("DIAMON" if self.siemens else self.one("G7", "G8"))
        if self.often(0.1):
            codes.append("DIAMOF" if self.siemens else self.one("G91.1", "G91.1", "G90.1"))
        if self.often(0.1):
            codes.append(self.one("G98", "G99"))
        self.rng.shuffle(codes)
        if codes:
            self.add(*codes, "F20" if "G93" in codes else "")

    def stops(self) -> None:
        self.add(self.one("G61", "G64", "G61.1", "G60", "G602", "G64 P0.01", "G63"))
        if self.often(0.5):
            self.add(self.one("G9", "G9", "G60"), "G1", *self.coordinates(), "F100")

    def quiet(self) -> None:
        comment = self.rng.choice(COMMENTS)
        self.lines.append(
            self.one("M3 S500", "M5", "M8", "M9", "T1 M6", "T2", "T1", "T0101", "", " ", f"({comment})", "M1", "M0", "S200", "F77", "G40", "G80", "G49", "G94", "D1", "D0", "M6 T2")
            if not self.siemens
            else self.one("M3 S500", f"; {comment}", f'MSG("{comment}")', "T1 D1", "D0", "D2", "G64", "S1=300", "SPOS=0", "T=\"A\"", "", "FFWON")
        )  # fmt: skip

    def offset(self) -> None:
        self.add(
            self.one(
                "G54", "G55", "G56", "G57", "G59", "G59.1", "G59.3", "G54.1 P1", "G54.1 P2", "G54 P1", "G154 P1", "G110", "G500", "G505", "G54",
            ),
            *(self.coordinates() if self.often(0.3) else []),
        )  # fmt: skip

    def frame(self) -> None:
        shift = self.coordinates(size=self.one(0.001, 3.0, 20.0, 0.0))
        if self.siemens or (self.din and self.often(0.6)):
            self.add(
                self.one("TRANS", "TRANS", "ATRANS", "TRANS", "G58", "G53", "SUPA")
                if self.siemens
                else self.one("G54", "G53"),
                *(shift if self.often(0.85) else []),
            )
            if self.often(0.5) and not self.din:
                self.add("G91", *self.coordinates(size=1.0))
                self.add("G90")
            return
        set_here = "G50" if self.system_a else "G92"
        kind = self.rng.randint(0, 13)
        if kind <= 1:
            self.add("G52", *shift)
        elif kind <= 4:
            self.add(set_here, *self.coordinates())
        elif kind == 5:
            self.add(self.one("G92.1", "G92.2", "G92.3", "G52 X0 Z0", "G50.3"))
        elif kind <= 7:
            self.add(
                "G10",
                self.one("L2", "L2", "L20", "L20", "L1", "L10", "L11", "L50", "L3", ""),
                self.one("P1", "P0", "P2", "P3", "P6", "P9", "P10", "P1e18", "P99999999"),
                *shift,
                self.one("", "", "", "R1"),
            )
        elif kind <= 9:
            self.add(
                self.one("G43", "G43", "G44", "G43.2"),
                self.one("H1", "H2", "H0", "", "H7"),
                *(self.coordinates() if self.often(0.4) else []),
            )
        elif kind == 10:
            self.add("G43.1", *shift)
        elif kind == 11:
            self.add("G49", *(self.coordinates() if self.often(0.3) else []))
        elif kind == 12:
            self.add(self.one("G28.1", "G30.1", "G10.9"))
        else:
            self.add("G92", self.one("S1000", "E0", "X0", "X0 Y0 Z0"))
        if self.often(0.5):
            self.add(self.one("G0", "G1 F100"), *self.coordinates())

    def away(self) -> None:
        kind = self.rng.randint(0, 4)
        if kind <= 1:
            self.add(
                self.absolute(),
                self.one("G53", "G53", "SUPA" if self.siemens else "G53", "G153"),
                self.one("G0", "G1"),
                *self.coordinates(),
                "F100",
            )
        elif kind == 2:
            self.add(
                self.one("G28", "G30", "G74" if self.siemens else "G28"),
                *(self.coordinates() if self.often(0.5) else []),
            )
        elif kind == 3:
            self.add(
                self.one("G28 U0", "G28 W0", "G28 U0 W0")
                if self.lathe
                else self.one("G91 G28 Z0", "G28 X0 Y0", "G28 X Y", "G28")
            )
            if not self.lathe:
                self.add("G90")
        if self.often(0.85):
            self.add(self.absolute(), "G0", *self.coordinates(self.ranges))

    def beside(self) -> None:
        """Cutter radius compensation."""
        self.add(
            self.one("G41", "G42"),
            self.one("D1", "", "D2", "G1"),
            *self.coordinates(list(PLANES[self.plane])[:2] if not self.lathe else None),
            "F100",
        )
        for _ in range(self.rng.randint(1, 3)):
            self.one(self.straight, self.straight, self.arc)()
        if self.often(0.9):
            self.add("G40", self.one("G1", "G0"), *self.coordinates())

    def dwell(self) -> None:
        self.add("G4", self.one("P0.5", "X1", "F2", "S3", "U1.", "P500", "P0"))

    def holes(self) -> None:
        """A canned cycle with its holes; on a Sinumerik its own."""
        low, high = self.ranges["Z"]
        level, bottom = sorted(
            (self.rng.uniform(low, high), self.rng.uniform(low, high)), reverse=True
        )
        if self.siemens:
            name = self.one(
                "CYCLE81", "CYCLE82", "CYCLE83", "MCALL CYCLE81", "HOLES1", "CYCLE85", "CYCLE840"
            )
            self.add(
                f"{name}({self.num(high, 1)}, {self.num(level, 2)}, 1., {self.num(bottom, 2)})"
            )
            self.add(*self.coordinates("XY"))
            if "MCALL" in name:
                self.add("MCALL")
            return
        self.add(self.one("G0", "G0", "G1"), "Z" + self.num(high / self.scale, 2))
        if self.often(0.3) and not self.system_a:
            self.add("G91")
        code = self.one(
            "G81",
            "G81",
            "G82",
            "G83",
            "G73",
            "G85",
            "G86",
            "G89",
            "G84",
            "G74",
            "G87",
            "G88",
            "G76",
        )
        more = (
            [self.word("Q", self.rng.uniform(-0.5, 5) / self.scale)]
            if code in ("G83", "G73", "G87", "G76") or self.often(0.1)
            else []
        )
        if self.often(0.3):
            more.append(self.one("P0.5", "P1", "P500"))
        if self.often(0.2):
            more.append(
                self.one(
                    "L2", "L0", "K3", "K0", "L1", "L3", "L999999" if self.often(self.wild) else "L2"
                )
            )
        words = [
            f"Z{self.num(bottom / self.scale, 2)}",
            f"R{self.num(level / self.scale, 2)}",
            *more,
            "F100",
        ]
        self.rng.shuffle(words)
        self.add(
            *([] if self.system_a else [self.one("G98", "G99", "")]),
            code,
            *self.coordinates([a for a in self.ranges if a != "Z"]),
            *words,
        )
        for _ in range(self.rng.randint(0, 4)):
            self.add(*self.coordinates([a for a in self.ranges if a != "Z" and self.often(0.7)]),
                     self.word("R", self.rng.uniform(low, high)) if self.often(0.1) else "",
                     self.word("Z", self.rng.uniform(low, bottom)) if self.often(0.2) else "", self.one("", "", "", "L2", "G98", "G99", "L0"))  # fmt: skip
            if self.often(0.05):
                self.add(
                    self.one(
                        "G20",
                        "G92 X5",
                        "G91",
                        "G55",
                        "G18",
                        "(HERE)",
                        "M9",
                        "G52 X1",
                        "T1 M6",
                        "G43 H1",
                    )
                )
        self.add(self.one("G80", "G80", "G80", "G0", "G1", ""))
        if self.often(0.8) and not self.system_a:
            self.add("G90")

    def thread(self) -> None:
        kind = self.rng.randint(0, 3)
        if kind <= 1:
            self.add(
                self.one("G33", "G32", "G33.1", "G34"),
                "Z" + self.num(self.goal("Z")),
                self.one("K1.5", "F2.", "K1", ""),
            )
        elif kind == 2:
            self.add(
                "G76",
                self.one(
                    "P1 Z-10 I-1 J0.2 R1.5 K1 Q29 H3 E0.5 L2",
                    "P010060 Q100 R0.1",
                    "X20. Z-30. P1000 Q300 F2.",
                ),
            )
        else:
            self.add(
                self.one(
                    "G92 X20. Z10. F1.5",
                    "G71 U1. R0.5",
                    "G71 P10 Q20 U0.5 W0.1 F0.2",
                    "G72 W1 R1",
                    "G70 P10 Q20",
                    "G75 R1.",
                    "G94 X10 Z5",
                    "G90 X10 Z5",
                )
            )

    def turned(self) -> None:
        begin, end = self.one(
            ("G68 X10 Y10 R30", "G69"), ("G68 X0 Y0 R-90.", "G69"), ("G51 X0 Y0 P2", "G50"), ("G51.1 X0", "G50.1 X0"),
            ("G16", "G15"), ("G10 L2 P1 R15", "G10 L2 P1 R0"), ("ROT RPL=30", "ROT"), ("MIRROR X0", "MIRROR"), ("SCALE X2 Y2", "SCALE"),
            ("AROT Z45", "TRANS"), ("ROT Z30", "ROT"),
        )  # fmt: skip
        self.add(begin)
        for _ in range(self.rng.randint(1, 3)):
            self.one(self.straight, self.arc, self.holes)()
        self.add(end)

    def extrude(self) -> None:
        kind = self.rng.randint(0, 9)
        if kind <= 5:
            self.add(
                "G1",
                *self.coordinates(),
                "E" + self.num(self.rng.uniform(-1, 30), 5),
                self.one("", "F1200"),
            )
        elif kind == 6:
            self.add(
                self.one("M82", "M83", "G92 E0", "G92 E0", "T1", "T0", "M204 P500", "M92 X80 Y80")
            )
        elif kind == 7:
            self.add("G1", "E" + self.num(self.rng.uniform(-3, 3), 3), "F2400")
        elif kind == 8:
            self.lines.append(
                self.one(
                    "M117 G1 is (done",
                    "M104 S200",
                    "M106 S255",
                    "G28 X Y",
                    "G28",
                    "G29",
                    "M400",
                    "M110 N5",
                    "M110",
                    "M203 X",
                    "G4 P5",
                    "G10",
                    "G11",
                    'M98 P"x"',
                )
            )
        else:
            self.add(self.one("G2", "G3"), *self.coordinates("XY"), "I5 J5 E3")

    def by_keyword(self) -> None:
        self.add(
            self.one("DIAMON", "DIAMOF", "DIAM90", "G500", "CFC", "STOPRE", "CIP", "CT", "ROT", "TRANS X=5", "ATRANS Z-1", "LIMS=2000", "SOFT",
                     "G1 X=IC(0.5) Y=AC(10) F=200", "G0 Z=IC(-1)", "G91 X=AC(5) Y1", "G90", "G111 X0 Y0", "G641 ADIS=0.5", "CYCLE832(0.01,1)",
                     "G1 A=DC(90)", "G2 X=IC(10) Y=IC(0) CR=5", "G3 X20 Y20 I=AC(15) J=AC(15)", "G1 X1=5", "X = 5", "G4 F1", "RND=2", "CHF=1"),
        )  # fmt: skip

    def polynomial(self) -> None:
        """POLY of a Sinumerik: ends with their coefficients, at times a denominator, and back to lines."""
        words = []
        for a in self.axes():
            more = ",".join(
                self.num(self.rng.uniform(-8, 8), 2) for _ in range(self.rng.randint(0, 4))
            )
            words.append(f"PO[{a}]=({self.num(self.goal(a))}{',' if more else ''}{more})")
        if self.often(0.2):
            words.append(
                f"PO[]=({self.num(self.rng.uniform(0.5, 3), 2)},{self.num(self.rng.uniform(-0.3, 0.3), 2)})"
            )
        if self.often(0.5):
            words.append(
                "PL=" + self.one("1", "2.5", "0.1", "10", "0" if self.often(self.wild) else "4")
            )
        self.add(self.one("POLY", "POLY", "G1 POLY"), *words, self.one("", "F200"))
        if self.often(0.4):
            self.add(*words)
        if self.often(0.8):
            self.add("G1", *self.coordinates(), "F100")

    def own(self) -> None:
        """What only a Fagor or an Okuma writes: offsets and lengths by their names, holes with their own words, remarks."""
        low, high = self.ranges["Z"]
        level, bottom = sorted(
            (round(self.rng.uniform(low, high), 2) for _ in range(2)), reverse=True
        )
        at = self.coordinates("XY")
        if self.dialect == "fagor":
            lines = (
                ["G0 #MCS", "Z" + self.num(high)], ["#MCS", *at, "F90"], ["G0 Z" + self.num(high), "D1"], ["T1 D1"], ["D2"],
                ['(MSG "PART")'], ["#HSC ON [E0.01]"], ["G5"], ["G7"], ["G51 A5 E0.02"], ["P1=5"], ["(RPT N10,N20)"],
                ["G36 R2"], ["#RTCP ON"], [self.one("G98", "G99"), "G81", *at, f"Z{level} I{bottom} K1 F100"],
                ["G98 G83", *at, f"Z{level} I-{self.num(self.rng.uniform(0.5, 9), 2)} J{self.rng.randint(0, 5)} F100"],
                ["G99 G85", *at, f"Z{level} I{bottom} F100"],
            )  # fmt: skip
        else:
            lines = (
                ["G15 H1"], ["G15 H2"], ["G56 H1"], ["G53"], [f"G71 Z{high}"], ["CALL OO88 PX=0"], ["VC1=5"], ["NOEX VC2=1"],
                ["G30 P1"], ["G0 X9999 Y9999"], ["G0 Z400"], ["M130"], ["G56 HA"],
                ["G81", *at, f"Z{bottom} R{level} F100", self.one("M52", "M53", "M54", "")],
                ["G83", *at, f"Z{bottom} R{level} Q{self.num(self.rng.uniform(0.2, 9), 2)} F100 M53"],
                ["G73", *at, f"Z{bottom} R{level} I{self.num(self.rng.uniform(0.2, 9), 2)} J20 F100 M54"],
                ["NCYL G82", *at, f"Z{bottom} R{level} P1 F100"],
            )  # fmt: skip
        chosen = self.rng.choice(lines)
        self.add(*chosen)
        if chosen[0][-3:-1] == "G8" or chosen[0] in ("G81", "G83", "G73", "NCYL G82"):
            for _ in range(self.rng.randint(0, 2)):
                self.add(*self.coordinates("XY"))
            self.add("G80")

    def macro(self) -> None:
        """Variables, loops and calls: refused as they are, written out under --expand."""
        self.number += 1
        n = self.number
        step = self.one("1", "2.5", "0.1")
        if self.siemens:
            body = [f"G1 X=R{1} Y=R2*2 F100"]
            self.lines += self.one(
                [f"R1={step}", "R2=SIN(30)*10", *body],
                ["R1=0", "WHILE R1<3", *body, f"R1=R1+{step}", "ENDWHILE"],
                ["FOR R1=1 TO 4", *body, "ENDFOR"],
                ["R1=0", f"LB{n}:", *body, "R1=R1+1", f"IF R1<3 GOTOB LB{n}"],
                ["R1=5", "IF R1==5", *body, "ELSE", "G0 X0", "ENDIF"],
                ["DEF REAL LEN=12.5", "G1 X=LEN F50"],
                [f"LA{n}:", "G91 G1 X1 F100", "G90", f"REPEAT LA{n} P=2"],
                ["LOOP", "G91 G1 X.1 F9", "ENDLOOP"],
                ["R1=0", "REPEAT", *body, "R1=R1+1", "UNTIL R1>=2"],
                [f"GOTOF LZ{n}", "G1 X999999", f"LZ{n}:"],
                ["R1=$AA_IW[X]", "G1 X=R1+1 F10"], ["G1 X=" + "(" * 30 + "1" + ")" * 30 + " F10"],
                ["CASE 2 OF 1 GOTOF A1 2 GOTOF A2 DEFAULT GOTOF A2", "A1:", "A2:"],
            )  # fmt: skip
        elif self.fanuc:
            body = ["G1 X[#1*2] F100"] if self.lathe else ["G1 X#1 Y[#1+1] F100"]
            sub = [f"O{n}0", "G1 X[5+#24]" if self.often(0.5) else "G1 X5. F100", "M99"]
            which = self.rng.randint(0, 7)
            if which == 0:
                self.lines += [f"#1={step}", *body]
            elif which == 1:
                self.lines += ["#1=0", "WHILE [#1 LT 3] DO1", *body, f"#1=#1+{step}", "END1"]
            elif which == 2:
                self.lines += ["#1=0", f"N{n}0", *body, "#1=#1+1", f"IF [#1 LT 2] GOTO {n}0"]
            elif which == 3:
                self.lines += [
                    f"M98 P{n}0" + self.one("", " L2", "L999999" if self.often(self.wild) else "")
                ]
                self.tail += sub
            elif which == 4:
                self.lines += [f"G65 P{n}0 X{step} A1"]
                self.tail += sub
            elif which == 5:
                self.lines += [
                    "IF [#1 EQ #0] THEN #2=5",
                    "#3=ATAN[1]/[2]+SQRT[ABS[-4]]",
                    "G1 X#3 F100",
                ]
            elif which == 6:
                self.lines += ["#1=" + "[" * 20 + "1" + "]" * 20, *body]
            else:
                self.lines += (
                    ["#5=#5041", "G0 X[#5+1]", "WHILE[1 EQ 1]DO1", "G91G1X.1F1", "END1"]
                    if self.often(0.3)
                    else ["#5=#5041", "G0 X[#5+1]"]
                )
        else:
            body = ["G1 X#1 Y[#1 * 2] F100"]
            self.lines += self.one(
                [f"#1={step}", *body],
                ["#1=0", f"o{n} while [#1 LT 3]", *body, f"#1=[#1+{step}]", f"o{n} endwhile"],
                [f"o{n} sub", "G1 X[#1] F100", f"o{n} endsub", f"o{n} call [5] [6]"],
                [f"o{n} repeat [3]", "G91 G1 X0.5 F50", f"o{n} endrepeat", "G90"],
                [f"o{n} if [#5420 GT 5]", *body, f"o{n} else", "G0 X1", f"o{n} endif"],
                ["#<len>=12.5", "G1 X#<len> F50"],
                ["#1=0", f"o{n} do", *body, "#1=[#1+1]", f"o{n} while [#1 LT 2]"],
                [f"o{n} while [1]", "G91 G1 X.001 F50", f"o{n} endwhile"],
                ["G1 X[SIN[30]*10] Y[2**3 MOD 5] F10"],
                ["G1 X" + "[" * 30 + "1" + "]" * 30 + " F10"],
                ["#1=3 #1=4 G1 X#1 F10"], [f"o<a{n}> sub", f"o<a{n}> endsub", f"o<a{n}> call"], ["#5221=3", "G1 X0 F10"],
                ["G0 X[#5420+1] Y[#5421]"],
            )  # fmt: skip

    def junk(self) -> None:
        roll = self.rng.random()
        if roll > 1 - 6 * self.wild:
            self.lines.append(
                self.one(
                    "G1 X1 X2",
                    "G1 G0 X5",
                    "X Y",
                    "G999",
                    "M999",
                    "G5 X1",
                    "G2 X1 Y1",
                    "G2 I0 J0",
                    "G2 X5 R0.001",
                    "Q5",
                    "E5",
                    "A5",
                    "G1 X--5",
                    "G1 X1.2.3",
                    "GCOMP",
                    "G1.5 X2",
                    "X1O",
                    "G1X 1 0 Y\t5",
                    "N5",
                    "O5",
                    "/",
                    "//G1X1",
                    "G3 P2 I5",
                    "$H",
                    ":1234",
                    "G1 X5,R2",
                    "G1X5 F0",
                    "G1 X5 F-1",
                    "G53 X5",
                    "G80 X5",
                    "G28 X5 G1 Y5",
                    "G92 G1 X5",
                    "G10",
                    "G41",
                    "G90 G91 X1",
                    "G20 G21 X1",
                    "M2",
                    "%",
                )
            )

    def spoil(self) -> None:
        """Something into a line that was right."""
        if not self.lines:
            return
        i = self.rng.randrange(len(self.lines))
        line = self.lines[i]
        at = self.rng.randint(0, len(line))
        self.lines[i] = (
            line[:at]
            + self.rng.choice((*TEXT, *EXTREMES, "G1", "X5"))
            + line[at + self.one(0, 0, 1) :]
        )

    # -- layout --------------------------------------------------------------------------------------------------------

    def laid_out(self) -> bytes:
        rng = self.rng
        end = self.one("\n", "\n", "\n", "\r\n")
        stop = "*" if self.din else ";" if self.fanuc and self.often(0.3) else ""
        lower = self.often(0.1)
        mixed = self.often(self.wild)
        out = ""
        for i, line in enumerate(self.lines):
            line = line.lower() if lower else line
            bare = line.strip()
            label = line[:1] in "%oO:#" or bare.endswith(":")
            if self.numbered and bare and not label:
                line = f"N{(i + 1) * 10}{' ' if self.spaced else ''}{line}"
            if self.sealed and bare and "*" not in line and "(" not in line:
                line = f"N{i + 1} {line}"
                line += f"*{reduce(xor, line.encode('latin-1'), 0)}"
            if bare and self.often(0.08) and not label and not self.sealed:
                comment = rng.choice(COMMENTS)
                line += (
                    f" ;{comment}"
                    if (self.siemens or self.ngc or self.printer) and self.often(0.6)
                    else ""
                    if self.siemens
                    else f"({comment.replace('(', '')})"
                )
            if bare and self.often(0.04) and not label:
                line = "/" + line
            if stop and line[:1] != "%" and self.often(0.9):
                line += stop
            if stop == ";" and self.often(0.2):
                out += line + " "
                continue
            if mixed and self.often(0.2):
                end = self.one("\n", "\r\n", "\r")
            out += line + (end if i + 1 < len(self.lines) or self.often(0.8) else "")
        return out.encode("latin-1")
