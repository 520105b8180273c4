"""Machines in the format gcomp-machine/1: chains, tables, squareness, their true state.

Serial chain from the workpiece to the tool with all signs tool-relative-to-workpiece: every
joint moves all that follows it, so the arm of axis i is the sum of the later axes + tool -
measured_at (Schwenke et al. 2008, CIRP Annals 57; contract's two-axis formula is a case of it).
Lean (squareness): rotation vector x own travel (ISO 230-1).  Workpiece-side axes get no angle
tables, because the contract leaves their arm open.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .base import AX, Array, Rng, logu, pick, smooth

CHAINS = {
    "lathe": ("XZ", ["w-b-Z-X-t"], ["fanuc-lathe", "haas"]),
    "grinder": ("XZ", ["w-b-Z-X-t"], ["fanuc-lathe", "siemens"]),
    "mill": (
        "XYZ",
        ["w-X-Y-b-Z-t", "w-b-X-Y-Z-t", "w-X-b-Y-Z-t", "w-Y-b-X-Z-t"],
        ["fanuc-mill", "haas", "siemens", "heidenhain-iso"],
    ),
    "router": ("XYZ", ["w-b-X-Y-Z-t", "w-b-Y-X-Z-t", "w-Y-b-X-Z-t"], ["grbl", "linuxcnc"]),
}
TRAVEL = {
    "lathe": {"X": (110, 260), "Z": (250, 1600)},
    "grinder": {"X": (100, 220), "Z": (150, 900)},
    "mill": {"X": (300, 1300), "Y": (250, 800), "Z": (200, 600)},
    "router": {"X": (600, 4000), "Y": (500, 2500), "Z": (100, 260)},
}
LEANS = {"XZ": ("B", 0), "XY": ("C", 1), "YZ": ("A", 2), "XZ3": ("B", 2)}


@dataclass
class Machine:
    """What the machine is and what is stated about it (tables), lengths mm, errors um/urad."""

    name: str
    kind: str
    chain: str
    control: str
    axes: list[int]
    travel: dict[int, tuple[float, float]]
    lead: dict[int, float]
    feedback: dict[int, str]
    stiffness: dict[int, float]
    nodes: dict[int, Array]
    tables: dict[int, dict[str, tuple[Array, Array]]]
    square: dict[str, float]
    tool: Array
    measured: dict[int, Array]
    u: float
    u_file: bool
    vmax: float
    amax: float
    length: float = 0.3
    map_true: dict[tuple[int, str], Array] = field(default_factory=dict)

    def order(self) -> list[int]:
        """Axes from the workpiece to the tool."""
        return [AX.index(c) for c in self.chain.split("-") if c in AX]

    def tool_side(self) -> list[int]:
        """Axes on the tool's side of the bed."""
        return [AX.index(c) for c in self.chain.split("-b-")[1].split("-") if c in AX]

    def pairs(self) -> list[str]:
        """Axis pairs, letters ascending."""
        return ["XZ"] if len(self.axes) == 2 else ["XY", "XZ", "YZ"]

    def lean(self, pair: str) -> tuple[str, Array, int]:
        """Name in [squareness], rotation direction and leaning axis of a pair."""
        rot, ax = LEANS["XZ3" if pair == "XZ" and len(self.axes) == 3 else pair]
        unit = np.zeros(3)
        unit["ABC".index(rot)] = 1.0
        return f"{rot}0{AX[ax]}", unit, ax

    def arm(self, ax: int, pos: Array) -> Array:
        """Arm (n,3) mm from the place where axis `ax` was measured to the functional point."""
        later = self.order()[self.order().index(ax) + 1 :]
        arm = np.tile(self.tool, (len(pos), 1)).astype(float)
        for j in later:
            arm[:, j] += pos[:, j] - self.measured[ax][j]
        return arm


def lookup(m: Machine, ax: int, comp: str, pos: Array, sgn: Array) -> Array:
    """Stated value of one component at the places, column by the direction of its axis."""
    fwd, rev = m.tables[ax][comp]
    x, s = pos[:, ax], sgn[:, ax]
    f, b = np.interp(x, m.nodes[ax], fwd), np.interp(x, m.nodes[ax], rev)
    return np.where(s > 0, f, np.where(s < 0, b, (f + b) / 2))


def place(comp: str, ax: int, value: Array, arm: Array) -> tuple[Array, Array]:
    """Tool error (n,3) um and rotation (n,3) urad of one component's value."""
    tool, rot = np.zeros((len(value), 3)), np.zeros((len(value), 3))
    if comp[1] in AX:
        tool[:, AX.index(comp[1])] = value
    else:
        rot[:, "ABC".index(comp[1])] = value
        tool = np.cross(rot, arm) * 1e-3
    return tool, rot


def stated(m: Machine, pos: Array, sgn: Array) -> tuple[Array, Array]:
    """Tool error (n,3) um and rotations (n,3) urad that the machine files say."""
    tool, rot = np.zeros((len(pos), 3)), np.zeros((len(pos), 3))
    for ax in m.axes:
        arm = m.arm(ax, pos)
        for comp in m.tables[ax]:
            a, b = place(comp, ax, lookup(m, ax, comp, pos, sgn), arm)
            tool, rot = tool + a, rot + b
    for pair in m.pairs():
        name, unit, ax = m.lean(pair)
        own = np.zeros((len(pos), 3))
        own[:, ax] = pos[:, ax]
        tool += np.cross(unit * m.square[name], own) * 1e-3
    return tool, rot


def draw_machine(
    r: Rng, masked: bool = False, kind: str | None = None, flat: bool = False
) -> Machine:
    """A machine; `masked` makes the known geometry 20-80 um, `flat` leaves zero tables."""
    kind = kind or pick(r, ["lathe", "grinder", "mill", "mill", "router"])
    letters, chains, controls = CHAINS[kind]
    axes = [AX.index(c) for c in letters]
    travel, nodes, tables, measured = {}, {}, {}, {}
    size = logu(r, 20, 80) if masked else logu(r, 0.7, 8)
    both = r.random() < 0.4
    chain = pick(r, chains)
    m = Machine(
        f"m{r.integers(10000):04d}",
        kind,
        chain,
        pick(r, controls),
        axes,
        travel,
        {},
        {},
        {},
        nodes,
        tables,
        {},
        np.zeros(3),
        measured,
        logu(r, 0.1, 1.0),
        bool(r.random() < 0.5),
        logu(r, 5e3, 3e4),
        logu(r, 800, 4000),
        float(r.uniform(0.15, 0.4)),
    )
    for a in axes:
        lo, hi = TRAVEL[kind][AX[a]]
        span = round(logu(r, lo, hi), -1)
        start = float(pick(r, [-5.0, 0.0, -round(span / 2), -10.0]))
        travel[a] = (start, start + span)
        m.lead[a] = float(pick(r, [4, 5, 6, 10, 12, 16, 20]))
        m.feedback[a] = str(pick(r, ["motor", "scale"]))
        m.stiffness[a] = logu(r, 20, 200)
        nodes[a] = np.round(np.linspace(*travel[a], int(r.integers(6, 31))), 3)
        x = (nodes[a] - start) / span
        tables[a] = {}
        angles = a in m.tool_side() and r.random() < 0.65
        names = [f"E{c}{AX[a]}" for c in letters]
        names += [f"E{c}{AX[a]}" for c in ("B" if len(axes) == 2 else "ABC")] if angles else []
        for comp in names:
            rot = comp[1] in "ABC"
            big = min(size, 0.35 * span) * r.uniform(0.4, 1.0)
            big *= r.uniform(1, 3) if rot else 1.0
            f = np.zeros(len(x)) if flat else big * (smooth(r, x, 0.35) - x * r.normal())
            f = np.round(f - f[0], 3)
            b = f.copy()
            if both and comp[1] == AX[a] and not flat:
                b = np.round(f + abs(r.normal(0, 1.5)) + 0.2 * smooth(r, x, 0.5), 3)
            tables[a][comp] = (f, b)
        measured[a] = np.zeros(3)
        for j in axes:
            if j != a:
                measured[a][j] = round(float(r.choice([0.0, 50.0, -20.0])), 1)
    if r.random() < 0.5 and not flat:
        for a in axes:
            m.tool[a] = round(float(r.uniform(-80, 120)), 1)
    for pair in m.pairs():
        lean = float(r.normal(0, min(4 * size, 120.0)))
        m.square[m.lean(pair)[0]] = 0.0 if flat else round(lean, 2)
    return m


def draw_map_error(m: Machine, r: Rng, factor: float) -> None:
    """True minus stated, a smooth process over place for each component, 12 knots, sd u*factor."""
    root = np.linalg.cholesky(map_prior(m))
    for a in m.axes:
        for comp in m.tables[a]:
            m.map_true[a, comp] = m.u * factor * (root @ r.normal(size=12))


def map_prior(m: Machine) -> Array:
    """Unit covariance of the map error at its 12 knots (squared exponential over place)."""
    k = np.linspace(0, 1, 12)
    return np.exp(-0.5 * ((k[:, None] - k) / m.length) ** 2) + 1e-6 * np.eye(12)


def hat(m: Machine, ax: int, x: Array) -> Array:
    """Linear interpolation weights (n,12) of the map error's knots."""
    s = np.clip((x - m.travel[ax][0]) / (m.travel[ax][1] - m.travel[ax][0]), 0, 1) * 11
    i = np.minimum(s.astype(int), 10)
    w = np.zeros((len(x), 12))
    w[np.arange(len(x)), i] = 1 - (s - i)
    w[np.arange(len(x)), i + 1] = s - i
    return w


def map_error(m: Machine, pos: Array) -> tuple[Array, Array]:
    """Tool error and rotations of true minus stated geometry."""
    tool, rot = np.zeros((len(pos), 3)), np.zeros((len(pos), 3))
    for (ax, comp), v in m.map_true.items():
        a, b = place(comp, ax, hat(m, ax, pos[:, ax]) @ v, m.arm(ax, pos))
        tool, rot = tool + a, rot + b
    return tool, rot
