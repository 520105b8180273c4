"""Parts that are measured after machining: which points of the machine a feature is made of, and
when."""

from __future__ import annotations

from typing import Any

import numpy as np

from proof.generator.machines import XYZ, Machine
from proof.generator.tracks import Track


def features(
    rng: np.random.Generator,
    machine: Machine,
    head: dict,
    start: float,
    parts: int,
    minutes: float,
    changes: int,
) -> Track:
    """Features of parts that were cut one after the other, from `start`. A row of the track is a
    point of a feature; what a feature's error is of its points is in `features`: points, their
    weights and the axis along which they count."""
    shapes: list[dict[str, Any]] = []
    middle = np.array([machine.axes[x].middle if x in machine.axes else 0.0 for x in XYZ])
    if machine.form == "mill":
        for x in "XY":
            i, span = XYZ.index(x), machine.axes[x].length
            sizes = [np.round(rng.uniform(0.3, 0.55) * span) for _ in range(2)]
            shapes += [
                _across(f"{x}{k + 1}", "centre_distance", x, i, size, middle, 1, 1, 0)
                for k, size in enumerate(sizes)
            ]
            shapes.append(
                _across(
                    f"{x}P",
                    "pocket_size",
                    x,
                    i,
                    np.round(rng.uniform(0.2, 0.4) * span),
                    middle,
                    1,
                    -1,
                    1,
                )
            )
            shapes.append(
                _across(
                    f"{x}B",
                    "boss_diameter",
                    x,
                    i,
                    np.round(rng.uniform(0.1, 0.2) * span),
                    middle,
                    -1,
                    1,
                    -1,
                )
            )
    else:
        low, span = max(machine.axes["X"].low, 0.0), machine.axes["X"].high
        for k, u in enumerate((0.2, 0.42, 0.64, 0.85)):
            at = middle.copy()
            at[0] = round(low + u * (span - low))
            bore = k == 3
            going = np.array([[1.0 if bore else -1.0, 1.0, -1.0]])
            shapes.append(
                {
                    "feature": f"D{k + 1}",
                    "kind": "bore_diameter" if bore else "boss_diameter",
                    "axis": "X",
                    "nominal": 2 * at[0],
                    "points": at[None],
                    "going": going,
                    "weights": np.array([2.0]),
                    "size": 1 if bore else -1,
                }
            )
        foot = machine.axes["Z"].share(0.1)
        for k in range(3):
            a, b = middle.copy(), middle.copy()
            length = float(np.round(rng.uniform(0.15, 0.5) * machine.axes["Z"].length))
            a[2], b[2] = foot, foot + length
            going = np.tile([-1.0, 1.0, -1.0], (2, 1))
            shapes.append(
                {
                    "feature": f"S{k + 1}",
                    "kind": "step",
                    "axis": "Z",
                    "nominal": length,
                    "points": np.array([a, b]),
                    "going": going,
                    "weights": np.array([-1.0, 1.0]),
                    "size": 0,
                }
            )
    run: list[int] = []
    time: list[float] = []
    position, direction, rows, spindle, moved = [], [], [], [], []
    for p in range(parts):
        begun = start + p * minutes * 60
        spindle.append((begun, begun + 0.8 * minutes * 60, 1500.0))
        for k, shape in enumerate(shapes):
            now = begun + (0.2 + 0.6 * k / len(shapes)) * minutes * 60
            first = len(time)
            for point, going in zip(shape["points"], shape["going"], strict=True):
                run.append(p + 1)
                time.append(now)
                position.append(point)
                direction.append(going)
            rows.append({**shape, "part": p + 1, "rows": np.arange(first, len(time))})
    moving = "XY" if machine.form == "mill" else "XZ"
    for x in moving:
        axis = machine.axes[x]
        moved.append(
            (
                start,
                start + parts * minutes * 60,
                x,
                axis.low + 0.2 * axis.length,
                axis.high - 0.2 * axis.length,
                8.0,
            )
        )
    every = max(2, parts // (changes + 1))
    return Track(
        "features",
        head,
        moving,
        np.array(run),
        np.array(time),
        np.array(position),
        np.array(direction),
        features=rows,
        spindle=spindle,
        active=moved,
        changes=[start + p * minutes * 60 for p in range(every, parts, every)] if changes else [],
    )


def _across(name, kind, x, i, size, middle, high_going, low_going, grows) -> dict[str, Any]:
    a, b = middle.copy(), middle.copy()
    a[i], b[i] = middle[i] - size / 2, middle[i] + size / 2
    going = np.ones((2, 3))
    going[0, i], going[1, i] = low_going, high_going
    return {
        "feature": name,
        "kind": kind,
        "axis": x,
        "nominal": float(size),
        "points": np.array([a, b]),
        "going": going,
        "weights": np.array([-1.0, 1.0]),
        "size": grows,
    }
