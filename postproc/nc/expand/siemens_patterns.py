"""Sinumerik's patterns of holes, at each place of which the cycle that MCALL named is called:
HOLES1 (a row), HOLES2 (a circle), CYCLE801 (a grid), CYCLE802 (any places).

Source: Siemens "SINUMERIK 840D sl / 828D", Programming Manual Job Planning, "Programming cycles
externally"; d-creations/ncplot7py (its Siemens cycles) has the same places. The control takes the
holes of a row, a circle or a grid in the order that saves travel; here they come in the order of
the pattern, from the end at which the tool stands: the places are the same.
"""

from __future__ import annotations

import math

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_cycle import Cycle
from postproc.nc.expand.tracker import Tracker, number

Place = tuple[float, float]
PLACES_802 = " ".join(f"X{n} Y{n}" for n in range(9))
OPTIONAL = {"STA1", "FDIS", "INDA"}  # 0 where the call leaves them out
AXES = {170: "XY", 180: "ZX", 190: "YZ"}
DIGIT = {170: 1, 180: 2, 190: 3}  # of _DMODE
ABSOLUTE = "111111111"  # of _XA and _YA: nine places as coordinates
MOST_HOLES = 10_000
WRITE_OUT = "write the places as blocks of their own behind MCALL"
NAMES = {
    "HOLES1": "SPCA SPCO STA1 FDIS DBH NUM _VARI _UMODE _HIDE _NSP _DMODE",
    "HOLES2": "CPA CPO RAD STA1 INDA NUM _VARI _UMODE _HIDE _NSP _DMODE",
    "CYCLE801": "SPCA SPCO STA1 DIS1 DIS2 NUM1 NUM2 _VARI _UMODE _ANG1 _ANG2 _HIDE _NSP _DMODE",
    "CYCLE802": f"_XA _YA {PLACES_802} _VARI _UMODE _ROT _HIDE _NSP _DMODE",
}


class Pattern(Cycle):
    """A call with its values."""

    words = NAMES
    advice = WRITE_OUT

    def check(self) -> None:
        own = (word for word in self.words[self.name].split() if not word.startswith("_"))
        if self.name != "CYCLE802":
            self.needs(" ".join(word for word in own if word not in OPTIONAL))

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """A block in rapid traverse to each place. Raises Refusal."""
        plane = tracker.code("plane")
        self._check(plane)
        axes = AXES[plane]
        if any(tracker.is_diameter(axis, distance=False) for axis in axes):
            raise Refusal(f"{self.name} in diameters", "write DIAMOF before it")
        relative = tracker.code("distance") == 910
        words = []
        for place in self._ordered(*(tracker.work(axis) for axis in axes)):
            texts = (number(v, tracker.decimals(axis)) for v, axis in zip(place, axes, strict=True))
            ends = (
                f"{axis}=AC({text})" if relative else f"{axis}{text}"
                for axis, text in zip(axes, texts, strict=True)
            )
            words.append(f"G0 {' '.join(ends)}".encode())
        return words

    def _check(self, plane: int) -> None:
        """Values that ask for something else than what is written out. Raises Refusal."""
        wrong = {
            word: value
            for word, value in self.given.items()
            if word in ("_VARI", "_UMODE", "_ANG1", "_ANG2", "_ROT", "_NSP") and value
        }
        if self.given.get("_DMODE", 0) % 10 not in (0, DIGIT[plane]):
            wrong["_DMODE"] = self.given["_DMODE"]
        for word in ("_XA", "_YA"):
            if self.name == "CYCLE802" and f"{self.given.get(word, 0):.0f}" != ABSOLUTE:
                wrong[word] = self.given.get(word, 0)
        if wrong:
            values = ", ".join(f"{word}={value:.10g}" for word, value in wrong.items())
            raise Refusal(f"{self.name} in a way that is not written out ({values})", WRITE_OUT)

    def _count(self, word: str) -> int:
        value = self.given[word]
        if value != int(value) or not 1 <= value <= MOST_HOLES:
            raise Refusal(
                f"{word} of {self.name} is {value:g}", f"a whole number, 1 to {MOST_HOLES:,}"
            )
        return int(value)

    def _ordered(self, a: float | None, b: float | None) -> list[Place]:
        """The places, from the end of the pattern that is nearer."""
        found = {
            "HOLES1": self._row,
            "HOLES2": self._circle,
            "CYCLE801": self._grid,
            "CYCLE802": self._list,
        }[self.name]()
        # a circle and a list have no second end to begin at
        nearest = (found[0], found[-1]) if self.name in ("HOLES1", "CYCLE801") else found[:1]
        if a is not None and b is not None and nearest[-1] != nearest[0]:
            first, last = (math.dist((a, b), place) for place in nearest)
            return found[::-1] if last < first else found
        return found

    #            .o   NUM, DBH apart        _circle: NUM on RAD about CPA CPO, the first at STA1,
    #         .o'                           INDA apart, or evenly where that is 0
    #      .o'  FDIS to the first           _grid: NUM1 by NUM2, DIS1 and DIS2 apart, turned by
    #    .'  STA1                           STA1 about SPCA SPCO
    #   SPCA SPCO
    def _row(self) -> list[Place]:
        g, angle = self.given, math.radians(self.given.get("STA1", 0.0))
        ways = (g.get("FDIS", 0.0) + i * g["DBH"] for i in range(self._count("NUM")))
        return [
            (g["SPCA"] + way * math.cos(angle), g["SPCO"] + way * math.sin(angle)) for way in ways
        ]

    def _circle(self) -> list[Place]:
        g, count = self.given, self._count("NUM")
        if g["RAD"] <= 0:
            raise Refusal(f"RAD of HOLES2 is {g['RAD']:g}", "the radius is above 0")
        step = g.get("INDA", 0.0) or 360.0 / count
        angles = (math.radians(g.get("STA1", 0.0) + i * step) for i in range(count))
        return [
            (g["CPA"] + g["RAD"] * math.cos(t), g["CPO"] + g["RAD"] * math.sin(t)) for t in angles
        ]

    def _grid(self) -> list[Place]:
        """Row by row, to and fro."""
        g, angle = self.given, math.radians(self.given.get("STA1", 0.0))
        columns, rows = self._count("NUM1"), self._count("NUM2")
        if columns * rows > MOST_HOLES:
            raise Refusal(f"{columns * rows} holes in CYCLE801", f"{MOST_HOLES:,} are possible")
        cos, sin = math.cos(angle), math.sin(angle)
        found = []
        for row in range(rows):
            for i in range(columns):
                # every second row from its far end
                u = g["DIS1"] * (columns - 1 - i if row % 2 else i)
                v = g["DIS2"] * row
                found.append((g["SPCA"] + u * cos - v * sin, g["SPCO"] + u * sin + v * cos))
        return found

    def _list(self) -> list[Place]:
        """The places that have both coordinates."""
        g, found = self.given, []
        for n in range(9):
            here = [g[word] for word in (f"X{n}", f"Y{n}") if word in g]
            if len(here) == 1:
                raise Refusal(f"place {n} of CYCLE802 has one coordinate", "write both")
            if here:
                found.append((here[0], here[1]))
        if not found:
            raise Refusal("CYCLE802 without a place", "write X0 and Y0")
        return found
