"""Target designs of the fresh family.  Do not read while working on the judged tool.

Halving: ends, middle, quarters ... (van der Corput 1935), every second run in the mirrored order,
so that place and time hardly go together (Cox 1951, designs in the presence of trend).  Home: the
first target is read again between all others, as drift is checked in comparisons (NIST, Croarkin
1984).  Area: parallel lines over a plane against a long plane mirror, to and fro (Zhang, Ouyang
and Lu 1988, lines for volumetric errors; Bobroff 1993).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, logu, pick
from .designs import ORDERS, captures, header_meta, inside, targets
from .machines import Machine


def halving(p: Array, k: int, over: float) -> list[tuple[float, int]]:
    """Bit-reversed order; even runs go through the mirrored places."""
    bits = max(1, int(np.ceil(np.log2(max(len(p), 2)))))
    rank = [int(f"{i:0{bits}b}"[::-1], 2) for i in range(2**bits)]
    turn = [i for i in rank if i < len(p)]
    x = p if k % 2 else p[::-1]
    return [(p[0] - over, 0), *[(float(x[i]), k) for i in turn]]


def home(p: Array, k: int, over: float) -> list[tuple[float, int]]:
    """First target, second, first, third, first ...; from below, as the first one is the lowest."""
    out = [(p[0] - over, 0), (p[0], k)]
    for x in p[1:]:
        out += [(float(x), k), (p[0] - over, 0), (p[0], k)]
    return out


ORDERS["halving"], ORDERS["home"] = halving, home


def area(r: Rng, m: Machine, t0: float, name: str) -> Rec:
    """Lines along one axis at several places of another, in serpentines, there and back."""
    ax = int(pick(r, m.axes))
    to = int(pick(r, [a for a in m.axes if a != ax]))
    n, lines, runs = int(r.integers(5, 16)), int(r.integers(3, 8)), int(r.integers(1, 4))
    at = inside(m, r)
    grids = []
    for a, k in ((ax, n), (to, lines)):
        lo, hi = m.travel[a]
        b, e = sorted(r.uniform([0.05, 0.65], [0.25, 0.95]))
        grids.append(np.round(np.linspace(lo + (hi - lo) * b, lo + (hi - lo) * e, k), 3))
    pts = []
    for run in range(1, runs + 1):
        first = at.copy()
        first[ax], first[to] = grids[0][0] - 0.5, grids[1][0] - 0.5
        pts.append((first, 0))
        way = [
            (i, j) for j in range(lines) for i in (range(n) if j % 2 == 0 else range(n - 1, -1, -1))
        ]
        for i, j in way if run % 2 else way[::-1]:
            p = at.copy()
            p[ax], p[to] = grids[0][i], grids[1][j]
            pts.append((p, run))
    sens = np.zeros(3)
    sens[ax if r.random() < 0.7 else to] = 1.0
    meta = header_meta(
        m,
        quantity="displacement",
        sensitive=sens,
        rotvec=np.zeros(3),
        along=ax,
        instrument="plane mirror interferometer",
        pattern="area",
    )
    return captures(m, name, pts, logu(r, 300, m.vmax), t0, r.uniform(2, 5), meta, r)


def draw(r: Rng, m: Machine, kind: str, t0: float, name: str) -> Rec | None:
    """A file of a new design in two of three runs at rest; None leaves it to the old ones."""
    if kind not in ("displacement", "straightness", "angle", "long") or r.random() < 1 / 3:
        return None
    pattern = pick(r, ["halving", "home", "area"])
    if kind == "displacement" and pattern == "area":
        return area(r, m, t0, name)
    force: dict = {"pattern": pick(r, ["halving", "home"])}
    ax = int(pick(r, m.axes))
    if kind == "long":
        force |= {
            "n": int(r.integers(3, 20)),
            "runs": int(r.integers(4, 13)),
            "laser": True,
            "gap": pick(r, [300.0, 600.0, 1200.0, 2400.0]),
        }
        kind = "displacement"
    else:
        force |= {"n": round(logu(r, 6, 80))}
    return targets(r, m, ax, t0, name, kind, force=force)
