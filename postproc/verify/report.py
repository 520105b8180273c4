"""What a verification found, in one line for a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

from postproc.units import UM, URAD

if TYPE_CHECKING:
    from postproc.verify import Verifier

SEEN = 0.005 * UM  # less is said as 0.00, and has no ratio


def line(v: Verifier) -> str:
    """One line for a person: before, after, and their ratio."""
    before, after = v.uncorrected.deviation, v.corrected.deviation
    ratio = f", {before / after:.0f} times less" if before > after > SEEN else ""
    return (
        f"largest deviation from the nominal path {after / UM:.2f} um{_at(v.corrected.line)},"
        f" uncorrected {before / UM:.2f} um{_at(v.uncorrected.line)}{ratio}{_lost_motion(v)};"
        f" tolerance {v.tolerance / UM:g} um; {v.motions_in} motions in, {v.motions_out}"
        f" out{_of_holes(v)}{_beside(v)}{_of_lean(v)};"
        f" {v.map.report()}"
    )


def _at(line: int) -> str:
    """The line, where there is one: nothing is off anywhere on a machine without errors."""
    return f" (line {line})" if line > 0 else ""


def _lost_motion(v: Verifier) -> str:
    if not v.follows:
        return "; lost motion is left to the control (reversal mean)" * bool(
            v.machine.two_way.any()
        )
    after, before = v.corrected, v.uncorrected
    return (
        f"; with lost motion as such {after.slide / UM:.2f} um (line {after.slide_line}),"
        f" uncorrected {before.slide / UM:.2f} um, hysteresis {v.hysteresis / UM:g} um"
    )


def _of_lean(v: Verifier) -> str:
    """How far the tool leans, on machines with rotary axes."""
    if not v.machine.chain.rotary:
        return ""
    after, before = v.corrected, v.uncorrected
    how = "" if v.oriented else " (--orientation corrects it in programs of the tool tip)" * v.tips
    return (
        f"; the tool leans by {after.lean / URAD:.0f} urad at most (line {after.lean_line}), "
        f"uncorrected {before.lean / URAD:.0f}{how}"
    )


def _of_holes(v: Verifier) -> str:
    """What bends in holes, where the tolerance of holes was used."""
    said = ""
    for what, off in (("holes", v.holes), ("taps, which hold their place,", v.taps)):
        if off.deviation > v.tolerance + v.grid / 2:
            said += (
                f"; {what} up to {off.deviation / UM:.2f} um aside "
                f"(line {off.line}; tolerance of holes {v.hole_tolerance / UM:g} um)"
            )
    return said


def _beside(v: Verifier) -> str:
    said = v.centre.report(v.tolerance + v.grid / 2)
    if v.at_contour.deviation:
        said += (
            "; inside G41 G42, at the contour, where no centre is followed,"
            f" {v.at_contour.deviation / UM:.2f} um (line {v.at_contour.line})"
        )
    return said
