"""What a ballbar tells of a map: squareness, lost motion and the difference of two scales (ISO
230-4, both senses).

Along a circle of radius R the bar reads, with a, b the two axes and t the angle from a towards b,

    r = c_a cos t + c_b sin t + zero + (s_a - s_b) R cos(2t) / 2 + g R sin(2t) / 2
        - B_a / 2 way_a cos t - B_b / 2 way_b sin t + m sense sin(2t)

c: the centre's set-up, zero: the bar's own length with the mean of both scales, which it can not
part; s: scales; g: drift of a per mm of b and of b per mm of a together, the squareness; B: lost
motion, way: the direction in which the axis moves; m: axes that follow unlike, which turns the
ellipse with the sense of rotation (so both senses are needed). Each file has its own centre and
zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from postproc.calibrate import CalibrationError
from postproc.calibrate.statistics import t_factor
from postproc.errors import Place
from postproc.iso.circles import ways
from postproc.machine.chain import XYZ
from postproc.recordings import Recording

# of a turn: what the equation leaves is taken as alike within one, and as independent between them
SECTORS = 16
# mm that a commanded place may lie beside the circle; further out it belongs to the run-in
BESIDE = 0.1
SHARED = ("scale", "square", "first play", "second play", "lag")
LEAST = 12  # samples of a run


@dataclass(frozen=True)
class Circles:
    """axes: "XY"; square: rad, drift of the first axis per mm of the second and of the second per
    mm of the first together; scale: difference of the first axis' and the second's; play (2,) mm;
    u: of each, by name; rms mm: of what is left; samples."""

    axes: str
    square: float
    scale: float
    play: tuple[float, float]
    u: dict[str, float]
    rms: float
    samples: int
    files: tuple[str, ...]


def axes_of(recording: Recording) -> str:
    """The two axes of a circle, in the order X Y Z. Raises CalibrationError for others."""
    axes = "".join(x for x in XYZ if x in recording.head.get("centre", {}))
    if len(axes) != 2 or len(recording.head["centre"]) != 2:
        raise CalibrationError(
            "the centre names no two linear axes",
            "centre = { X = .., Y = .. }",
            Place(recording.file, 1),
        )
    return axes


def fit(recordings: Sequence[Recording], known: Sequence[np.ndarray]) -> Circles:
    """Least squares over all files of one plane. known: of each (N,) mm, the radial deviation that
    is explained already.

    u of each number comes from what is left, sector by sector (cluster-robust, with Student's t for
    so few sectors), so that waves of straightness widen it. Raises CalibrationError where one sense
    is missing.
    """
    axes = axes_of(recordings[0])
    rows, values, sectors, ways_of = [], [], [], []
    for k, (one, expected) in enumerate(zip(recordings, known, strict=True)):
        part, value, angle, sense = _rows(one, expected, axes)
        #              SHARED   set-up 1   set-up 2       columns: five for all, then three for
        #    file 1      x         x                      each file (cos, sin, 1), whose set-up
        #    file 2      x                    x           is its own
        own = np.zeros((len(value), 3 * len(recordings)))
        own[:, 3 * k : 3 * k + 3] = np.column_stack(
            [np.cos(angle), np.sin(angle), np.ones(len(angle))]
        )
        rows.append(np.hstack([part, own]))
        values.append(value)
        turn = np.mod(angle, 2 * np.pi) / (2 * np.pi)  # a whole turn where it is a hair below zero
        sectors.append(np.minimum((turn * SECTORS).astype(int), SECTORS - 1))
        ways_of.append(sense)
    terms, y, sector = np.vstack(rows), np.concatenate(values), np.concatenate(sectors)
    if len(np.unique(np.concatenate(ways_of))) < 2:
        raise CalibrationError(
            "the circles turn one way only: the squareness and axes that follow unlike look the"
            " same",
            "record both senses",
            Place(recordings[0].file, 1),
        )
    if len(np.unique(sector)) < SECTORS:
        raise CalibrationError(
            "the circles are no full turns",
            "a full turn in each sense",
            Place(recordings[0].file, 1),
        )
    solve = np.linalg.pinv(terms)
    found = solve @ y
    left = y - terms @ found
    pulls = np.stack([solve[:, sector == k] @ left[sector == k] for k in range(SECTORS)], axis=1)
    # A file's three and the five shared ones are found from the same sectors. Half of them show in
    # the sums of both senses, the others in the differences (iso/causes.py), so this is on the safe
    # side: of 3000 made files 2 u cover each number in 96 % at the least.
    free = SECTORS - 3 - len(SHARED)
    spread = (
        np.sqrt((pulls**2).sum(axis=1) * SECTORS / free)
        * float(t_factor(np.array(float(free))))
        / 2
    )
    u = dict(zip(SHARED, spread[: len(SHARED)].tolist(), strict=True))
    return Circles(
        axes, float(found[1]), float(found[0]), (float(found[2]), float(found[3])), u,
        float(np.sqrt(np.mean(left**2))), len(y), tuple(r.file for r in recordings),
    )  # fmt: skip


def _rows(
    one: Recording, expected: np.ndarray, axes: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Columns of SHARED, the reading without what is known, the angle and the sense of each sample
    on the circle."""
    if axes_of(one) != axes:
        raise CalibrationError(
            f"{one.file} is a circle of {axes_of(one)}, the first one of {axes}",
            "one plane at a time",
        )
    radius = float(one.head["radius_mm"])
    arm = np.stack([one.position(x) - one.head["centre"][x] for x in axes])
    on = on_circle(one, arm)
    if on.sum() < LEAST:
        raise CalibrationError(
            f"{int(on.sum())} samples lie on the circle of {radius:g} mm",
            "are centre and radius_mm right?",
            Place(one.file, 1),
        )
    angle, sense = np.arctan2(arm[1], arm[0])[on], senses(one, arm, on)[on]
    # directions of motion: while b is above zero a falls, run from a to b (iso/causes.py)
    first, second = -sense * np.sign(np.sin(angle)), sense * np.sign(np.cos(angle))
    columns = np.column_stack([
        radius * np.cos(2 * angle) / 2, radius * np.sin(2 * angle) / 2, -first * np.cos(angle) / 2,
        -second * np.sin(angle) / 2, sense * np.sin(2 * angle),
    ])  # fmt: skip
    return columns, one.reading[on] - expected[on], angle, sense


def on_circle(one: Recording, arm: np.ndarray) -> np.ndarray:
    """(N,) bool: which samples lie on the circle. arm (2, N) mm: from the centre."""
    return np.asarray(np.abs(np.hypot(*arm) - float(one.head["radius_mm"])) <= BESIDE)


def senses(one: Recording, arm: np.ndarray, on: np.ndarray) -> np.ndarray:
    """(N,) +1 where the bar turns from the first axis to the second, -1 back, 0 beside the circle.
    arm (2, N) mm: from the centre; on (N,): on the circle."""
    columns, found = one.columns, np.zeros(len(one))
    run = columns.get("run", np.ones(len(one)))
    found[on] = ways(
        np.arctan2(arm[1], arm[0])[on], columns["t_s"][on], run[on], columns["sense"][on]
    )
    return found
