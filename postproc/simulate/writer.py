"""Blocks of a test's program: slide positions in the words of one machine's control.

Words are from its work offset, diameters where it has them; waiting, comments, and what begins and
ends a program are as the control wants them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from postproc.errors import UsageError
from postproc.machine.model import Machine
from postproc.nc import dialects

XYZ = "XYZ"
# How the control is told to wait, by the first word of the dialect's name: 0 is s, 1 is ms, 2 is
# s that are whole, rounded up. Which controls have none, and why: tests/contracts/test_paces.py.
DWELL = {
    "linuxcnc": "G4 P{0:g}",
    "fanuc": "G4 X{0:.3f}",
    "haas": "G4 P{0:.3f}",
    "grbl": "G4 P{0:g}",
    "grblhal": "G4 P{0:g}",
    "fluidnc": "G4 P{0:g}",
    "siemens": "G4 F{0:g}",
    "heidenhain": "G4 F{0:g}",
    "marlin": "G4 S{0:g}",
    "reprap": "G4 S{0:g}",
    "centroid": "G4 P{0:g}",
    "klipper": "G4 P{1:.0f}",
    "smoothie": "G4 S{2:d}",
}
PLANES = {
    "XY": ("G17", "IJ", 1),
    "XZ": ("G18", "IK", -1),
    "YZ": ("G19", "JK", 1),
}  # sign: XYZ order against the plane's
OUTRUN = 1.0  # mm: an overrun where the travel has room for it


class Writer:
    """Blocks for one machine in one dialect, from slide positions."""

    def __init__(self, machine: Machine, dialect: str):
        self.machine, self.kind = machine, dialect.partition("-")[0]
        if self.kind not in DWELL:
            known = ", ".join(sorted(DWELL))
            raise UsageError(f"tests are not written for {dialect}", f"--dialect of one of {known}")
        self.dialect = dialects.load(dialect)
        codes = self.dialect.by_number
        # Millimetres, absolute words, feed per minute, as this control writes them; what it has
        # not, it always does.
        self.modes = [codes[number].word for number in (210, 900, 940) if number in codes]
        self.zero = machine.offsets.get("G54", {})
        # decimals of a word: 0.001 mm has three
        self.places = {x: -round(math.log10(a.least_increment)) for x, a in machine.axes.items()}
        self.lines: list[str] = []

    def begin(self, title: str) -> None:
        """What a program of this control begins with, and a rapid to the middle of all travels."""
        name = title.upper().replace("(", "").replace(")", "")
        offset = self.dialect.by_number.get(540)
        # words count from G54 where the machine states it; else they are machine coordinates
        framed = "G54" in self.machine.offsets and offset is not None and not offset.refuses
        modes = [*self.modes, "G54"] if framed else self.modes
        if self.kind == "fanuc" or self.kind == "haas":
            self.lines += ["%", "O0001"]
        if self.kind == "heidenhain":
            self.lines.append("%TEST G71")
        self.lines.append(f"({name})" if self.dialect.grammar.parentheses else f"; {name}")
        self.lines += modes if self.dialect.one_command else [" ".join(modes)]
        # Every slide is placed first: from there on it is known where the machine stands.
        self.lines.append(
            "G0 " + " ".join(self.word(x, v) for x, v in sorted(middle(self.machine).items()))
        )

    def word(self, axis: str, place: float) -> str:
        """The axis' word for a slide position."""
        # machine coordinates less the offset that the control adds; twice on a diameter axis
        value = (place - self.zero.get(axis, 0.0)) * (2.0 if axis in self.machine.diameter else 1.0)
        return f"{axis}{value:.{self.places[axis]}f}"

    def go(self, place: Mapping[str, float], feed: float) -> None:
        """A feed to slide positions, mm, at mm/min."""
        words = " ".join(self.word(x, place[x]) for x in sorted(place))
        self.lines.append(f"G1 {words} F{feed:g}")

    def rest(self, place: Mapping[str, float], feed: float) -> None:
        """To where axes stay, each from below, so that it is known from which side they came."""
        if place:
            # else the side of contact of a resting axis, and with it its reversal, would be unknown
            low = {x: max(v - OUTRUN, self.machine.axes[x].travel[0]) for x, v in place.items()}
            self.go(low, feed)
            self.go(place, feed)

    def stop(self, place: Mapping[str, float], feed: float, seconds: float) -> None:
        """To a place at which the machine rests."""
        self.go(place, feed)
        self.wait(seconds)

    def wait(self, seconds: float) -> None:
        """A dwell, s."""
        text = DWELL[self.kind].format(seconds, seconds * 1e3, math.ceil(seconds))
        self.lines.append(text)

    def arc(
        self,
        sense: int,
        plane: str,
        end: Mapping[str, float],
        arm: Mapping[str, float],
        feed: float,
    ) -> None:
        """An arc from where the tool is; sense +1 from the first letter of the plane to the second;
        arm: to the centre, mm."""
        if self.round_refused:
            raise UsageError(
                self.round_refused, "a diagonal shows squareness at rest: --test diagonal:" + plane
            )
        _, centre, sign = PLANES[plane]
        # G18 looks at the plane from +Y, where Z comes before X: from X to Z is clockwise there,
        # hence the sign of XZ.
        code = "G3" if sense * sign > 0 else "G2"
        ends = " ".join(self.word(x, end[x]) for x in plane)
        arms = " ".join(
            f"{c}{arm[x]:.{self.places[x]}f}" for c, x in zip(centre, plane, strict=True)
        )
        self.lines.append(f"{code} {ends} {arms} F{feed:g}")

    @property
    def round_refused(self) -> str:
        """Why circles of this control can not be read back; "" where they can."""
        code = self.dialect.by_number.get(20)
        return f"{self.dialect.name}: {code.refuses}" if code is not None and code.refuses else ""

    def text(self) -> str:
        """The program."""
        if self.kind == "heidenhain":
            title, comment, *blocks = self.lines
            return (
                "\n".join(
                    [
                        f"{title} *",
                        comment,
                        *(f"{b} *" for b in (*blocks, "M30")),
                        "N99999999 %TEST G71 *",
                    ]
                )
                + "\n"
            )
        # Marlin, Klipper: a program ends with its last line, and M30 would delete a file
        tail = [f"M{n}" for n in (30, 2) if n in self.dialect.ends][:1]
        tail += ["%"] if self.kind in ("fanuc", "haas") else []
        return "\n".join([*self.lines, *tail]) + "\n"


def ranges(machine: Machine, overrun: float) -> dict[str, tuple[float, float]]:
    """Axis to mm, low and high: what the tables cover and the travel leaves room for, an overrun
    beyond it."""
    result = {}
    for x, axis in machine.axes.items():
        if x not in XYZ:
            continue
        low, high = axis.travel
        if axis.table is not None:
            # within the tables as well: a program beyond them would be refused
            low, high = max(low, float(axis.table.nodes[0])), min(high, float(axis.table.nodes[-1]))
        low, high = max(low, axis.travel[0] + overrun), min(high, axis.travel[1] - overrun)
        if not np.isfinite(low + high) or high <= low:
            raise UsageError(
                f"{x} has no room for a test with {overrun:g} mm of overrun", "overrun=... smaller"
            )
        result[x] = (low, high)
    return result


def middle(machine: Machine, but: str = "") -> dict[str, float]:
    """Axis to mm: where it rests while others, those of `but`, are measured."""
    room = ranges(machine, OUTRUN)
    return {x: (low + high) / 2 for x, (low, high) in room.items() if x not in but}
