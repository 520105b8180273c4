"""Servo, vibration and lost steps of the later family.  Do not read while working on the judged
tool.

Signs as in forms_motion.  Sources: Kessler 1958 (Das symmetrische Optimum: a speed loop that shoots
over by two fifths), Merritt 1967 (Hydraulic control systems: a cylinder with a rod on one side has
unlike gains out and in), Weck and Brecher 2006 (Werkzeugmaschinen 3 and 4: speed fed forward,
masses of workpieces, forces that act above the guides), ISO/TR 230-8 (relative motion from the
acceleration of axes; floors), Ivantysyn 2003 (Hydrostatic pumps: the flow of an odd number of
pistons is a row of half waves), Rivin 2003 (Passive vibration isolation: rocking on mounts),
Acarnley 2002 (steps are lost at the hardest acceleration), Neugart's and Gates' design manuals
(belts that skip a tooth and seat again).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import bilinear, lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .forms_servo import pair_of
from .registry import along, both, later, tool_only, unit_place
from .world import World


def overshooting(q: Rec, ax: int, t1: float) -> Array:
    """Speed (mm/s) behind (1 + 4 T s) / (1 + 4 T s + 8 T^2 s^2 + 8 T^3 s^3); circles are steady."""
    v = q.vel[:, ax]
    if q.kind != "trace":
        return v
    b, a = bilinear([4 * t1, 1], [8 * t1**3, 8 * t1**2, 4 * t1, 1], q.meta["rate"])
    return lfilter(b, a, v)


def twice_late(q: Rec, ax: int, t1: float) -> Array:
    """Speed (mm/s) behind two lags of t1 seconds in a row; circles are steady."""
    v = q.vel[:, ax]
    if q.kind != "trace":
        return v
    k = 1 - np.exp(-1 / q.meta["rate"] / t1)
    for _ in range(2):
        v = lfilter([k], [1, k - 1], v)
    return v


@later("servo_lag")
def symmetrical_optimum(w: World, r: Rng, ax: int) -> Shape:
    """A lag behind a speed loop that is set by the symmetrical optimum, T 1 to 10 ms (Kessler)."""
    t1 = logu(r, 0.001, 0.01)
    return both(ax, lambda q: -overshooting(q, ax, t1), params=lambda a: {"tau_ms": a})


@later("servo_lag")
def out_and_in(w: World, r: Rng, ax: int) -> Shape:
    """Gains of a cylinder out and in that differ by 6 to 25 %; the mean lag is told (Merritt)."""
    k = r.uniform(0.03, 0.12) * pick(r, [-1.0, 1.0])
    return both(
        ax,
        lambda q: -q.vel[:, ax] * (1 + k * np.sign(q.vel[:, ax])),
        params=lambda a: {"tau_ms": a},
    )


@later("servo_mismatch")
def one_fed_forward(w: World, r: Rng, ax: int) -> Shape:
    """One axis of two is fed its speed forward, the other one lags behind two lags of 1 to 15 ms
    (Weck and Brecher 2006)."""
    pair, k, t1 = pair_of(w, r, ax), int(r.integers(2)), logu(r, 0.001, 0.015)
    sign = -1.0 if k == 0 else 1.0

    def field(q: Rec, a: float) -> Part:
        v = along(q, pair[k], -a * twice_late(q, pair[k], t1))
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@later("inertia")
def above_the_guides(w: World, r: Rng, ax: int) -> Shape:
    """A force of inertia that acts above the guides pitches the slide: the tool gives way by its
    height, another axis's place; the scale sees a tenth to a third (ISO/TR 230-8)."""
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))
    low, share = r.uniform(0.4, 1.0), r.uniform(0.1, 0.35)

    def field(q: Rec, a: float) -> Part:
        v = along(q, ax, -a * q.acc[:, ax] * (low + unit_place(w, to, q)))
        return Part(tool=v, scale=share * v)

    return Shape(field, AX[ax])


@later("inertia")
def workpieces(w: World, r: Rng, ax: int) -> Shape:
    """Mass over stiffness, with another workpiece on the table in every file: 0.75 to 1.3 of the
    mean mass (Weck and Brecher 2006)."""
    key = int(r.integers(2**62))
    return both(ax, lambda q: -q.acc[:, ax] * stream(key, q.name).uniform(0.75, 1.3))


def fastest(w: World, share: float) -> float | None:
    """Highest frequency (Hz) that every file in motion samples at least 1 / share times."""
    rates = [1 / np.median(np.diff(q.t)) for q in w.recs if q.kind in ("trace", "ballbar")]
    return float(min(rates)) * share if rates else None


def in_motion(q: Rec) -> bool:
    """Whether a file is sampled in motion."""
    return q.kind in ("trace", "ballbar")


@later("vibration")
def piston_pump(w: World, r: Rng, ax: int) -> Shape | None:
    """Half waves of the flow of a pump with 7 or 9 pistons: a tone with its harmonics, cusps down
    (Ivantysyn 2003)."""
    top = fastest(w, 1 / 7)
    if top is None or top < 2.5:
        return None
    hz, ph = logu(r, 2.0, min(top, 60.0)), r.uniform(0, 1)

    def f(q: Rec) -> Array:
        if not in_motion(q):
            return np.zeros(len(q.t))
        return 2 * (np.abs(np.sin(np.pi * (hz * q.t + ph))) - 2 / np.pi)

    make = both if r.random() < 0.6 else tool_only
    return make(ax, f, params=lambda a: {"frequency_hz": hz})


@later("vibration")
def rocking_on_mounts(w: World, r: Rng, ax: int) -> Shape | None:
    """A machine that rocks on its mounts at 3 to 20 Hz: an ellipse in two directions that swells
    and dies as the floor is shaken (Rivin 2003); no scale sees it."""
    top = fastest(w, 1 / 2.6)
    if top is None or top < 4.0 or not any(in_motion(q) and q.outside for q in w.recs):
        return None
    hz = logu(r, 3.0, min(top, 20.0))
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))
    k, ph, slow = r.uniform(0.15, 0.4), r.uniform(0, 6.28, 3), hz / r.uniform(40, 120)

    def field(q: Rec, a: float) -> Part:
        if not in_motion(q):
            return Part()
        swell = a * (1 + 0.4 * np.sin(2 * np.pi * slow * q.t + ph[2])) / 1.4
        th = 2 * np.pi * hz * q.t
        return Part(
            tool=along(q, ax, swell * np.sin(th + ph[0]))
            + along(q, to, k * swell * np.sin(th + ph[1]))
        )

    return Shape(field, AX[ax], lambda a: {"frequency_hz": hz})


def _jump(w: World, r: Rng, ax: int, k: float) -> Shape:
    """A jump at the hardest acceleration of a file (in motion) or within its longest move; the
    share k of it comes while something seats again."""
    live = [q for q in w.recs if ax in q.moving] or w.recs
    q0, sign = pick(r, live), pick(r, [-1.0, 1.0])
    n = len(q0.t)
    mid = np.arange(n // 6, max(n // 6 + 2, n - n // 6))
    mid = mid[mid < n]
    hard = q0.acc[:, ax] if q0.kind == "trace" else np.diff(q0.pos[:, ax], prepend=0)
    hard = np.abs(hard)[mid]
    i = int(mid[pick(r, np.argsort(-hard)[:5])])
    t0 = float(q0.t[max(i - 1, 0)] + q0.t[i]) / 2
    tau = r.uniform(0.005, 0.05) * float(np.ptp(q0.t))

    def f(q: Rec) -> Array:
        rest = np.exp(-np.maximum(q.t - t0, 0) / tau)
        return sign * (q.t > t0) * (1 - k * rest)

    return both(ax, f, params=lambda a: {"jump_um": sign * a, "t_s": round(t0, 3)})


@later("step_loss")
def at_full_torque(w: World, r: Rng, ax: int) -> Shape:
    """One jump that stays, where the most torque is asked for (Acarnley 2002)."""
    return _jump(w, r, ax, 0.0)


@later("step_loss")
def skipped_tooth(w: World, r: Rng, ax: int) -> Shape:
    """A belt that skips: most of the jump at once, the rest as it seats again (Gates)."""
    return _jump(w, r, ax, r.uniform(0.1, 0.25))
