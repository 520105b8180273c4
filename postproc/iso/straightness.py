"""Straightness of a motion and squareness of two, ISO 230-1, about one and the same definition of
the reference line.

Lines are laid through the means of the runs. Two-way is the mean of both directions of approach;
the directions apart have each their own line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.iso.lines import Line, reference, straightness_error
from postproc.iso.positioning import Positioning
from postproc.iso.sampling import LEVEL, draws, noise_of, shared_ends

ROUNDING = 1e-12  # of the width of a zone
NAMES = ("straightness", "straightness +", "straightness -")


@dataclass(frozen=True)
class Straightness:
    """kind: of the line; lines and errors by NAMES, None where not defined; test: the means they
    are laid through."""

    kind: str
    test: Positioning
    lines: dict[str, Line | None]
    errors: dict[str, float | None]

    @property
    def best(self) -> str:
        """The name of what stands for the motion: two-way, or the one direction there is."""
        return next(n for n in NAMES if self.errors[n] is not None)

    @property
    def off(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Height (m,) of the best line at each target, and how far the means (m,) are from it, mm;
        None where there is no line."""
        line = self.lines[self.best]
        if line is None:
            return None
        height = line.value(self.test.target)
        return height, means(self.test, self.best) - height


def evaluate(kind: str, test: Positioning) -> Straightness:
    """The straightness errors, mm, of two-way means and of each direction."""
    lines: dict[str, Line | None] = {}
    errors: dict[str, float | None] = {}
    for name in NAMES:
        x, y, _ = points(test, name)
        lines[name] = reference(kind, x, y) if len(x) > 1 else None
        errors[name] = straightness_error(kind, x, y) if len(x) > 1 else None
    return Straightness(kind, test, lines, errors)


def points(test: Positioning, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Targets and means (k,) that a line is laid through, and which (m,) they are."""
    y = means(test, name)
    used = np.isfinite(y)
    return test.target[used], y[used], used


def means(test: Positioning, name: str) -> np.ndarray:
    """(m,) mm by target, NaN where there is none: of both directions or of one, by NAMES."""
    return test.middle if name == NAMES[0] else test.mean[NAMES.index(name) - 1]


def from_runs(kind: str, test: Positioning, name: str) -> tuple[float, float] | None:
    """Expanded uncertainties that the scatter of the runs gives the straightness error (mm) and the
    slope (rad); None for single runs. The means are drawn again as in sampling, and every draw has
    its own line."""
    noise = noise_of(test.s, test.n)
    x, y, used = points(test, name)
    if noise is None or len(x) < 2:
        return None
    if name == NAMES[0]:
        row = noise.of_two(0.5).part(slice(1), used)
    else:
        row = noise.part(slice(NAMES.index(name) - 1, NAMES.index(name)), used)
    if noise.s == 0:
        return 0.0, 0.0
    # What is noise and what is shape is asked of the deviations from the line: on a tilted one the
    # two ends would always be the extremes.
    line = reference(kind, x, y).value(x)
    centre = line + shared_ends((y - line)[None], row)[0]
    many = centre + draws(row)[:, 0]
    zones, slopes = _fits(kind, x, many)
    zone, slope = _fits(kind, x, centre[None])
    return float(np.quantile(np.abs(zones - zone), LEVEL)), float(
        np.quantile(np.abs(slopes - slope), LEVEL)
    )


def _fits(kind: str, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Zone and slope (D,) of the lines through x (m,) and each row of y (D, m)."""
    if kind == "minimum-zone":
        return _narrowest(x, y)
    if kind == "end-point":
        slope = (y[:, -1] - y[:, 0]) / (x[-1] - x[0])
    else:
        arm = x - x.mean()
        slope = y @ arm / (arm @ arm)
    return np.ptp(y - slope[:, None] * x, axis=1), slope


def _narrowest(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Zone and slope (D,) of the narrowest parallels, of each row of y (D, m); x ascending."""
    #   width \      /      The width of the zone by the slope of its lines is convex and made of
    #          \   _/       straight pieces, one for each pair of points that it touches. Of the
    #           \_o         pieces known to either side of the least the crossing is looked at; its
    #             slope     own piece takes the place of one, until it lies on both.
    every, far = np.arange(len(y)), x[-1] - x[0]
    # height at slope 0, and rise, of a piece that falls and of one that rises
    falls = np.stack([y[:, -1] - y[:, 0], np.full(len(y), -far)])
    rises, before = -falls, np.full(len(y), np.nan)
    for _ in range(len(x) + 10):
        slope = (rises[0] - falls[0]) / (falls[1] - rises[1])
        off = y - slope[:, None] * x
        high, low = off.argmax(axis=1), off.argmin(axis=1)
        width = off[every, high] - off[every, low]
        piece = np.stack([y[every, high] - y[every, low], x[low] - x[high]])
        more = width - (falls[0] + falls[1] * slope) > ROUNDING * width
        more &= (piece[1] != 0) & (slope != before)
        if not more.any():
            break
        before = slope
        falls = np.where(more & (piece[1] < 0), piece, falls)
        rises = np.where(more & (piece[1] > 0), piece, rises)
    return width, slope


# name, and whether a positive one makes the angle larger (1) or smaller (-1)
SQUARENESS = {"XY": ("C0Y", 1), "YZ": ("A0Z", 1), "XZ": ("B0Z", -1)}


def squareness(
    first: str, second: str, slope_first: float, slope_second: float
) -> tuple[str, float]:
    """Name and value (rad) from two reference lines on one square.

    slope_first: rad, deviation along the second axis over the motion of the first; slope_second:
    the other way round. The angle between the lines exceeds 90 degrees by -(slope_first +
    slope_second). C0Y and A0Z carry the sign of that excess, B0Z the opposite one: a positive
    rotation about Y tilts Z towards +X (ISO 841).
    """
    pair = "".join(sorted(first + second))
    #       Y ^   / Y as it is     C0Y > 0 turns Y towards -X: the angle from X to Y grows.
    #         |  /    (C0Y < 0)    B0Z > 0 turns Z towards +X: the angle between both shrinks. A
    #         | /                  line with a slope towards the other axis closes the angle:
    #         +-------> X          hence the minus of both.
    name, sign = SQUARENESS[pair]
    return name, -sign * (slope_first + slope_second)
