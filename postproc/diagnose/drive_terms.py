"""The terms of a drive's force: what each is, its columns over a motion, and its parameters.

Positions mm, speeds mm/s; a response in N or A. Inertia of 1 N per m/s2 is 1 kg.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np

M = 1e-3  # m per mm
ROWS = ("place", "velocity", "acceleration", "jerk", "sense", "gone", "response", "time", "asked")


@dataclass(frozen=True)
class Motion:
    """N samples of an axis: place mm, velocity mm/s, acceleration mm/s2, jerk mm/s3, sense -1..1
    (the sign of the speed through the same low-pass), gone mm since the axis turned back, response
    N or A, time s, asked mm/s (the commanded speed), passage (N,) numbers of unbroken
    recordings."""

    place: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    sense: np.ndarray
    gone: np.ndarray
    response: np.ndarray
    time: np.ndarray
    asked: np.ndarray
    passage: np.ndarray = field(default_factory=lambda: np.zeros(0, int))

    @staticmethod
    def joined(parts: list[Motion]) -> Motion:
        """Several passages as one, in order."""
        passage = np.concatenate([np.full(len(p.place), i) for i, p in enumerate(parts)])
        return Motion(
            **{n: np.concatenate([getattr(p, n) for p in parts]) for n in ROWS}, passage=passage
        )

    def pick(self, which: np.ndarray) -> Motion:
        """Some of the samples."""
        return Motion(**{n: getattr(self, n)[which] for n in ROWS}, passage=self.passage[which])

    @property
    def share(self) -> np.ndarray:
        """(N,) place within what was travelled, -1 to 1."""
        low, high = float(self.place.min()), float(self.place.max())
        return 2 * (self.place - low) / max(high - low, 1e-9) - 1


@dataclass(frozen=True)
class Term:
    """name: of an effect; label: what it is; parameters: name to meaning; of: columns (N, K) over a
    motion; shape: what does not enter linearly; siblings: how many shapes could have been taken;
    plain: inertia, viscous and Coulomb friction."""

    name: str
    label: str
    parameters: tuple[str, ...]
    text: str
    of: Callable[[Motion], list[np.ndarray]]
    shape: tuple[tuple[str, float], ...] = ()
    siblings: int = 1
    plain: bool = False
    positive: bool = False  # its first coefficient can not be below zero

    def columns(self, motion: Motion) -> np.ndarray:
        """(N, K): of each coefficient what one of it adds to the response of each sample."""
        return np.stack(self.of(motion), axis=1)

    def named(self, value: np.ndarray) -> dict[str, float]:
        """Parameter to value of coefficients (K,), in the units of the names; what its shape states
        beside them."""
        if self.name == "force_ripple":
            return {self.parameters[0]: float(np.hypot(*value))} | dict(self.shape)
        return {n: float(v) for n, v in zip(self.parameters, value, strict=True)} | dict(self.shape)

    def errors(self, value: np.ndarray, covariance: np.ndarray) -> dict[str, float]:
        """Parameter to the standard error of coefficients (K,) with a covariance (K, K)."""
        if self.name == "force_ripple":
            # gradient of sqrt(c^2 + s^2) by c and s: the error of the amplitude, to first order
            slope = value / max(float(np.hypot(*value)), 1e-12)
            return {self.parameters[0]: float(np.sqrt(max(slope @ covariance @ slope, 0.0)))}
        return {
            n: float(np.sqrt(max(v, 0.0)))
            for n, v in zip(self.parameters, np.diag(covariance), strict=True)
        }


def terms(motion: Motion, unit: str) -> Iterator[Term]:
    """All terms that this motion may show."""
    yield Term(
        "inertia", "inertia", (f"{unit}_per_m_s2",), "The drive accelerates a mass.",
        # mm/s2 to m/s2: the coefficient is N per m/s2, kg
        lambda m: [m.acceleration * M], plain=True, positive=True,
    )  # fmt: skip
    yield Term(
        "viscous_friction",
        "friction that grows with the speed",
        (f"{unit}_per_m_s",),
        "Friction grows with the speed: lubrication, screw and motor.",
        lambda m: [m.velocity * M],
        plain=True,
        positive=True,
    )
    yield Term(
        "coulomb_friction",
        "friction against the sense of motion",
        (f"size_{unit}",),
        "Dry friction: guideways, seals and preload. Friction compensation in the drive.",
        lambda m: [m.sense],
        plain=True,
        positive=True,
    )
    yield Term(
        "force_offset",
        "a constant force",
        (f"size_{unit}",),
        "A constant: weight, a balance that does not balance, or the zero of the signal.",
        lambda m: [np.ones(len(m.place))],
    )
    yield Term(
        "friction_asymmetry",
        "friction that differs with the sense of motion, by the speed",
        (f"{unit}_per_m_s",),
        "Friction grows with the speed more one way than the other: cover, wiper, cable chain or a"
        " tilted nut.",
        lambda m: [np.abs(m.velocity) * M],
    )
    #     force |*                                .  viscous
    #           | *                      .  '
    #           |  ' *  .  .  '     Coulomb
    #           |
    #           +----+---------------------------- speed
    #               at: exp(-(v / at)^2), in shares of the fastest
    speeds = (0.02, 0.05, 0.1, 0.2, 0.4)
    fastest = float(np.abs(motion.velocity).max())
    for share in speeds:
        at = share * fastest
        yield Term(
            "stribeck_friction",
            "more friction at low speed",
            (f"size_{unit}",),
            "Friction falls with the speed at first (Stribeck): mixed lubrication; the cause of"
            " stick-slip.",
            partial(_slow, at),
            (("speed_mm_s", at),),
            len(speeds),
            positive=True,
        )
    for power in (0.5, 2.0):
        yield Term(
            "viscous_curve", "friction that is not in proportion to the speed", (f"curve_{unit}",),
            "Friction grows less than the speed (grease that thins), or more (churned oil).",
            partial(_power, power, fastest), (("power", power),), 2,
        )  # fmt: skip
    # Behind a turn part of the friction is missing, -sense exp(-gone / way) of it. A way that a few
    # samples pass is not told from a turn that was sampled late.
    step = float(np.median(np.abs(np.diff(motion.place)))) if len(motion.place) > 1 else 0.0
    for way in (w for w in (0.05, 0.2, 0.8, 3.0) if 4 * w > step):
        yield Term(
            "presliding",
            "friction that builds up after a turn",
            (f"missing_{unit}",),
            "After a turn friction builds up over some way (pre-sliding, wind-up of the screw): the"
            " cause of quadrant glitches.",
            partial(_build_up, way),
            (("way_mm", way),),
            4,
            positive=True,
        )
    yield Term(
        "friction_position",
        "friction that differs along the travel",
        (f"first_{unit}", f"second_{unit}"),
        "Dry friction differs along the travel: preload, guideways that are not parallel, a worn"
        " stretch.",
        # Legendre polynomials P1 and P2 of the place, times the sense: without the constant, P0,
        # which is Coulomb friction
        lambda m: [m.sense * m.share, m.sense * (1.5 * m.share**2 - 0.5)],
    )
    yield Term(
        "force_position",
        "a force that differs along the travel",
        (f"first_{unit}", f"second_{unit}"),
        "A spring along the travel: cable chain, cover, balance.",
        lambda m: [m.share, 1.5 * m.share**2 - 0.5],
    )
    yield Term(
        "load_friction", "friction that grows with the load", (f"{unit}_per_m_s2",),
        "Friction grows with the force that is transmitted: the efficiency of the screw.",
        lambda m: [m.sense * np.abs(m.acceleration) * M],
    )  # fmt: skip
    yield Term(
        "force_delay",
        "force and motion were not sampled at once",
        (f"{unit}_per_m_s3",),
        "The force is late or early against the motion: a filter of the drive, or the order of"
        " sampling.",
        lambda m: [m.jerk * M],
    )
    for lead in _leads(motion):
        yield Term(
            "force_ripple",
            "a force that is periodic in the place",
            (f"amplitude_{unit}",),
            "The force is periodic in the place: cogging of the motor, balls that come into the"
            " nut, an eccentric screw.",
            partial(_harmonic, lead),
            (("period_mm", lead),),
            len(LEADS),
        )


def _slow(at: float, motion: Motion) -> list[np.ndarray]:
    return [motion.sense * np.exp(-((motion.velocity / at) ** 2))]


def _power(power: float, fastest: float, motion: Motion) -> list[np.ndarray]:
    """A curve of the speed less its line over these samples, so that dry and viscous friction stay
    what they are."""
    curve = motion.sense * (np.abs(motion.velocity) / fastest) ** power
    line = np.stack([motion.sense, motion.velocity / fastest], axis=1)
    return [curve - line @ np.linalg.lstsq(line, curve, rcond=None)[0]]


def _build_up(way: float, motion: Motion) -> list[np.ndarray]:
    return [-motion.sense * np.exp(-motion.gone / way)]


def _harmonic(period: float, motion: Motion) -> list[np.ndarray]:
    angle = 2 * np.pi * motion.place / period
    return [np.cos(angle), np.sin(angle)]


LEADS = (
    1.0,
    1.25,
    2.0,
    2.5,
    4.0,
    5.0,
    6.0,
    8.0,
    10.0,
    12.0,
    16.0,
    20.0,
    25.0,
    40.0,
)  # mm: usual screws, their halves and quarters


def _leads(motion: Motion) -> list[float]:
    """Periods that the samples tell apart: three of them within the travel, four samples in
    each."""
    span = float(np.ptp(motion.place))
    step = float(np.median(np.abs(np.diff(motion.place)))) if len(motion.place) > 1 else span
    return [p for p in LEADS if 4 * step < p < span / 3]
