"""Circular tests, ISO 230-4, from radial deviations by angle.

G: circular deviation, the range of radius about the least-squares circle or, less, the width of the
minimum zone; G(b): of both senses about one centre; H: hysteresis, the largest radial difference
between the senses; F: radial deviation from the nominal circle, set-up included; D: mean radial
deviation of both senses. xy and yx name the sense: from +X to +Y, and back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from postproc.iso.minimax import minimax

ROUNDS = 20


@dataclass(frozen=True)
class Circle:
    """centre (2,), radius, zone (range of radius about that centre): mm."""

    centre: np.ndarray
    radius: float
    zone: float


@dataclass(frozen=True)
class Trace:
    """One circle of one run. angle (N,) rad from the first axis towards the second, ascending over
    less than a turn; radial (N,) mm, measured radius - nominal; nominal mm; way: +1 travelled from
    the first axis to the second, -1 back;
    full: whether it goes all round; gap: rad, the widest step; cut: rad of overshoot arcs that were
    taken off."""

    run: int
    way: int
    angle: np.ndarray
    radial: np.ndarray
    nominal: float
    full: bool
    gap: float
    cut: float = 0.0

    @cached_property
    def points(self) -> np.ndarray:
        """(N, 2) mm from the nominal centre."""
        radius = self.nominal + self.radial
        return np.stack([radius * np.cos(self.angle), radius * np.sin(self.angle)], axis=1)

    @cached_property
    def least_squares(self) -> Circle:
        """mm: about the centre with the smallest sum of squares; of a full circle."""
        return least_squares(self.points, self.nominal)

    @cached_property
    def minimum_zone(self) -> Circle:
        """mm: the narrowest zone, in whose middle the radius lies; of a full circle."""
        return minimum_zone(self.points, self.nominal)

    @property
    def about_nominal(self) -> tuple[float, float]:
        """F max and min, mm, about the nominal centre as it was set up."""
        return float(self.radial.max()), float(self.radial.min())

    @property
    def about_centre(self) -> tuple[float, float]:
        """F max and min, mm, about the least-squares centre."""
        radius = np.linalg.norm(self.points - self.least_squares.centre, axis=1) - self.nominal
        return float(radius.max()), float(radius.min())


def least_squares(points: np.ndarray, nominal: float) -> Circle:
    """The circle with the smallest sum of squared radial distances (Gauss-Newton). points (N, 2)
    mm."""
    # With n the direction from the centre to a point, its distance d from a centre that is moved by
    # c becomes d - n . c to first order. So d - r = dr + n . c, by least squares, gives by how much
    # the radius is too small, and which way the centre has to go.
    centre, radius = np.zeros(2), nominal
    for _ in range(ROUNDS):
        away = points - centre
        distance = np.linalg.norm(away, axis=1)
        basis = np.column_stack([np.ones(len(points)), away / distance[:, None]])
        step = np.linalg.lstsq(basis, distance - radius, rcond=None)[0]
        radius, centre = radius + step[0], centre + step[1:]
        if np.abs(step).max() < 1e-12 * nominal:
            break
    return _circle(points, centre, float(radius))


def minimum_zone(points: np.ndarray, nominal: float) -> Circle:
    """The narrowest pair of concentric circles that holds all points: minimax about a centre, and
    again until it stays."""
    centre = least_squares(points, nominal).centre
    best = _circle(points, centre)
    for _ in range(ROUNDS):
        away = points - centre
        distance = np.linalg.norm(away, axis=1)
        basis = np.column_stack([np.ones(len(points)), away / distance[:, None]])
        # As least squares above, but with the largest residual made least: the circle is moved
        # until the widest and the narrowest radius, two of each, lie as near as they can. The
        # problem is not convex, so the narrowest zone of all rounds counts, not that of the last.
        step, _ = minimax(basis, distance - nominal)
        centre = centre + step[1:]
        found = _circle(points, centre)
        best = found if found.zone < best.zone else best
        if np.abs(step[1:]).max() < 1e-11 * nominal:
            break
    return best


def _circle(points: np.ndarray, centre: np.ndarray, radius: float | None = None) -> Circle:
    distance = np.linalg.norm(points - centre, axis=1)
    # of a minimum zone the circle midway, of which both edges are as far
    middle = float((distance.max() + distance.min()) / 2) if radius is None else radius
    return Circle(centre, middle, float(np.ptp(distance)))


@dataclass(frozen=True)
class Pair:
    """A run of each sense in one set-up, forth with way +1 and back with way -1."""

    forth: Trace
    back: Trace

    @cached_property
    def least_squares(self) -> Circle:
        """mm: of both senses about one centre, whose zone is G(b)."""
        return least_squares(
            np.concatenate([self.forth.points, self.back.points]), self.forth.nominal
        )

    @cached_property
    def minimum_zone(self) -> Circle:
        """mm: the narrowest zone that holds both senses."""
        return minimum_zone(
            np.concatenate([self.forth.points, self.back.points]), self.forth.nominal
        )

    @cached_property
    def hysteresis(self) -> tuple[float, float]:
        """H, mm, and the angle, rad, where it is. The back run is interpolated at the angles of the
        forth run."""
        # Both against the nominal centre as it was set up: moving it moves both alike, but not what
        # differs between them. -1: where the other run has no sample H can not be.
        other = np.interp(self.forth.angle, self.back.angle, self.back.radial, period=2 * np.pi)
        apart = np.abs(self.forth.radial - other)
        if not (self.forth.full and self.back.full):
            apart[~_covered(self.forth.angle, self.back.angle, self.back.gap)] = -1.0
        at = int(np.argmax(apart))
        return float(apart[at]), float(self.forth.angle[at] % (2 * np.pi))

    @property
    def mean_deviation(self) -> float:
        """D, mm: mean radius of both senses, without the set-up of the centre, less the nominal
        one."""
        return (
            self.forth.least_squares.radius + self.back.least_squares.radius
        ) / 2 - self.forth.nominal


def ways(angle: np.ndarray, time: np.ndarray, *parts: np.ndarray) -> np.ndarray:
    """(N,) +1 where a run turns from the first axis towards the second, -1 back, by its samples
    (N,) in order of time. parts: (N,) each, alike within a run. (Counter-clockwise, as `sense` says
    it, is the other way in a plane that is looked at from behind.)"""
    found = np.zeros(len(angle))
    for part in np.unique(np.stack(parts), axis=1).T:
        rows = np.flatnonzero((np.stack(parts) == part[:, None]).all(axis=0))
        turned = np.unwrap(angle[rows[np.argsort(time[rows], kind="stable")]])
        found[rows] = 1.0 if turned[-1] >= turned[0] else -1.0
    return found


def _covered(angle: np.ndarray, other: np.ndarray, gap: float) -> np.ndarray:
    """Which angles lie within the arc of the other run."""
    # an arc as its middle and half its width: angles may run across 360 degrees
    middle = (other[0] + other[-1]) / 2
    away = (angle - middle + np.pi) % (2 * np.pi) - np.pi
    return np.abs(away) <= (other[-1] - other[0]) / 2 + gap


def trace(run: int, angle: np.ndarray, radial: np.ndarray, nominal: float) -> Trace:
    """A run as it was recorded, angles (N,) rad in order of time, made one circle: of more than a
    turn the middle one is kept, so that arcs of run-in and overshoot fall away at both ends
    alike."""
    turned = np.unwrap(angle)
    way = 1 if turned[-1] >= turned[0] else -1
    order = np.argsort(turned, kind="stable")
    turned, radial = turned[order], radial[order]
    total = float(turned[-1] - turned[0])
    gap = float(np.diff(turned).max(initial=0.0))
    cut = 0.0
    step = float(np.median(np.diff(turned))) if len(turned) > 1 else 0.0
    #   recorded  |~~~~|=========================|~~~~|     the feed comes up and goes down in ~~~~
    #   kept           |<---- the middle turn -->|
    if total >= 2 * np.pi:
        start = (turned[0] + turned[-1]) / 2 - np.pi
        inside = (turned >= start - 1e-9) & (turned < start + 2 * np.pi - 1e-9)
        turned, radial = turned[inside], radial[inside]
        cut = total + step - 2 * np.pi
        full = True
    else:
        # From the last sample round to the first: up to one and a half steps it is a step like the
        # others, and the circle is closed.
        closing = 2 * np.pi - total
        full = closing <= max(1.5 * step, np.radians(0.1))
    return Trace(run, way, turned, radial, nominal, full, gap, cut)
