"""What makes a circle out of round: the causes that a ballbar's trace is known to show, with their
size, ranked.

With t the angle from the first axis a towards the second b, w = +1 where it is run from a to b and
-1 back, R the radius, way the direction in which an axis moves, the bar reads, beside its centre
and zero, the sum of

    scale        s R cos(2t) / 2               +: a goes farther than b
    square       -g R sin(2t) / 2              +: the angle from a to b is more than a right one
    lost motion  -B way cos(t) / 2             of a, sin(t) of b; +: it stops short
    lag          m w sin(2t)                   +: a lags more; the ellipse turns over with the sense
    spike        -P way cos(t) exp(-d / 3 deg) of a, sin(t) of b; d: angle since it turned; +: it
                                               sticks, and stays outside
    straightness cos(3t), sin(3t)              a bow of one axis: three lobes; +: outwards at +a,
                                               inwards at +b
    side play    -p way sin(t)                 of a, cos(t) of b; +: it goes aside towards - of the
                                               other when it moves towards +

Each follows from where the axes stand instead, projected on the radius: squareness, with b leaning
by g towards -a, moves a by -g R sin(t), and so the radius by -g R sin(t) cos(t). Least squares of
all at once, of runs in both senses (one alone can not part square from lag). Such influences are
drawn in ISO 230-4, annex B; forms as in Knapp, Test of the three-dimensional uncertainty of machine
tools and measuring machines (1983), which ballbar makers follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from postproc.iso.chance import student
from postproc.iso.circles import Trace
from postproc.units import UM, URAD

# of a turn: what the causes leave is taken as alike within one, and as independent between them
SECTORS = 16
SPIKE = np.radians(3.0)  # over which a spike goes back to a third
TURN = np.linspace(0.0, 2 * np.pi, 721)[:-1]
FEWEST = 60  # samples of a turn


@dataclass(frozen=True)
class Cause:
    """name; size: of its parameter in `unit`, with U (95 %), and what it is where it is positive;
    range: mm, by how much it alone makes
    the radius differ round the circle, in the sense where that is more, with U; share: of the sum
    of all ranges."""

    name: str
    size: float
    U: float
    unit: str
    positive: str
    range: float
    U_range: float
    share: float


@dataclass(frozen=True)
class Causes:
    """ranked: the largest first; left: mm rms of what none of them explains; whole: mm rms of what
    there was beside the set-up."""

    ranked: tuple[Cause, ...]
    left: float
    whole: float


def causes(axes: str, traces: Sequence[Trace], feed_mm_min: float | None = None) -> Causes | None:
    """The causes of full circles in both senses; None where one sense is missing or a circle is not
    full."""
    whole = [t for t in traces if t.full and len(t.angle) >= FEWEST]
    if len({t.way for t in whole}) < 2:
        return None
    nominal = whole[0].nominal
    samples = [(t.angle, np.full(len(t.angle), float(t.way)), t.radial) for t in whole]
    angle, way, y = map(np.concatenate, zip(*samples, strict=True))
    # where the circle's centre and the bar's zero were set up: they are in every reading, and no
    # cause
    setup = np.column_stack([np.cos(angle), np.sin(angle), np.ones(len(angle))])
    columns = _columns(angle, way, nominal)
    units = _units(axes, feed_mm_min)
    terms = np.hstack([columns, setup])
    solve = np.linalg.pinv(terms)
    found = solve @ y
    left = y - terms @ found
    # a hair below zero the remainder is a whole turn
    turn = np.mod(angle, 2 * np.pi) / (2 * np.pi)
    sector = np.minimum((turn * SECTORS).astype(int), SECTORS - 1)
    # Residuals of neighbours go together (a spike's tail, a screw's wave), so counting samples as
    # independent would make U far too small. Each sector pulls at the sizes as a whole; from how
    # the 16 pulls scatter follows what chance does to their sum.
    pulls = np.stack([solve[:, sector == k] @ left[sector == k] for k in range(SECTORS)], axis=1)
    # Of the 16 sums of both senses 7 unknowns are made (scale, squareness, two lobes, the set-up),
    # of the 16 differences the 7 others; and all pulls at one size add up to nothing, which takes
    # one more. Of 3000 made traces, off alike within sectors or by white noise, U covers each size
    # in 96 % at the least.
    free = SECTORS - 7 - 1
    u = np.sqrt((pulls**2).sum(axis=1) * SECTORS / free) * student(free)
    turns = [np.ptp(_columns(TURN, np.full(len(TURN), w), nominal), axis=0) for w in (1.0, -1.0)]
    # a cause that goes with the sense differs between both; the larger one is told
    unit_range = np.maximum(*turns)
    ranges = np.abs(found[: len(units)]) * unit_range
    rows = [
        Cause(
            name,
            float(found[k] * factor),
            float(u[k] * abs(factor)),
            unit,
            positive,
            float(ranges[k]),
            float(u[k] * unit_range[k]),
            float(ranges[k] / max(ranges.sum(), 1e-12)),
        )
        for k, (name, (unit, factor, positive)) in enumerate(units.items())
    ]
    beside = y - setup @ np.linalg.lstsq(setup, y, rcond=None)[0]
    ranked = tuple(sorted(rows, key=attrgetter("range"), reverse=True))
    return Causes(ranked, float(np.sqrt(np.mean(left**2))), float(np.sqrt(np.mean(beside**2))))


def _columns(t: np.ndarray, w: np.ndarray, radius: float) -> np.ndarray:
    """(N, K) mm that each cause adds to the radius, by the unit of its parameter in mm or rad; in
    the order of `_units`."""
    # directions in which the axes move
    #            b              a = R cos t, b = R sin t. With w = +1 (from a to b) a falls while
    #        .---|---.          b is above zero: its way is -w sign(sin t), that of b w sign(cos t).
    #       |----+----| a
    #        '---|---'
    first, second = -w * np.sign(np.sin(t)), w * np.sign(np.cos(t))
    # Angle since the axis turned: a turns at 0 and 180 degrees, b at 90 and 270.
    since_a, since_b = np.mod(w * t, np.pi), np.mod(w * (t - np.pi / 2), np.pi)
    return np.column_stack(
        [
            radius * np.cos(2 * t) / 2,
            -radius * np.sin(2 * t) / 2,
            -first * np.cos(t) / 2,
            -second * np.sin(t) / 2,
            w * np.sin(2 * t),
            -first * np.cos(t) * np.exp(-since_a / SPIKE),
            -second * np.sin(t) * np.exp(-since_b / SPIKE),
            np.cos(3 * t),
            np.sin(3 * t),
            -first * np.sin(t),
            -second * np.cos(t),
        ]
    )


def _units(axes: str, feed_mm_min: float | None) -> dict[str, tuple[str, float, str]]:
    """Name to the unit in which its parameter is told, what it is multiplied by, and what it is
    where it is positive."""
    a, b = axes[0], axes[1]
    # Of time constants Ta and Tb the radius gets v (Ta - Tb) / 2 w sin(2t): m = v dT / 2, so dT = 2
    # m / v with v = feed / 60 mm/s, in ms 2000 * 60 m / feed.
    lag = ("ms", 2000.0 * 60.0 / feed_mm_min) if feed_mm_min else ("um", 1 / UM)
    short, stays = "it stops short", "it sticks, and stays outside"
    return {
        f"scales of {a} and {b} differ": ("um/m", 1e6, f"{a} goes farther"),
        f"squareness of {a} and {b}": ("urad", 1 / URAD, "more than a right angle"),
        f"lost motion of {a}": ("um", 1 / UM, short),
        f"lost motion of {b}": ("um", 1 / UM, short),
        f"{a} and {b} follow unlike (servo mismatch)": (*lag, f"{a} lags more"),
        f"spike where {a} turns": ("um", 1 / UM, stays),
        f"spike where {b} turns": ("um", 1 / UM, stays),
        "straightness, lobes along " + a: ("um", 1 / UM, f"outwards at +{a}"),
        "straightness, lobes along " + b: ("um", 1 / UM, f"inwards at +{b}"),
        f"side play of {a}": ("um", 1 / UM, f"towards -{b} on its way to +{a}"),
        f"side play of {b}": ("um", 1 / UM, f"towards -{a} on its way to +{b}"),
    }
