"""Where the components were measured: the arm that is counted from there, and components of one
axis brought together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.calibrate import CalibrationError, Options
from postproc.calibrate.component import SAME_PLACE, Component
from postproc.errors import Place
from postproc.machine.chain import OPTICS, ROTARY, XYZ
from postproc.machine.tables import COMPONENTS


def optic_of(components: list[Component], letter: str, options: Options) -> str:
    """What the measured point of an axis was fixed to, "tool" or "workpiece"; "" for the side that
    the axis carries.

    A reading is the deviation of the tool at the workpiece, so the point goes with the tool unless
    the recording's head says `optic = "workpiece"`. Raises CalibrationError for another word, or
    for files that differ.
    """
    said = set()
    for component in components:
        for series in component.series:
            word = series.head.get("optic", "tool")
            if word not in OPTICS:
                raise CalibrationError(
                    f"optic = {word!r}", "tool or workpiece", Place(series.file, 1)
                )
            said.add(word)
    if len(said) > 1:
        raise CalibrationError(
            f"some recordings of {letter} have their optic fixed to the tool, others to the"
            " workpiece",
            "calibrate one kind",
        )
    # a rotary axis has its own errors about its line: no optic lengthens an arm there
    word = said.pop() if said else "tool"
    return "" if letter in ROTARY or word == options.chain.side(letter) else word


def bring_together(
    components: dict[str, Component], options: Options
) -> tuple[dict[str, Component], dict[str, dict[str, float]], dict[str, str], list[str]]:
    """All translations of an axis as at one place of the other axes, where its positioning was
    measured.

    Beside the axes of the arm the measured point itself counts: a file has no word for it, so
    translations are written as they would be at the carriage, and the tool's own place brings the
    arm back.

    Returns the components, `measured_at` (axis to other axis to mm, those of the arm only), the
    optic of each axis, and what was moved or could not be.
    """
    result = dict(components)
    measured: dict[str, dict[str, float]] = {}
    optics: dict[str, str] = {}
    notices: list[str] = []
    for letter in options.chain.axes:
        mine = {n: c for n, c in components.items() if c.letter == letter}
        if not mine:
            continue
        optics[letter] = optic_of(list(mine.values()), letter, options)
        arm = [x for x in options.chain.arm(letter, optics[letter]) if x != letter]
        # The positioning decides where the arm counts from, else a straightness, an angle last: an
        # angle is the same wherever it was read.
        first = min(mine.values(), key=lambda c: (c.angle, c.name != f"E{letter}{letter}"))
        measured[letter] = {x: first.rest.get(x, 0.0) + options.point[XYZ.index(x)] for x in arm}
        brought, says = _brought(mine, first, arm, options)
        result |= brought
        notices += _unsaid(letter, arm, mine) + says
    return result, measured, optics, notices


def _unsaid(letter: str, arm: list[str], mine: dict[str, Component]) -> list[str]:
    """What is said of axes of the arm whose place some translation's recording does not state."""
    unsaid = [x for x in arm if any(x not in c.rest for c in mine.values() if not c.angle)]
    return [f"{letter}: the recordings do not say where {x} stood; taken as 0" for x in unsaid]


def _brought(
    mine: dict[str, Component], first: Component, arm: list[str], options: Options
) -> tuple[dict[str, Component], list[str]]:
    """The translations of an axis that were measured elsewhere than `first`, as they are there, and
    what is said of each. mine: the components of the axis; arm: the axes whose places count."""
    result, notices = {}, []
    # An axis of the arm takes the measured point into `measured_at`; across the others it can only
    # be taken out of the readings.
    beside = {x: -p for x, p in zip(XYZ, options.point, strict=True) if p and x not in arm}
    for component in (c for c in mine.values() if not c.angle):
        away = _apart(first, component, arm)
        if away or beside:
            own = f"E{component.letter}{component.letter}"
            why = f"elsewhere than {own}" if away else "beside the carriage"
            result[component.name], says = _carried(component, beside | away, mine, why)
            notices.append(says)
    return result, notices


def _apart(first: Component, component: Component, arm: list[str]) -> dict[str, float]:
    """mm from where a component was measured to where `first` was, of the axes that differ."""
    away = {x: first.rest.get(x, 0.0) - component.rest.get(x, 0.0) for x in arm}
    return {x: d for x, d in away.items() if abs(d) > SAME_PLACE}


def _carried(
    component: Component, away: dict[str, float], mine: dict[str, Component], why: str
) -> tuple[Component, str]:
    """A translation as it would be with the others `away` mm further: what the axis' own angles
    make of that arm."""
    row = XYZ.index(component.name[1])
    extra, variance = np.zeros_like(component.value), np.zeros_like(component.value)
    used, missing = [], []
    for x, distance in away.items():
        across = XYZ.index(x)
        if across == row:
            continue
        turn = 3 - row - across
        # (eps x arm)_i = eps_j arm_k - eps_k arm_j
        sign = 1.0 if (turn + 1) % 3 == across else -1.0
        angle = mine.get(f"{COMPONENTS[3 + turn]}{component.letter}")
        if angle is None:
            missing.append(
                f"{COMPONENTS[3 + turn]}{component.letter} (10 urad of it would be"
                f" {abs(distance) / 100:.1f} um)"
            )
            continue
        used.append(angle.name)
        for way in (0, 1):
            # what a longer arm would have added, read between the angle's own targets
            extra[way] += (
                sign * distance * np.interp(component.nodes, angle.nodes, angle.value[way])
            )
            variance[way] += (
                distance * np.interp(component.nodes, angle.nodes, np.nan_to_num(angle.u[way]))
            ) ** 2
    where = ", ".join(f"{x} {d:+g} mm" for x, d in away.items())
    says = f"{component.name} was measured {why} ({where} to go)"
    if used:
        says += (
            f": carried there with {', '.join(used)}, by up to {np.abs(extra).max() * 1e3:.2f} um"
        )
    if missing:
        says += f"; not measured: {', '.join(missing)}"
    return (component.moved(extra, np.sqrt(variance), says) if used else replace(component)), says
