"""Machines, plans of tests and missing columns of the later family.  Do not read while working on
the judged tool.

What people do in a shop who have half a day: positioning by ISO 230-2:2014 with targets that miss
what is in the way, two or three runs, one of them on axes beyond 2 m (annex for long axes), a fine
series over two leads for periodic errors (clause 5.3), the same axis again on another day; steps
about one place for lost motion (ISO 10791-4, smallest movements; ISO 230-2 reversal); axes that are
worked and then left to cool (ISO 230-3:2020, clause 7), a spindle that is run at several speeds
before a standing instrument (clause 6); circles in a horizontal plane in full and 220 degrees in a
vertical one, where the table is in the way (ISO 230-4, ballbar makers' partial arcs); four body
diagonals once each (ISO 230-6); a dial gauge along a straightedge (ISO 230-1:2012, clause 8); parts
of two batches on a CMM (ISO 10791-7); logs of a control with an idle start, a pocket, and speeds up
and down a ladder (Erkorkmaz and Altintas 2001); a grid plate under it (ISO 230-4, alternative
instruments).
A case has one to six files.  Thermometers are where somebody put one: in the air, and at a screw or
the frame if it was thought of.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from .base import AX, Array, Rec, Rng, logu, pick
from .designs import ballbar, captures, features, header_meta, inside, targets
from .machines import CHAINS, TRAVEL, Machine, draw_machine
from .motion import ramp

CHAINS |= {
    "column mill": ("XYZ", ["w-b-X-Y-Z-t", "w-b-X-Z-Y-t"], ["heidenhain-iso", "siemens"]),
    "jig borer": ("XYZ", ["w-Y-X-b-Z-t"], ["siemens", "heidenhain-iso", "fanuc-mill"]),
    "drill-tap centre": ("XYZ", ["w-b-Y-X-Z-t", "w-X-Y-b-Z-t"], ["fanuc-mill", "haas"]),
    "roll lathe": ("XZ", ["w-b-Z-X-t"], ["siemens", "fanuc-lathe"]),
}
TRAVEL |= {
    "column mill": {"X": (2500, 6000), "Y": (600, 1200), "Z": (800, 2000)},
    "jig borer": {"X": (400, 900), "Y": (300, 700), "Z": (200, 450)},
    "drill-tap centre": {"X": (400, 700), "Y": (300, 450), "Z": (280, 380)},
    "roll lathe": {"X": (300, 700), "Z": (1500, 5000)},
}
KINDS = ["column mill", "jig borer", "jig borer", "drill-tap centre", "drill-tap centre", "mill"]
STILL = ["positioning", "two_days", "fine", "dial", "visit", "diagonals"]
WARM = ["step_and_dwell", "step_and_dwell", "two_days"]
FAST = ["log", "log", "grid", "visit"]
PLANS: dict[str, list[str]] = {
    "scale": ["positioning", "two_days", "diagonals", "visit", "parts", "grid"],
    "pitch_shape": ["positioning", "positioning", "two_days", "visit", "grid"],
    "cyclic": ["fine", "fine", "positioning", "grid"],
    "backlash": ["positioning", "staircase", "circles", "visit", "two_days", "parts"],
    "backlash_position": ["positioning", "positioning", "two_days", "visit"],
    "windup": ["staircase", "staircase", "circles", "positioning", "grid"],
    "reversal_spike": ["log", "grid", "circles", "circles"],
    "stick_slip": ["log", "grid"],
    "friction_asymmetry": ["log", "grid"],
    "viscous_friction": ["log", "grid"],
    "coulomb_friction": ["log", "grid"],
    "servo_lag": FAST,
    "servo_mismatch": ["circles", "circles", "log", "grid"],
    "inertia": ["log", "grid", "grid"],
    "vibration": ["log", "grid", "circles"],
    "encoder_cyclic": ["log"],
    "screw_heat": WARM,
    "structure_drift": ["step_and_dwell", "spindle_run", "two_days"],
    "spindle_growth": ["spindle_run", "spindle_run", "warm_spindle"],
    "squareness": ["circles", "circles", "diagonals", "grid"],
    "bow": ["dial", "dial", "grid", "circles"],
    "abbe": ["dial", "visit", "diagonals"],
    "sag": ["dial", "dial", "grid"],
    "force_compliance": ["positioning", "staircase", "grid"],
    "tool_wear": ["parts"],
    "tool_size": ["parts"],
    "step_loss": ["positioning", "visit", "log", "grid"],
    "laser_air": ["step_and_dwell", "step_and_dwell", "positioning"],
    "dead_path": ["step_and_dwell", "spindle_run"],
    "cosine": ["positioning", "two_days", "diagonals"],
    "delay": ["log", "grid", "visit"],
    "clock_skew": ["log", "grid"],
}
ALIENS = [  # plans that show the aliens
    *["circles", "grid", "step_and_dwell", "warm_spindle", "positioning"] * 3,
    *["log", "parts", "two_days"] * 2,
    "visit",
]
Make = Callable[[float, str], Rec]


def usable(m: Machine, ax: int) -> tuple[float, float]:
    """What is left of a travel when every overrun stays within it, mm."""
    lo, hi = m.travel[ax]
    return lo + 0.03 * (hi - lo), hi - 0.03 * (hi - lo)


def uneven(r: Rng, m: Machine, ax: int, n: int) -> Array:
    """Targets at unlike distances, one to three of them left out where a clamp is (mm)."""
    lo, hi = usable(m, ax)
    p = lo + (hi - lo) * np.cumsum(r.uniform(0.6, 1.4, n)) / (1.45 * n)
    i = int(r.integers(2, n - 2))
    return np.round(np.delete(p, slice(i, i + int(r.integers(0, 3)))), 3)


def positioning(r: Rng, m: Machine, ax: int, places: Array | None = None) -> Make:
    """ISO 230-2: both directions, 2 or 3 runs of 7 to 25 targets, one run beyond 2 m."""
    p = uneven(r, m, ax, int(r.integers(9, 26))) if places is None else places
    far = np.ptp(m.travel[ax]) > 2000
    at = inside(m, r, 0.25, 0.75)
    runs = 1 if far else int(pick(r, [2, 3, 3, 5]))
    force = {"n": len(p), "positions": p, "runs": runs, "pattern": "iso", "at": at, "laser": True}
    return lambda t, name: targets(r, m, ax, t, name, force=force)


def fine(r: Rng, m: Machine, ax: int) -> Make:
    """Two leads in steps of a part of one that never falls on the same angle; one or two runs."""
    lo, hi = usable(m, ax)
    lead = m.lead[ax]
    step = lead / float(r.uniform(9.3, 14.7))
    n = min(40, int(2.3 * lead / step))
    p = np.round(lo + (hi - lo) * r.uniform(0.2, 0.7) + step * np.arange(n), 3)
    force = {"n": n, "positions": p, "runs": int(r.integers(1, 3)), "pattern": "iso", "laser": True}
    return lambda t, name: targets(r, m, ax, t, name, force={**force, "at": inside(m, r, 0.3, 0.7)})


def meta_of(m: Machine, sens: Array, ax: int, quantity: str, tool: str, what: str) -> dict:
    """Header of a file of targets."""
    zero = np.zeros(3)
    head = {"quantity": quantity, "sensitive": sens, "rotvec": zero, "along": ax}
    return header_meta(m, **head, instrument=tool, pattern=what)


def staircase(r: Rng, m: Machine, ax: int) -> Make:
    """Steps of 5 to 200 um up and down again about one place, three times, read at each."""
    at, n = inside(m, r, 0.3, 0.7), int(r.integers(8, 15))
    step = float(pick(r, [0.005, 0.01, 0.02, 0.05, 0.1, 0.2]))
    tool = str(pick(r, ["capacitive sensor", "dial gauge", "laser interferometer"]))
    meta = meta_of(m, np.eye(3)[ax], ax, "displacement", tool, "staircase")
    pts = [(at - np.eye(3)[ax] * 3, 0)]
    for k in (1, 2, 3):
        steps = [*range(n), *range(n - 2, -1, -1)]
        pts += [(np.round(at + np.eye(3)[ax] * step * i, 4), k) for i in steps[k > 1 :]]
    if len(m.axes) > 1:  # every axis has a direction to come from
        pts[0] = (pts[0][0] - np.where(np.isin([0, 1, 2], m.axes), 1.0, 0.0), 0)
    return lambda t, name: captures(m, name, pts, 200.0, t, float(r.uniform(2, 6)), meta, r)


def step_and_dwell(r: Rng, m: Machine, ax: int) -> Make:
    """Three to six targets every 4 to 12 minutes; the axis works for the first part of the time and
    stands for the rest."""
    n, (lo, hi) = int(r.integers(3, 7)), usable(m, ax)
    runs, share = int(r.integers(8, 19)), r.uniform(0.4, 0.75)
    force = {
        "n": n,
        "runs": runs,
        "pattern": pick(r, ["iso", "uni"]),
        "positions": np.round(lo + (hi - lo) * np.sort(r.choice(np.arange(1, 20), n, False)) / 20),
        "at": inside(m, r, 0.3, 0.7),
        "laser": True,
        "gap": float(pick(r, [240.0, 480.0, 720.0])),
    }

    def make(t: float, name: str) -> Rec:
        q = targets(r, m, ax, t, name, force=force)
        stop = q.t[0] + share * np.ptp(q.t)
        q.activity = [x for x in q.activity if x[0] < stop]
        return q

    return make


def spindle_run(r: Rng, m: Machine, ax: int) -> Make:
    """A sensor before the spindle's nose, read every half to two minutes at one place."""
    n, at = int(r.integers(80, 200)), inside(m, r, 0.3, 0.7)
    before = at - np.where(np.isin([0, 1, 2], m.axes), 2.0, 0.0)
    tool = str(pick(r, ["capacitive sensor", "capacitive sensor", "laser interferometer"]))
    meta = meta_of(m, np.eye(3)[ax], ax, "displacement", tool, "standing")
    pts, dwell = [(before, 0), *[(at, 1)] * n], float(pick(r, [30.0, 60.0, 120.0]))
    return lambda t, name: captures(m, name, pts, 1000.0, t, dwell, meta, r)


def dial(r: Rng, m: Machine, ax: int, to: int) -> Make:
    """A dial gauge on a straightedge: 9 to 17 targets, there and back once or twice."""
    n = int(r.integers(9, 18))
    force = {
        "n": n,
        "positions": uneven(r, m, ax, n),
        "runs": int(r.integers(1, 3)),
        "pattern": "iso",
        "at": inside(m, r, 0.3, 0.7),
        "across": to,
    }
    return lambda t, name: targets(r, m, ax, t, name, "straightness", force=force)


def level(r: Rng, m: Machine, ax: int) -> Make:
    """An electronic level or autocollimator at 8 to 15 places, once or twice."""
    n = int(r.integers(8, 16))
    force = {"n": n, "positions": uneven(r, m, ax, n), "runs": int(r.integers(1, 3))}
    force |= {"pattern": "iso", "at": inside(m, r, 0.3, 0.7)}
    return lambda t, name: targets(r, m, ax, t, name, "angle", force=force)


def diagonals(r: Rng, m: Machine) -> list[Make]:
    """The body's (or face's) diagonals there and back once each, 7 to 15 uneven steps."""
    n, feed, out = int(r.integers(7, 16)), logu(r, 1000, m.vmax), []
    flips = [(1, 1, 1), (1, -1, 1), (1, 1, -1), (1, -1, -1)][: 4 if len(m.axes) == 3 else 2]
    for flip in flips if r.random() < 0.7 else flips[:2]:
        base, d = inside(m, r, 0.3, 0.7), np.zeros(3)
        for a, s in zip(m.axes, flip, strict=False):
            (lo, hi), size = usable(m, a), float(np.ptp(usable(m, a)))
            base[a], d[a] = (lo, size) if s > 0 else (hi, -size)
        x = np.cumsum(r.uniform(0.6, 1.4, n)) / (1.45 * n)
        way = [(0.0, 0), *[(s, 1) for s in x], (1.0, 0), *[(s, 1) for s in x[::-1]]]
        pts = [(np.round(base + s * d, 4), k) for s, k in way]
        meta = meta_of(
            m,
            d / np.linalg.norm(d),
            m.axes[0],
            "displacement",
            "laser interferometer",
            "diagonal",
        )
        out.append(
            lambda t, name, pts=pts, meta=meta: captures(m, name, pts, feed, t, 3.0, meta, r)
        )
    return out


def circles(r: Rng, m: Machine, planes: list[list[int]]) -> list[Make]:
    """A full circle in the first plane, 220 degrees in the others; both senses, at one feed."""
    out, feed = [], float(pick(r, [500.0, 1000.0, 1500.0, 3000.0]))
    for k, plane in enumerate(planes):
        room = min(float(np.ptp(m.travel[a])) for a in plane)
        force = {
            "plane": plane,
            "radius": float(pick(r, [x for x in (30, 50, 100, 150, 250) if x < room * 0.45][-2:])),
            "centre": inside(m, r, 0.48, 0.52),
            "arc": 360.0 if k == 0 else 220.0,
            "senses": [1, -1],
            "reps": int(pick(r, [1, 2])),
            "feed": feed,
        }
        out.append(lambda t, name, force=force: ballbar(r, m, t, name, force=force))
    return out


def corners(r: Rng, room: float, top: float) -> list[tuple[float, float, float]]:
    """(u, v, feed): an L along both axes, then a pocket that is milled from within, and back."""
    out, half = [(0.3 * room, 0.0, top), (0.3 * room, 0.3 * room, top), (0.0, 0.0, top)], 0.05
    while half < 0.45:
        a = half * room
        out += [(a, -a, top), (a, a, top), (-a, a, top), (-a, -a, top)]
        half += 0.08
    return [*out, (0.0, 0.0, top)] * 6


def ladder(r: Rng, room: float, top: float) -> list[tuple[float, float, float]]:
    """To and fro along one axis, faster and faster, then slower again; the other joins in twice."""
    shares = [0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0]
    out = []
    for k, s in enumerate([*shares, *shares[::-1]] * 4):
        d = min(room, top * s / 60 * 3.0) / 2
        v = d if k % 7 == 5 else 0.0
        out += [(d, v, top * s), (-d, -v, top * s)]
    return out


def crawl(r: Rng, room: float, top: float) -> list[tuple[float, float, float]]:
    """Long crawls at 30 to 250 mm/min with a rapid back in between."""
    out, d = [], min(room, 12.0)
    for f in [30.0, 60.0, 120.0, 250.0] * 6:
        way = min(d, f / 60 * 12)
        out += [(way, 0.0, f), (0.0, 0.0, top), (way, 0.0, f), (0.0, 0.0, f)]
    return out


PATHS = {"corners": corners, "ladder": ladder, "crawl": crawl}


def log(r: Rng, m: Machine, sees: str, kind: str, t0: float, name: str) -> Rec:
    """Samples of a control or of a grid plate on one of the paths, 60 to 250 Hz, 20 to 70 s."""
    use, at = [int(a) for a in r.permutation(m.axes)][:2], inside(m, r, 0.4, 0.6)
    room = min(float(np.ptp(m.travel[a])) for a in use) * 0.35
    room = min(room, 140.0) if sees == "tool" else room
    fs, top = float(pick(r, [62.5, 125, 250])), min(float(pick(r, [1500, 3000, 6000])), m.vmax)
    n = int(np.clip(fs * r.uniform(20, 70), 2000, 9000))
    acc, e, here = m.amax * r.uniform(0.3, 0.9), np.eye(3)[use], at
    p = [np.tile(at, (int(fs * r.uniform(0.5, 2.0)), 1))]
    for u, v, feed in PATHS[kind](r, room, top):
        goal = at + np.array([u, v]) @ e
        d = float(np.linalg.norm(goal - here))
        if d > 1e-6:
            p.append(here + np.outer(ramp(d, feed / 60, acc, 1 / fs) / d, goal - here))
        p.append(np.tile(goal, (int(fs * r.uniform(0.02, 0.3)), 1)))
        here = goal
        if sum(map(len, p)) >= n:
            break
    pos = np.concatenate(p)[:n]
    pos = np.round(np.concatenate([pos, np.tile(pos[-1], (n - len(pos), 1))]), 6)
    tt = np.round(t0 + np.arange(n) / fs, 5)
    vel, win = np.gradient(pos, 1 / fs, axis=0), np.ones(max(1, int(0.02 * fs)))
    flat = np.apply_along_axis(np.convolve, 0, vel, win / len(win), "same")
    tool = "grid encoder" if sees == "tool" else "control"
    meta = header_meta(m, sees=sees, instrument=tool, rate=fs, path=kind, feed=top)
    acc_at = np.gradient(flat, 1 / fs, axis=0)
    feeds, runs = np.full(n, top), np.ones(n, int)
    q = Rec(name, "trace", tt, pos, vel, acc_at, runs, pos, tt, np.arange(n), feeds, meta)
    return q.finish()


def visit(r: Rng, m: Machine, plan: str, suspect: str) -> list[Make]:
    """The files of a plan."""
    axes = [int(a) for a in r.permutation(m.axes)]
    if suspect in ("laser_air", "dead_path"):  # air shows on long ways
        axes.sort(key=lambda a: -np.ptp(m.travel[a]))
    flat = [[0, 2]] if len(m.axes) == 2 else [[0, 1], [0, 2], [1, 2]]
    slow = ["crawl"] if suspect == "stick_slip" else ["ladder", "ladder", "corners"]
    kind = str(pick(r, [*slow, *(["crawl"] if suspect in ("coulomb_friction", "windup") else [])]))
    logs = {s: partial(log, r, m, s, kind) for s in ("scale", "tool")}
    some = axes[: int(r.integers(1, len(axes) + 1))]
    if plan == "positioning":
        return [positioning(r, m, a) for a in some]
    if plan == "two_days":
        p = uneven(r, m, axes[0], int(r.integers(9, 20)))
        again = [positioning(r, m, axes[0], p) for _ in range(int(r.integers(2, 4)))]
        warm = suspect in ("screw_heat", "structure_drift")
        return [*again, *([step_and_dwell(r, m, axes[0])] if warm else [])]
    if plan == "fine":
        extra = [positioning(r, m, axes[0])] if r.random() < 0.5 else []
        return [*extra, fine(r, m, axes[0]), fine(r, m, axes[0])]
    if plan == "staircase":
        return [*(staircase(r, m, a) for a in some), positioning(r, m, axes[0])]
    if plan in ("step_and_dwell", "warm_spindle"):
        return [step_and_dwell(r, m, a) for a in some[:2]]
    if plan == "spindle_run":
        return [spindle_run(r, m, a) for a in axes[: int(r.integers(1, 3))]]
    if plan == "dial":
        side = [dial(r, m, axes[0], a) for a in m.axes if a != axes[0]]
        return [*side, level(r, m, axes[0]), *([positioning(r, m, axes[0])] * (r.random() < 0.5))]
    if plan == "diagonals":
        return [*diagonals(r, m), *([positioning(r, m, axes[0])] * (r.random() < 0.5))]
    if plan == "circles":
        return circles(r, m, flat if r.random() < 0.5 else flat[:1])
    if plan == "parts":
        return [partial(features, r, m)] * int(r.integers(1, 3))
    if plan == "visit":
        return [positioning(r, m, axes[0]), *circles(r, m, flat[:1]), logs["scale"]]
    more = circles(r, m, flat[:1]) if r.random() < 0.4 else []
    return [*[logs["tool" if plan == "grid" else "scale"]] * int(r.integers(1, 3)), *more]


def campaign(r: Rng, m: Machine, plan: str, suspect: str, t: float) -> list[Rec]:
    """The files in order of time; days lie between two of them in a plan of several days."""
    recs: list[Rec] = []
    for i, make in enumerate(visit(r, m, plan, suspect)):
        recs.append(make(t, f"r{i + 1}"))
        wait = pick(r, [300.0, 900.0, 2700.0]) * r.uniform(0.7, 1.5)
        if plan == "two_days" or (plan == "parts" and r.random() < 0.5):
            wait = 86400.0 * int(r.integers(1, 3)) * r.uniform(0.8, 1.1)
        t = float(np.round(float(recs[-1].t[-1]) + wait, 1))
    return recs


def experiment(r: Rng, suspect: str, masked: bool) -> tuple[Machine, list[Rec], dict, str]:
    """Machine, files in order of time, drivers asked for, and the plan's name; a suspect of ALIENS
    is a plan itself."""
    alien = suspect in ALIENS
    plan = suspect if alien else str(pick(r, PLANS.get(suspect, STILL)))
    if masked and plan in ("parts", "log"):  # neither shows the machine's map
        plan = "visit"
    kinds = KINDS if plan == "parts" else [*KINDS, "roll lathe", "lathe", "grinder"]
    m = draw_machine(r, masked, str(pick(r, kinds)), flat=plan == "parts")
    drivers = {
        "load": suspect == "force_compliance" or r.random() < (0.3 if alien else 0.1),
        "spindle": plan in ("spindle_run", "warm_spindle") or r.random() < 0.1,
        "T": suspect in ("screw_heat", "structure_drift", "laser_air") and r.random() < 0.8,
        "current": plan in ("log", "grid") and r.random() < 0.4,
    }
    start = float(np.round(r.uniform(0, 60), 1))
    return m, campaign(r, m, plan, suspect, start), drivers, plan


def absent(r: Rng, m: Machine, suspect: str) -> set[str]:
    """Thermometers that nobody put there; that of the screw which is suspected is mostly there."""
    kept = 0.85 if suspect == "screw_heat" else 0.5
    out = {f"T_screw_{AX[a]}_C" for a in m.axes if r.random() > kept}
    return out | ({"T_spindle_C"} if r.random() < 0.3 else set())
