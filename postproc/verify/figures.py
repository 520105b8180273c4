"""What a verification found: its figures, whether they keep the tolerance, and both in one line for
a person."""

from __future__ import annotations

import numpy as np

from postproc.filter import Filter
from postproc.machine.uncertainty import AlongPath
from postproc.units import UM, URAD
from postproc.verify.cutter import CentreVerifier
from postproc.verify.largest import Largest

SEEN = 0.005 * UM  # less is said as 0.00, and has no ratio


class Figures:
    """corrected, uncorrected: of both programs so far; motions_in, motions_out: how many they
    have."""

    def __init__(self, filter_: Filter):
        self.machine, self.mode = filter_.machine, filter_.compensator.mode
        self.settings = filter_.compensator
        self.tolerance = filter_.compensator.tolerance
        self.follows, self.hysteresis = filter_.compensator.follows, filter_.compensator.hysteresis
        # whether the sides of an axis move the others
        self.couples = self.follows and self.machine.lateral > 0
        # mm, larger in inch blocks
        self.grid = max(axis.least_increment for axis in self.machine.axes.values())
        self.corrected, self.uncorrected = Largest(), Largest()
        self.hole_tolerance = filter_.compensator.hole_tolerance
        # how far axes of holes stay off sideways, whose cycle holds its place
        self.holes, self.taps = Largest(), Largest()
        self.map = AlongPath(self.machine)
        # inside cutter radius compensation, where the centre is not followed; the same uncorrected
        self.at_contour, self.as_written = Largest(), Largest()
        self.centre = CentreVerifier(self.machine, self.follows)
        self.oriented = filter_.options.orientation and bool(self.machine.chain.rotary)
        self.tips = False  # whether any motion was one of the tip
        self.splines = False  # whether any was a control point
        self.compared = False  # whether any place of the path is known
        self.motions_in = self.motions_out = 0

    @property
    def allowed(self) -> float:
        """mm, of the largest increment of the program (Settings.allowed), where no axis that turns
        back moves the others."""
        return float(self.settings.allowed(np.array(self.grid)))

    @property
    def spread(self) -> float:
        """mm: what axes that turn back may leave at most until their reversal is taken up."""
        return self.machine.reversals if self.follows else 0.0

    @property
    def let_pass(self) -> float:
        """mm, where the largest deviation is."""
        by_choice = self.spread if self.mode in ("ramp", "off") else 0.0
        return self.allowed + self.corrected.aside + by_choice

    @property
    def passed(self) -> bool:
        """Whether the output keeps the tolerance; ramp and off spread reversals by choice, and
        leave no more than these. What stays inside cutter radius compensation, where nothing may be
        put in, is only measured: there it must not get worse. A hole and a tap may stay off by what
        their axis bends, beyond what may be left anywhere."""
        self.centre.finish()
        centre = self.centre
        # where nothing may be put in, an axis that turns back leaves what it left before: not worse
        # is enough
        better = all(
            now.deviation <= max(self.allowed, before.deviation)
            for now, before in (
                (centre.corrected, centre.uncorrected),
                (self.at_contour, self.as_written),
            )
        )
        # rounding of words is let pass as for the rest: allowed less tolerance
        by_choice = self.spread if self.mode in ("ramp", "off") else 0.0
        most = self.hole_tolerance + self.allowed - self.tolerance + by_choice
        holes = self.holes.deviation <= most
        holes &= max(self.holes.rest, self.taps.rest) <= self.allowed + self.spread
        return bool(better and holes and self.corrected.rest <= self.allowed + by_choice)

    @property
    def blind(self) -> bool:
        """Whether there are motions and errors, and nothing could be compared."""
        return bool(self.motions_in) and not (self.compared or self.machine.is_zero)

    def report(self) -> str:
        """One line for a person: before, after, and their ratio."""
        return _line(self)


def _line(v: Figures) -> str:
    """One line for a person: before, after, and their ratio."""
    counts = f"{v.motions_in} motions in, {v.motions_out} out"
    if v.blind:
        axes = " ".join(v.machine.letters[row] for row in v.machine.chained)
        return (
            f"nothing: no place of the path is known in all of {axes}, and"
            f" none was compared (--start says where the program begins); {counts}"
        )
    before, after = v.uncorrected.deviation, v.corrected.deviation
    ratio = f", {before / after:.0f} times less" if before > after > SEEN else ""
    return (
        f"largest deviation from the nominal path {after / UM:.2f} um{_at(v.corrected.line)},"
        f" uncorrected {before / UM:.2f} um{_at(v.uncorrected.line)}{ratio}{_lost_motion(v)};"
        f" tolerance {v.tolerance / UM:g} um{_above(v)}; {counts}"
        f"{_of_holes(v)}{_of_splines(v)}{_beside(v)}{_of_lean(v)};"
        f" {v.map.report()}"
    )


def _above(v: Figures) -> str:
    """Why more than the tolerance may be left, where it is."""
    if not v.tolerance < v.corrected.deviation <= v.let_pass:
        return ""
    said = f" (let pass, where slides turn back and by rounding: {v.let_pass / UM:.2f} um"
    if (more := v.corrected.rest - v.allowed) > 0:
        said += f"; in line {v.corrected.rest_line} {more / UM:.2f} um more than that there"
    return said + ")"


def _at(line: int) -> str:
    """The line, where there is one: nothing is off anywhere on a machine without errors."""
    return f" (line {line})" if line > 0 else ""


def _lost_motion(v: Figures) -> str:
    if not v.follows:
        return "; lost motion is left to the control (reversal mean)" * bool(
            v.machine.two_way.any()
        )
    after, before = v.corrected, v.uncorrected
    return (
        f"; with lost motion as such {after.slide / UM:.2f} um{_at(after.slide_line)},"
        f" uncorrected {before.slide / UM:.2f} um, hysteresis {v.hysteresis / UM:g} um"
    )


def _of_lean(v: Figures) -> str:
    """How far the tool leans, on machines with rotary axes."""
    if not v.machine.chain.rotary:
        return ""
    after, before = v.corrected, v.uncorrected
    how = "" if v.oriented else " (--orientation corrects it in programs of the tool tip)" * v.tips
    return (
        f"; the tool leans by {after.lean / URAD:.0f} urad at most (line {after.lean_line}), "
        f"uncorrected {before.lean / URAD:.0f}{how}"
    )


def _of_holes(v: Figures) -> str:
    """What bends in holes, where the tolerance of holes was used."""
    said = ""
    for what, off in (("holes", v.holes), ("taps, which hold their place,", v.taps)):
        if off.deviation > v.tolerance + v.grid / 2:
            said += (
                f"; {what} up to {off.deviation / UM:.2f} um aside "
                f"(line {off.line}; tolerance of holes {v.hole_tolerance / UM:g} um)"
            )
    return said


def _of_splines(v: Figures) -> str:
    """What was looked at of splines, whose knots the control knows."""
    return "; B-splines along their control polygons" * v.splines


def _beside(v: Figures) -> str:
    said = v.centre.report(v.tolerance + v.grid / 2)
    if v.at_contour.deviation:
        said += (
            "; inside G41 G42, at the contour, where no centre is followed,"
            f" {v.at_contour.deviation / UM:.2f} um (line {v.at_contour.line})"
        )
    return said
