"""What every snippet of a random program is made of: numbers, words, places, lines."""

from __future__ import annotations

import random
import re

from fuzz.cases import LATHES
from postproc.nc import dialects

MILL = {"X": (0.0, 190.0), "Y": (-55.0, 55.0), "Z": (-35.0, 35.0)}
LATHE = {"X": (0.0, 160.0), "Z": (0.0, 480.0)}
PLANES = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
CENTRE = {"X": "I", "Y": "J", "Z": "K"}
NGC = ("linuxcnc", "grblhal", "fluidnc")
FANUC = ("fanuc-mill", "haas", "fanuc-lathe", "fanuc-lathe-a", "fanuc-lathe-c", "haas-lathe")
PRINTERS = ("marlin", "reprap")
EXTREMES = (
    "0",
    "-0",
    "0.",
    "-.0",
    "1e3",
    "999999999999999999",
    "9999999999999999999",
    "123456789012345678",
    "0.000000000000000001",
    "-99999.9999",
    "1000000",
    ".5",
    "+.5",
    "00000000000000000000000001",
    "2147483648",
    "4294967296",
    "9223372036854775807",
    "1.0000000001",
    "0.00005",
    "12.34567890123456",
    "99999999",
    "-123456.789",
    "",
)
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


class Words:
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

    # -- small things ------------------------------------------------------------------------------

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
        """A line, unless it has a code that the dialect does not know, or one that it refuses:
        these come seldom."""
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
