"""Targets that do not reach over the travel, and what happens beyond them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component

NEAR = 0.01  # mm
WORTH = 1.0  # um or urad


def check(calibration: Calibration) -> Iterator[Finding]:
    if bare := [x for x in calibration.options.chain.axes if x not in calibration.axes()]:
        yield Finding(
            "no-table",
            "note",
            "",
            f"nothing to correct of {', '.join(bare)}: written without a table",
        )
    for letter in calibration.axes():
        yield from _travel(calibration, letter)
        yield from _not_covered(calibration, letter)
        for component in calibration.of(letter):
            yield from _held(calibration, component, *calibration.travel(letter))


def _travel(calibration: Calibration, letter: str) -> Iterator[Finding]:
    """A travel that was not said, and targets outside of it."""
    (low, high), nodes = calibration.travel(letter), calibration.nodes(letter)
    if letter not in calibration.options.travel:
        text = (
            f"travel of {letter} not said (--travel {letter}={nodes[0]:g},{nodes[-1]:g}): taken"
            " as from the first target to the last"
        )
        yield Finding("travel", "note", letter, text)
    if outside := [q for q in (nodes[0], nodes[-1]) if q < low - NEAR or q > high + NEAR]:
        text = (
            f"{letter} was measured at {outside[0]:g} {place_name(letter)}, outside its travel of"
            f" {low:g} to {high:g}"
        )
        yield Finding("travel", "doubt", letter, text, {"at": float(outside[0])})


def _not_covered(calibration: Calibration, letter: str) -> Iterator[Finding]:
    """Ends of the travel without targets."""
    (low, high), nodes = calibration.travel(letter), calibration.nodes(letter)
    ends = {"below": nodes[0] - low, "above": high - nodes[-1]}
    beyond = {side: d for side, d in ends.items() if d > NEAR}
    if not beyond:
        return
    unit = place_name(letter)
    where = " and ".join(f"{d:g} {unit} {side}" for side, d in beyond.items())
    does = (
        "is refused there"
        if calibration.options.outside == "error"
        else "is corrected as at the last target"
    )
    text = (
        f"targets of {letter} reach from {nodes[0]:g} to {nodes[-1]:g} {unit}, its travel"
        f" from {low:g} to {high:g}: {where} are not covered, a program {does}"
    )
    yield Finding("travel", "note", letter, text, {"beyond_mm": max(beyond.values())})


def _held(calibration: Calibration, component: Component, low: float, high: float) -> list[Finding]:
    """End values that count for more than their own target."""
    unit, one = unit_of(component.name)
    nodes = calibration.nodes(component.letter)
    ends = []
    for at, edge, travel in ((0, nodes[0], low), (-1, nodes[-1], high)):
        own = component.nodes[at]
        # a component may end before its axis' other ones: up to the last of them its end value is
        # in the table
        clamped = calibration.options.outside == "clamp" and abs(travel - own) > NEAR
        worst = float(np.abs(component.value[:, at]).max()) / one
        if (clamped or abs(own - edge) > NEAR) and worst > WORTH:
            far = travel if clamped else edge
            ends.append((abs(far - own), f"{worst:.1f} {unit} from {own:g} to {far:g}"))
    if not ends:
        return []
    text = f"{component.name} is held beyond its own targets: " + ", ".join(t for _, t in ends)
    return [Finding("held", "doubt", component.name, text, {"over_mm": max(d for d, _ in ends)})]
