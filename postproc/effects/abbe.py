"""Abbe error: a rotation of an axis times an arm: a measured rotation with an arm that the
machine's file does not know, or a rotation that nobody measured, seen on lines that lie apart.

ISO 230-1, error motions of linear axes. What nobody measured is drawn as Legendre polynomials of
degree 1 to 5 over the travel.
"""

from itertools import product

import numpy as np

from postproc.effects import UM, XYZ, Grid, State, Table, along, legendre
from postproc.effects._named import by_name

DEGREES, DRAWN = (1, 2, 3, 4, 5), (1.0, 3.0, 5.0)
# A chord of 1/160 of the travel misses the fifth polynomial by 0.2 % of its share at most (at the
# ends, where |P5''| = 105).
NODES = 161
APART = 1.0  # mm
PARAMETERS = {
    "turn": "0, 1, 2: A, B, C, the rotation",
    "arm": "0, 1, 2: X, Y, Z, the direction of the arm",
    "arm_mm": "mm, the arm that was left out of a measured rotation",
    "known": "1, the rotation is that of the machine's file; 0, the machine's file lacks it",
    "zero_mm": "mm, where on the axis along the arm a rotation that the file lacks does nothing",
    "of_file": (
        "1, it acts on all arms that the machine's file has; 2, it acts on all arms that the"
        " machine's file has but the axis' own position, as where straightness was measured at the"
        " tool; 0, it acts on one arm"
    ),
    **{
        f"c{k}_urad": f"urad, share of the Legendre polynomial of degree {k} in it" for k in DEGREES
    },
    "degree": "number, of the last polynomial that such a rotation is drawn with",
}
OPTIONAL = {
    "arm_mm": 0.0, "known": 1.0, "zero_mm": 0.0, "of_file": 0.0,
    **{f"c{k}_urad": 0.0 for k in DEGREES}, "degree": 5.0,
}  # fmt: skip
# Beyond 500 mm the tool is not on that carriage, and more of an arm is a rotation that happens to
# look like something else. Ways of a router turn by 1 mm on 1 m (unverified: usual sizes).
DRAWN_BY = tuple(f"c{k}_urad" for k in DEGREES)
PLAUSIBLE = {"arm_mm": (-500.0, 500.0), **{f"c{k}_urad": (-1000.0, 1000.0) for k in DEGREES}}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool", "angle")
TEXT = (
    "A rotation of the axis, or its arm, is not in the model. Write a measured angle into the axis'"
    " table (EBX and so on), state where it was measured and how long the tool is; measure at two"
    " heights."
)
OF_FILE, BUT_OWN = 1.0, 2.0
# twice the logarithm of how much seldomer a rotation is left out than an error of position or a
# bow, which look alike on one line (unverified: twenty times)
UNREAD = 6.0
ZEROS = np.linspace(-0.5, 1.5, 21)  # of the travel


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    turns = np.flatnonzero(state.angles.get(axis, np.zeros((3, 1))).any(axis=1))
    ways = [(float(k), float(a), 1.0, 0.0, 0.0, 5.0) for k in turns for a in range(3) if a != k]
    for other in state.lines.get(axis, ""):
        low, high = state.travel[other]
        arm = XYZ.index(other)
        zeros = [round(float(low + z * (high - low)), 3) for z in ZEROS]
        turn = float(3 - arm - XYZ.index(axis))
        ways += [(turn, float(arm), 0.0, z, 0.0, d) for z, d in product(zeros, DRAWN)]
    if axis in state.arms and (state.turned.any() or _on_lines_apart(state, axis)):
        arms = (OF_FILE, BUT_OWN) if axis in state.on_arm else (OF_FILE,)
        ways += [(t, 0.0, 0.0, 0.0, a, d) for t, a, d in product((0.0, 1.0, 2.0), arms, DRAWN)]
    names = ("turn", "arm", "known", "zero_mm", "of_file", "degree")
    return [dict(zip(names, way, strict=True)) for way in ways]


def further_cost(axis: str, shape: dict[str, float]) -> float:
    """Twice the logarithm of how much seldomer a shape is than the others of this effect."""
    return UNREAD if shape["of_file"] else 0.0


def _on_lines_apart(state: State, axis: str) -> bool:
    """Whether the arm changes by more than with the axis' own place: on one line an error of
    position or a bow is the same."""
    # what is left is how far lines lie apart, or the tool's length changes
    reach = state.arms[axis].copy()
    if axis in state.on_arm:
        reach[XYZ.index(axis)] -= state.position[axis]
    return bool((np.ptp(reach, axis=1) > APART).any())


def columns(
    state: State,
    axis: str,
    turn: float,
    arm: float,
    known: float = 1.0,
    zero_mm: float = 0.0,
    of_file: float = 0.0,
    degree: float = 5.0,
) -> np.ndarray:
    if of_file:
        return _missing(state, axis, turn, of_file, degree)
    turned, reach = np.zeros((3, len(state))), np.zeros((3, len(state)))
    # an angular instrument reads the rotation itself, whatever the arm: its rows have none
    reach[int(arm)] = 1.0 if not len(state.turned) else ~state.turned
    if known:
        turned[int(turn)] = state.angles[axis][int(turn)]
        return np.cross(turned, reach, axis=0)[None]
    out = (
        # urad times mm is 1e-3 um. Zero at zero_mm: what the rotation does there is in the axis'
        # own curve, and from one line alone the two can not be told apart.
        _sense(axis, turn, arm) * (state.position[XYZ[int(arm)]] - zero_mm) * 1e-3 * reach[int(arm)]
    )
    return along(axis, *(out * legendre(state.share(axis), k) for k in DEGREES[: int(degree)]))


def _missing(state: State, axis: str, turn: float, of_file: float, degree: float) -> np.ndarray:
    """(K, 3, N) mm and rad per urad of a rotation that the tables lack: what the tool does at the
    end of its arm, and what an angular instrument reads."""
    if axis not in state.arms:
        raise KeyError(f"the arm of {axis}")
    unit = np.zeros((3, len(state)))
    # 1e-6: one urad in rad
    unit[int(turn)] = UM**2
    own = np.zeros_like(unit)
    if of_file == BUT_OWN:
        own[XYZ.index(axis)] = state.position[axis]
    # rotation times arm, as in machine/chain.py; without the own position where `of_file` says so
    moved = np.cross(unit, state.arms[axis] - own, axis=0)
    if len(state.turned):
        # rad, not mm: that is what these rows read
        moved[:, state.turned] = unit[:, state.turned]
    return np.stack([moved * legendre(state.share(axis), k) for k in DEGREES[: int(degree)]])


def _sense(axis: str, turn: float, arm: float) -> float:
    """Which way along the axis a positive rotation moves the end of a positive arm."""
    return float(np.cross(np.eye(3)[int(turn)], np.eye(3)[int(arm)])[XYZ.index(axis)])


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    return ("arm_mm",) if named["known"] else DRAWN_BY[: int(named["degree"])]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "arm_mm", *DRAWN_BY, of=_fitted)


def by_angle(
    axis: str, nodes: np.ndarray, forward: np.ndarray, reverse: np.ndarray, **named: float
) -> list[Table]:
    """Tables of the arm that a measured rotation lacks. forward, reverse (3, K) rad at nodes (K,)
    mm: A, B, C of the axis."""
    if not named["known"] or not named["arm_mm"]:
        return []
    reach = np.zeros((3, len(nodes)))
    reach[int(named["arm"])] = named["arm_mm"]
    turn = int(named["turn"])
    only = (np.arange(3) == turn)[:, None]
    there, back = (np.cross(only * angle, reach, axis=0) for angle in (forward, reverse))
    return [
        (f"E{x}", axis, nodes, there[i], back[i])
        for i, x in enumerate(XYZ)
        if there[i].any() or back[i].any()
    ]


def arm_tables(
    axis: str, travel: tuple[float, float], measured: tuple[float, float] | None, **named: float
) -> list[Table]:
    """The table of a rotation that the machine's file lacks, rad; with what takes away its effect
    on the axis' own position, mm, where that is not on the arm. measured mm: beyond, the rotation
    stays what it was there."""
    if not named.get("of_file"):
        return []
    nodes, turned_urad = _drawn(travel, named, measured or travel)
    value, turn = turned_urad * UM**2, int(named["turn"])
    found = [(f"E{'ABC'[turn]}", axis, nodes, value, value)]
    if named["of_file"] == BUT_OWN and turn != XYZ.index(axis):
        # The chain (machine/chain.py) multiplies the rotation by the whole arm, the axis' own
        # position in it. Where straightness was measured at the tool it must not: what the own
        # position does acts along the third direction, and is taken away there.
        across = 3 - turn - XYZ.index(axis)
        own = -_sense(XYZ[across], turn, XYZ.index(axis)) * value * nodes
        found.append((f"E{XYZ[across]}", axis, nodes, own, own))
    return found


def _drawn(
    travel: tuple[float, float], named: dict[str, float], measured: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (K,) mm over a travel, and the rotation (K,) urad at them."""
    nodes = np.union1d(np.linspace(*travel, NODES), np.clip(measured, *travel))
    u = 2 * (np.clip(nodes, *measured) - travel[0]) / (travel[1] - travel[0]) - 1
    return nodes, sum((named[f"c{k}_urad"] * legendre(u, k) for k in DEGREES), np.zeros(len(u)))


def grids(axis: str, travel: dict[str, tuple[float, float]], **named: float) -> list[Grid]:
    """(component, axis, other, nodes, others, values (K, L) mm) of a rotation that nobody
    measured."""
    if named["known"] or named.get("of_file"):
        return []
    other = XYZ[int(named["arm"])]
    nodes, turned_urad = _drawn(travel[axis], named, travel[axis])
    others = np.array(travel[other])
    value = (
        turned_urad[:, None]
        * (others - named["zero_mm"])
        * 1e-3
        * _sense(axis, named["turn"], named["arm"])
        * UM
    )
    return [(f"E{axis}", axis, other, nodes, others, value)]
