"""Coordinate measuring machine or probe: sizes and distances of features of a part, after each part
that was made.

A feature of n mm lies on its axis, half of n on either side of the middle of the travel; the
program gives time and heat.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.effects import State
from postproc.errors import UsageError
from postproc.simulate import history
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, refuse_more

TITLE = "coordinate measuring machine"
SETTINGS = {
    "features": "X:100,Y:80 or X:pocket_size:40: axis, kind (centre_distance) and nominal mm",
    "readings": "of each feature on each part (3)",
}
MATERIAL = {
    "centre_distance": 0.0,
    "step": 0.0,
    "pocket_size": 1.0,
    "bore_diameter": 1.0,
    "boss_diameter": -1.0,
}


def measure(reality: Reality, settings: Settings) -> Signal:
    """mm of every feature of every part. Raises UsageError for one that does not fit."""
    timeline = reality.timeline
    features = _features(reality, settings.text("features"))
    readings = settings.whole("readings", 3)
    part = timeline.steps.part[timeline.path.step]
    parts = np.unique(part)
    refuse_more(float(len(features) * readings * len(parts)), "fewer: --set readings=3")
    last = np.array([np.flatnonzero(part == p)[-1] for p in parts])
    # each part as the machine was when it was finished
    time = timeline.plan.start[last + 1]
    base = timeline.state(time, last, parts.astype(float))
    rows: dict[str, list[np.ndarray]] = {}
    states = []
    for number, (axis, kind, nominal) in enumerate(features, 1):
        ends = []
        for side in (0.5, -0.5):
            state = _at(base, reality, axis, side * nominal, MATERIAL[kind])
            ends.append((state, reality.error(state, ("part",), last)["XYZ".index(axis)]))
        # what both ends are off by alike shifts a feature and leaves its size; material makes it
        # wider or narrower
        size = ends[0][1] - ends[1][1] + _of_material(reality, ends[0][0], last, axis)
        n = len(parts)
        one = {
            "feature": np.array([f"F{number}"] * n, object), "kind": np.array([kind] * n, object),
            "axis": np.array([axis] * n, object), "nominal_mm": np.full(n, nominal),
            "measured_mm": nominal + size, "part": parts.astype(float),
        }  # fmt: skip
        for reading in range(1, readings + 1):
            for name, values in (one | {"reading": np.full(n, float(reading))}).items():
                rows.setdefault(name, []).append(values)
            states.append(ends[0][0])
    columns = {name: np.concatenate(values) for name, values in rows.items()}
    return Signal("features", {"instrument": TITLE}, columns, {"measured_mm": 1e3}, states[0])


def _features(reality: Reality, text: str) -> list[tuple[str, str, float]]:
    """Axis, kind and nominal mm of the features that were asked for. Raises UsageError."""
    found = []
    for item in filter(None, text.split(",")):
        axis, kind, nominal = _parsed(item)
        if (
            axis not in reality.machine.letters
            or axis not in "XYZ"
            or kind not in MATERIAL
            or not nominal > 0
        ):
            raise UsageError(
                f"{item!r} is no feature",
                f"like X:100 or X:pocket_size:40; kinds: {', '.join(MATERIAL)}; axes:"
                f" {' '.join(reality.machine.letters)}",
            )
        low, high = reality.machine.axes[axis].travel
        if nominal > high - low:
            raise UsageError(f"{item!r}: {axis} travels {high - low:g} mm")
        found.append((axis, kind, nominal))
    if not found:
        raise UsageError("which features?", "--set features=X:100,Y:80")
    return found


def _parsed(item: str) -> tuple[str, str, float]:
    """Axis, kind and mm of X:100 or X:pocket_size:40; -1 mm where there is no size."""
    parts = [p.strip() for p in item.split(":")]
    if len(parts) == 2:
        parts.insert(1, "centre_distance")
    axis, kind, size = [*parts, "", ""][:3]
    try:
        return axis, kind, float(size)
    except ValueError:
        return axis, kind, -1.0


def _at(base: State, reality: Reality, axis: str, off: float, material: float) -> State:
    """The state behind each part, the slides where the feature lies."""
    n = len(base)
    position = {}
    for x in base.position:
        low, high = reality.machine.axes[x].travel
        position[x] = np.full(n, (low + high) / 2 if np.isfinite(low + high) else 0.0)
    # half the feature on either side of the middle: what grows with the position shows in its size
    position[axis] = position[axis] + off
    still = {x: np.zeros(n) for x in position}
    channels = base.channels | {"material": np.full(n, material)}
    return replace(
        base, position=position, approach={x: np.ones(n) for x in position}, velocity=still,
        acceleration=still, distance={x: np.full(n, history.FAR) for x in position},
        channels=channels,
    )  # fmt: skip


def _of_material(reality: Reality, state: State, last: np.ndarray, axis: str) -> np.ndarray:
    """(N,) mm: what makes every wall of a feature off alike, so that its two ends do not cancel."""
    walls = replace(
        reality, terms=tuple(t for t in reality.terms if {"part", "material"} & set(t.module.NEEDS))
    )
    return walls.error(state, ("part",), last, tables=False)["XYZ".index(axis)]
