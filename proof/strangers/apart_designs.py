"""Machines, plans of tests and missing columns of the apart family.  Do not read while working on
the judged tool.

Acceptance tests as the standards write them: positioning in full cycles, both directions, five runs
(ISO 230-2:2014) and in its step cycles, periodic errors over two to three leads, circles both ways,
at two feeds in one plane or at one in all (ISO 230-4; QC20), the same circles again while the
machine warms up, body and face diagonals (ISO 230-6), environmental variation, spindle and linear
axes (ISO 230-3:2020, clauses 5, 6 and 7; ASME B5.54), straightness in both directions with angles
(ISO 230-1:2012), positioning on two parallel lines (ISO 230-1, Annex; VDI 2617-3) and twice on one,
the laser set up anew, parts on a CMM (ISO 10791-7), logs of a control or of a grid encoder at
several feeds (ISO 230-4, alternative instruments; Erkorkmaz and Altintas 2001), and at a crawl.  A
case has one to four files.  Every fourth visit is poor: few targets, one way, one run, one feed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from .apart_logs import Make, crawl, logs
from .base import AX, Array, Rec, Rng, logu, pick
from .designs import ballbar, captures, features, header_meta, inside, targets
from .machines import CHAINS, TRAVEL, Machine, draw_machine

CHAINS |= {
    "machining centre": ("XYZ", ["w-X-Y-b-Z-t"], ["fanuc-mill", "haas", "siemens"]),
    "horizontal centre": ("XYZ", ["w-Z-b-X-Y-t", "w-b-X-Z-Y-t"], ["siemens", "fanuc-mill"]),
    "bridge mill": ("XYZ", ["w-X-b-Y-Z-t"], ["heidenhain-iso", "siemens"]),
    "slant-bed lathe": ("XZ", ["w-b-Z-X-t"], ["fanuc-lathe", "haas"]),
}
TRAVEL |= {
    "machining centre": {"X": (500, 1100), "Y": (400, 610), "Z": (400, 560)},
    "horizontal centre": {"X": (500, 900), "Y": (500, 800), "Z": (500, 900)},
    "bridge mill": {"X": (1500, 3500), "Y": (1000, 2000), "Z": (500, 900)},
    "slant-bed lathe": {"X": (150, 300), "Z": (350, 1100)},
}
MILLS = ["machining centre", "machining centre", "horizontal centre", "bridge mill"]
STILL = ["full_cycles", "full_cycles", "step_cycles", "two_lines", "diagonals"]
FAST = ["feeds", "feeds", "grid"]
PLANS: dict[str, list[str]] = {
    "scale": [*STILL, "parts", "grid"],
    "pitch_shape": ["full_cycles", "full_cycles", "step_cycles", "two_lines"],
    "cyclic": ["periodic"],
    "backlash": ["full_cycles", "step_cycles", "circles", "periodic", "parts"],
    "backlash_position": ["full_cycles", "full_cycles", "step_cycles", "two_lines"],
    "windup": ["circles", "grid_crawl", "grid"],
    "reversal_spike": ["circles", "circles", "feeds", "grid"],
    "stick_slip": ["crawl", "grid_crawl"],
    "friction_asymmetry": FAST,
    "viscous_friction": FAST,
    "coulomb_friction": [*FAST, "crawl"],
    "servo_lag": FAST,
    "servo_mismatch": ["circles", "circles", *FAST],
    "inertia": FAST,
    "vibration": ["circles", *FAST],
    "encoder_cyclic": ["crawl", "crawl", "feeds"],
    "screw_heat": ["axis_heat"],
    "structure_drift": ["environment", "environment", "axis_heat"],
    "spindle_growth": ["spindle"],
    "squareness": ["circles", "circles", "diagonals", "grid"],
    "bow": ["straightness", "straightness", "grid"],
    "abbe": ["two_lines", "straightness", "diagonals"],
    "sag": ["straightness", "straightness", "grid"],
    "force_compliance": ["full_cycles", "step_cycles", "grid"],
    "tool_wear": ["parts"],
    "tool_size": ["parts"],
    "step_loss": ["full_cycles", "feeds", "axis_heat"],
    "laser_air": ["axis_heat", "axis_heat", "full_cycles"],
    "dead_path": ["environment", "axis_heat"],
    "cosine": ["twice", "twice", "diagonals"],
    "delay": FAST,
    "clock_skew": FAST,
}
ALIENS = [  # plans that show the aliens
    *["warm_circles", "grid", "feeds"] * 3,
    *["straightness", "parts"] * 2,
    "diagonals",
]


def spaced(r: Rng, m: Machine, ax: int, n: int) -> Array:
    """Targets at a set interval and a random part of a tenth or so of it (ISO 230-2), mm."""
    lo, hi = m.travel[ax]
    step = 0.92 * (hi - lo) / n
    p = lo + 0.05 * (hi - lo) + step * (np.arange(n) + r.uniform(-0.15, 0.15, n))
    return np.round(np.maximum(p, lo + 0.03 * (hi - lo)), 3)


def cycles(r: Rng, m: Machine, ax: int, poor: bool, step: bool = False, **more: object) -> Make:
    """Five runs to and fro over 11 to 31 targets (6 to 11 in steps), or one way and once."""
    n = int(r.integers(5, 8)) if poor else int(r.integers(6, 12) if step else r.integers(11, 32))
    force = {"n": n, "positions": spaced(r, m, ax, n), "runs": 1 if poor else 5, "laser": True}
    force["pattern"] = pick(r, ["uni", "iso"]) if poor else "step" if step else "iso"
    force |= {"at": inside(m, r, 0.3, 0.7), **more}
    return lambda t, name: targets(r, m, ax, t, name, force=force)


def periodic(r: Rng, m: Machine, ax: int, poor: bool) -> Make:
    """Two to three leads in steps of an 8th to a 16th of one, both directions, two runs; if poor
    one run one way in steps of about a third."""
    (lo, hi), lead = m.travel[ax], m.lead[ax]
    step = lead / (r.uniform(2.6, 3.4) if poor else r.uniform(8.0, 16.0))
    n = int(r.uniform(2, 3) * lead / step) + 2
    p = np.round(lo + (hi - lo) * r.uniform(0.2, 0.6) + step * np.arange(n), 3)
    runs, pattern = (1, "uni") if poor else (2, "iso")
    return cycles(r, m, ax, False, n=n, positions=p, runs=runs, pattern=pattern)


def two_lines(r: Rng, m: Machine, ax: int, poor: bool) -> list[Make]:
    """The same targets on two lines as far from each other as the arm's axis allows."""
    n, out = 6 if poor else int(r.integers(11, 22)), []
    p = spaced(r, m, ax, n)
    for share in (0.15, 0.8):
        at = inside(m, r, 0.45, 0.55)
        for a in m.axes:
            lo, hi = m.travel[a]
            at[a] = round(float(lo + share * (hi - lo)), 1)
        more = {"n": n, "positions": p, "at": at, "runs": 1 if poor else 3}
        out.append(cycles(r, m, ax, poor, **more))
    return out


def straight(r: Rng, m: Machine, ax: int, poor: bool) -> list[Make]:
    """Straightness towards each other axis and one angle, 9 to 21 targets, three runs both ways."""
    n = 6 if poor else int(r.integers(9, 22))
    force = {"n": n, "positions": spaced(r, m, ax, n), "runs": 1 if poor else 3}
    force |= {"pattern": "iso", "at": inside(m, r, 0.3, 0.7)}
    sides = [a for a in m.axes if a != ax][: 1 if poor else 2]
    out = [partial(_at_rest, r, m, ax, "straightness", {**force, "across": to}) for to in sides]
    return out if poor else [*out, partial(_at_rest, r, m, ax, "angle", force)]


def _at_rest(r: Rng, m: Machine, ax: int, what: str, force: dict, t: float, name: str) -> Rec:
    return targets(r, m, ax, t, name, what, force=force)


def diagonals(r: Rng, m: Machine, poor: bool) -> list[Make]:
    """Four body diagonals (two of a face), 6 to 15 steps, to and fro, two or three runs; one or
    two of them once if poor."""
    n, runs = (5, 1) if poor else (int(r.integers(6, 16)), int(r.integers(2, 4)))
    flips = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)][: 4 if len(m.axes) == 3 else 2]
    return [_diagonal(r, m, flip, n, runs) for flip in (flips[:2] if poor else flips)]


def _diagonal(r: Rng, m: Machine, flip: tuple, n: int, runs: int) -> Make:
    base, d = np.zeros(3), np.zeros(3)
    for a, s in zip(m.axes, flip, strict=False):
        lo, hi = m.travel[a]
        base[a] = lo + (0.08 if s > 0 else 0.92) * (hi - lo)
        d[a] = s * 0.84 * (hi - lo)
    one = [*np.linspace(0.02, 0.98, n)]
    way = [x for k in range(1, runs + 1) for x in _to_and_fro(one, k)]
    pts = [(np.round(base + s * d, 4), k) for s, k in way]
    meta = header_meta(
        m,
        quantity="displacement",
        sensitive=d / np.linalg.norm(d),
        rotvec=np.zeros(3),
        along=m.axes[0],
        instrument="laser interferometer",
        pattern="diagonal",
    )
    feed = logu(r, 1000, m.vmax)
    return lambda t, name: captures(m, name, pts, feed, t, 3.0, meta, r)


def _to_and_fro(at: list[float], run: int) -> list[tuple[float, int]]:
    """Places 0..1 with overrun at both ends (run 0)."""
    return [(0.0, 0), *[(x, run) for x in at], (1.0, 0), *[(x, run) for x in at[::-1]]]


def standing(r: Rng, m: Machine, ax: int, hours: float, tool: str) -> Make:
    """One place, read at a set interval of 1 to 3 minutes."""
    every, at = float(pick(r, [60.0, 120.0, 180.0])), inside(m, r, 0.3, 0.7)
    meta = header_meta(
        m,
        quantity="displacement",
        sensitive=np.eye(3)[ax],
        rotvec=np.zeros(3),
        along=ax,
        instrument=tool,
        pattern="standing",
    )
    pts = [(at - np.where(np.isin([0, 1, 2], m.axes), 5.0, 0.0), 0)]
    pts += [(at, 1)] * int(3600 * hours / every)
    return lambda t, name: captures(m, name, pts, 1000.0, t, every, meta, r)


def axis_heat(r: Rng, m: Machine, ax: int, poor: bool) -> Make:
    """Near, far and middle targets every 5 or 10 minutes, two to four hours of work and a rest of a
    quarter to a half of the time (ISO 230-3, clause 7); two targets one way for an hour if poor."""
    (lo, hi), gap = m.travel[ax], float(pick(r, [300.0, 600.0]))
    share = np.array([0.3, 0.85]) if poor else np.array([0.1, 0.5, 0.9])
    runs = int((1.0 if poor else r.uniform(2, 4)) * 3600 / gap)
    force = {"n": len(share), "positions": np.round(lo + share * (hi - lo), 1), "runs": runs}
    force |= {"pattern": "uni" if poor else "iso", "at": inside(m, r, 0.3, 0.7), "laser": True}
    force, work = force | {"gap": gap}, r.uniform(0.5, 0.75)

    def make(t: float, name: str) -> Rec:
        q = targets(r, m, ax, t, name, force=force)
        stop = float(q.t[0] + work * np.ptp(q.t))
        q.activity = [x for x in q.activity if x[0] < stop]
        return q

    return make


def circles(
    r: Rng, m: Machine, feeds: list[float], planes: list[list[int]], poor: bool
) -> list[Make]:
    """Full circles both ways, twice, one file for each feed and plane; one sense if poor."""
    out = []
    for plane in planes:
        room = min(float(np.ptp(m.travel[a])) for a in plane)
        force = {
            "plane": plane,
            "radius": float(pick(r, [x for x in (50, 100, 150) if x < room * 0.45][-2:] or [50])),
            "centre": inside(m, r, 0.48, 0.52),
            "arc": 360.0,
            "senses": [1] if poor else [1, -1],
            "reps": 1 if poor else 2,
        }
        for feed in feeds:
            out.append(partial(_circle, r, m, {**force, "feed": feed}))
    return out


def _circle(r: Rng, m: Machine, force: dict, t: float, name: str) -> Rec:
    return ballbar(r, m, t, name, force=force)


def visit(r: Rng, m: Machine, plan: str, suspect: str, poor: bool) -> list[Make]:
    """The files of a plan."""
    axes = [int(a) for a in r.permutation(m.axes)]
    if suspect in ("laser_air", "dead_path", "cosine"):  # a long way shows them
        axes.sort(key=lambda a: -np.ptp(m.travel[a]))
    if suspect == "abbe":  # the axis that has most others behind it
        axes = m.order()
    ax, some = axes[0], axes[: 1 if poor else int(r.integers(1, 3))]
    planes = [[0, 2]] if len(m.axes) == 2 else [[0, 1], [0, 2], [1, 2]]
    low, high = float(pick(r, [500, 1000])), float(pick(r, [2000, 3000, 5000]))
    watch = partial(standing, r, m, hours=1.0 if poor else r.uniform(3, 8))
    p = spaced(r, m, ax, 6 if poor else int(r.integers(9, 20)))
    all_planes = not poor and r.random() < 0.4
    many: dict[str, Callable[[], list[Make]]] = {
        "full_cycles": lambda: [cycles(r, m, a, poor) for a in some],
        "step_cycles": lambda: [cycles(r, m, a, poor, True) for a in some],
        "periodic": lambda: [*([] if poor else [cycles(r, m, ax, poor)]), periodic(r, m, ax, poor)],
        "twice": lambda: [cycles(r, m, ax, poor, positions=p, n=len(p))] * 2,
        "two_lines": lambda: two_lines(r, m, ax, poor),
        "straightness": lambda: straight(r, m, ax, poor),
        "diagonals": lambda: diagonals(r, m, poor),
        "environment": lambda: [watch(a, tool="laser interferometer") for a in some],
        "spindle": lambda: [watch(a, tool="capacitive sensor") for a in m.axes[-len(some) :]],
        "axis_heat": lambda: [axis_heat(r, m, a, poor) for a in some],
        "circles": lambda: (
            circles(r, m, [low], planes, poor)
            if all_planes
            else circles(r, m, [low] if poor else [low, high], planes[:1], poor)
        ),
        "warm_circles": lambda: circles(r, m, [low], planes[:1], False) * 4,
        "parts": lambda: [partial(features, r, m)] * (1 if poor else 2),
        "feeds": lambda: logs(r, m, "scale", poor),
        "grid": lambda: logs(r, m, "tool", poor),
        "crawl": lambda: crawl(r, m, "scale", poor),
        "grid_crawl": lambda: crawl(r, m, "tool", poor),
    }
    return many[plan]()


def experiment(r: Rng, suspect: str, masked: bool) -> tuple[Machine, list[Rec], dict, str]:
    """Machine, files in order of time, drivers asked for, and the plan's name; a suspect of ALIENS
    is a plan itself."""
    plan = suspect if suspect in ALIENS else str(pick(r, PLANS[suspect]))
    poor = r.random() < 0.25 and suspect not in ALIENS
    if masked and plan in ("parts", "feeds", "crawl"):  # none shows the machine's map
        plan = "full_cycles"
    kind = str(pick(r, MILLS if plan == "parts" else [*MILLS, "slant-bed lathe", "grinder"]))
    m = draw_machine(r, masked, kind, flat=plan == "parts")
    friction = "friction" in suspect
    drivers = {
        "load": suspect == "force_compliance" or r.random() < 0.1,
        "spindle": plan == "spindle" or r.random() < 0.1,
        "T": plan in ("axis_heat", "environment", "spindle") and r.random() < 0.9,
        "current": plan in (*FAST, "crawl") and r.random() < (0.85 if friction else 0.4),
    }
    t, recs = float(np.round(r.uniform(0, 60), 1)), []
    for i, make in enumerate(visit(r, m, plan, suspect, poor)):
        recs.append(make(t, f"r{i + 1}"))
        wait = logu(r, 2000, 6000) if plan == "warm_circles" else logu(r, 200, 2500)
        t = float(np.round(float(recs[-1].t[-1]) + wait, 1))
    return m, recs, drivers, plan


def absent(r: Rng, m: Machine, suspect: str) -> set[str]:
    """Thermometers that are not there: one screw's in four, one in ten of the one suspected."""
    share = 0.1 if suspect == "screw_heat" else 0.25
    return {f"T_screw_{AX[a]}_C" for a in m.axes if r.random() < share}
