"""Sag: a structure bends with the place of a mass on it.

Where a load of the axis was recorded that changed, it may sag in proportion to it. What is held at
one end gives at its end with s^2 (3 - s) / 2 of the mass' reach s, be it from an edge of what
carries it on; a ram that slides out gives with s^3 of its own overhang (Slocum, Precision Machine
Design, 1992, beams). A rail that is clamped at both ends gives under the mass with (4 s (1 - s))^3,
a beam that is clamped at one end and propped at the other with s^3 (1 - s)^2 (4 - s), s from the
clamped end (Young, Budynas, Roark's Formulas for Stress and Strain, table 8.1). A beam on two
supports is lowered at s by a mass at a by the sum over n of sin(n pi a) sin(n pi s) / n^4
(Timoshenko, Vibration Problems in Engineering, simply supported beam); where the tool stands over
the mass, a is s. A carriage on two rails rests on each with its share w and 1 - w of the way
between them (the lever rule), and at its place on the way sees as much of each: w^2 + (1 - w)^2.
"""

from itertools import permutations, product

import numpy as np

from postproc.effects import UM, XYZ, Grid, State
from postproc.effects import along as towards
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": (
        "um, of what is held at one end the deviation where it gives most, of a beam on two"
        " supports what its first wave is lowered by: with the mass in its middle the deviation"
        " there is -1.012 times as much"
    ),
    "along": "0, 1, 2: X, Y, Z, the direction of the error",
    "lever": "1, it grows with the place of the next axis too; 0, it does not",
    "beam": (
        "0, 1, 2: X, Y, Z, the axis that runs along the beam, be it the mass' own; -1, what gives"
        " is held at one end"
    ),
    "overhang": "1, by how much of the travel the beam is longer at each end",
    "free_end": (
        "1, what is held at one end is free at the high end of the travel; -1, it is free at the"
        " low end; 0, a rail that is clamped at both ends"
    ),
    "propped": "1, its free end is propped; 0, it is not",
    "begins": (
        "1, share of the travel from where it stands out; below 0, it stands out all over it"
    ),
    "ram": "1, it slides out itself; 0, a mass moves on it",
    "rails": (
        "0, 1, 2: X, Y, Z, the axis that runs from one of two rails to the other, which bend alike;"
        " -1, there is one"
    ),
    "usual_N": (
        "N, the recorded load at which it sags so, and elsewhere in proportion; 0, alike at every"
        " load"
    ),
}
# Twice the logarithm of how much seldomer a curve of the own place alone is sag: it is how straight
# the axis moves, which `bow` stands for; a second axis or a load tells that a mass bends it.
OWN_PLACE = 8.0
LONGER = 0.0, 0.05, 0.2  # of the travel, at each end
MOVES = 1e-3  # mm
NODES = 25  # over a travel: between them less than 1 % of the size is left
OPTIONAL = {
    "lever": 0.0, "beam": -1.0, "overhang": 0.0, "free_end": 1.0, "propped": 0.0, "begins": 0.0,
    "ram": 0.0, "rails": -1.0, "usual_N": 0.0,
}  # fmt: skip
# free end, whether it is propped, from where it stands out, whether it is a ram
OUT = (
    (1.0, 0.0, 0.0, 0.0),
    (-1.0, 0.0, 0.0, 0.0),
    *product((1.0, -1.0), (0.0,), (0.2, 0.4), (0.0,)),
    *product((1.0, -1.0), (0.0,), (-0.15,), (1.0,)),
    *product((1.0, -1.0), (1.0,), (0.0,), (0.0,)),
    (0.0, 0.0, 0.0, 0.0),
)
PROPPED = 0.117749  # s^3 (1 - s)^2 (4 - s) where it is largest, at 2 less the root of 2
# A beam of steel that was built to run true gives 1 in 2000 of its length at the most (unverified):
# 1 mm on 2 m.
PLAUSIBLE = {"size_um": (-1000.0, 1000.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = (
    "A moving mass bends what carries it. Measure the straightness with the mass at both ends; the"
    " compensator corrects it by the places of both axes."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    others = [float(XYZ.index(x)) for x in state.position if x != axis and x in XYZ]
    moving = _moving(state, others)
    beams = (*moving, float(XYZ.index(axis)))
    ways = [(a, 0.0, -1.0, 0.0, *out, -1.0) for a, out in product(others, OUT)]
    ways += [(a, 1.0, -1.0, 0.0, *OUT[0], -1.0) for a in others if {*moving} - {a}]
    ways += [(a, 0.0, b, o, *OUT[0], -1.0) for a, b, o in product(others, beams, LONGER)]
    rails = product(_rails(state, others), LONGER)
    ways += [(a, 0.0, beams[-1], o, *OUT[0], b) for (a, b), o in rails]
    load = state.channels.get(f"load_{axis}_N", np.zeros(1))
    usual = [float(np.median(np.abs(load[load != 0])))] if np.ptp(load) > 0 else []
    names = [n for n in PARAMETERS if n != "size_um"]
    return [dict(zip(names, (*way, u), strict=True)) for u in (0.0, *usual) for way in ways]


def _rails(state: State, others: list[float]) -> list[tuple[float, ...]]:
    """Numbers of the direction of an error and of an axis that runs from rail to rail, of which two
    places are known."""
    moving = _moving(state, others)
    return [p for p in permutations(others, 2) if p[1] in moving]


def _moving(state: State, axes: list[float]) -> list[float]:
    """Numbers of those axes of which two places are known."""
    return [k for k in axes if np.ptp(state.position[XYZ[int(k)]]) > MOVES]


def further_cost(axis: str, shape: dict[str, float]) -> float:
    """Twice the logarithm of how much seldomer a shape is than the others of this effect."""
    beam = int(shape["beam"])
    alone = not shape["lever"] and not shape["usual_N"] and (beam < 0 or XYZ[beam] == axis)
    alone = alone and shape["rails"] < 0
    return OWN_PLACE if alone else 0.0


def columns(
    state: State,
    axis: str,
    along: float,
    lever: float = 0.0,
    beam: float = -1.0,
    overhang: float = 0.0,
    free_end: float = 1.0,
    propped: float = 0.0,
    begins: float = 0.0,
    ram: float = 0.0,
    rails: float = -1.0,
    usual_N: float = 0.0,
) -> np.ndarray:
    reach = (state.share(axis) + 1) / 2
    load = state.channels.get(f"load_{axis}_N")
    heavy = load / usual_N if load is not None and usual_N > 0 else np.ones(len(reach))
    other = _other(axis, tuple(state.position), along, lever, beam)
    if not other:
        bent = _held(reach, free_end, propped, begins, ram) if beam < 0 else np.zeros(len(reach))
        return towards(XYZ[int(along)], heavy * bent)
    place = (state.share(other) + 1) / 2
    #     rail ----o----- rail      share w of the load on one, 1 - w on the other; each sinks by
    #          1 - w   w            its share, and the carriage sees w of the one and 1 - w of the
    #                               other: w**2 + (1 - w)**2
    cross = _cross(rails)
    if cross in state.position:
        heavy = heavy * _shared((state.share(cross) + 1) / 2)
    return towards(XYZ[int(along)], heavy * _bent(reach, place, beam, overhang))


def _shared(between: np.ndarray) -> np.ndarray:
    """(N,) of what one rail gives under all of the load, by the place between two, 0 to 1."""
    return between**2 + (1.0 - between) ** 2


def _other(axis: str, letters: tuple[str, ...], along: float, lever: float, beam: float) -> str:
    """The second axis on whose place it depends; "" for none."""
    if beam >= 0:
        return XYZ[int(beam)] if XYZ[int(beam)] in letters else ""
    rest = [x for x in letters if x in XYZ and x not in (axis, XYZ[int(along)])]
    return rest[0] if rest and lever else ""


def _held(
    reach: np.ndarray,
    free_end: float = 1.0,
    propped: float = 0.0,
    begins: float = 0.0,
    ram: float = 0.0,
) -> np.ndarray:
    """(N,) what gives that is held at one end, or clamped at both, by where the mass is on the
    travel, 0 to 1; 1 where it gives most."""
    if not free_end:
        return (4.0 * reach * (1.0 - reach)) ** 3
    #    clamped   #------m---o  free     s from the clamped end; free_end -1: the other way round
    #    propped   #------m---^
    #    begins:   where on the travel, 0 to 1, the mass leaves the support; below 0: before it
    if propped:
        s = reach if free_end > 0 else 1.0 - reach
        return s**3 * (1.0 - s) ** 2 * (4.0 - s) / PROPPED
    out = np.maximum((reach if free_end > 0 else 1.0 - reach) - begins, 0.0) / (1.0 - begins)
    return out**3 if ram else out**2 * (3 - out) / 2


def _bent(mass: np.ndarray, place: np.ndarray, beam: float, overhang: float) -> np.ndarray:
    """For a size of 1: by the places of the mass and of what it bends, both 0 to 1 over the
    travel."""
    if beam < 0:
        return _held(mass) * place
    a, s = ((overhang + u) / (1 + 2 * overhang) for u in (mass, place))
    bent = np.zeros(np.broadcast_shapes(np.shape(a), np.shape(s)))
    # the fifth wave is 1/625 of the first
    for n in range(1, 5):
        bent -= np.sin(n * np.pi * a) * np.sin(n * np.pi * s) / n**4
    return bent


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um")


def grids(axis: str, travel: dict[str, tuple[float, float]], **named: float) -> list[Grid]:
    """(component, axis, other, nodes, others, values (K, L) mm), at the usual load; where no second
    axis matters, alike at both its ends."""
    other = _other(axis, tuple(travel), named["along"], named["lever"], named["beam"])
    alone = other == axis or named["beam"] < 0
    if not (other or alone):
        return []
    # alike wherever the second axis stands: two nodes with one value
    few = 2 if alone and named["rails"] < 0 else NODES
    share, across = np.linspace(0.0, 1.0, NODES)[:, None], np.linspace(0.0, 1.0, few)[None]
    if other and other != axis:
        value = _bent(share, across, named["beam"], named["overhang"])
    else:
        value = _own(share, across, bool(other), named)
        seconds = [x for x in travel if x in XYZ and x != axis]
        other = _cross(named["rails"]) or next(iter(seconds), "")
    if other not in travel:
        return []
    nodes, others = (
        low + part.ravel() * (high - low)
        for part, (low, high) in zip((share, across), (travel[axis], travel[other]), strict=True)
    )
    component = f"E{XYZ[int(named['along'])]}"
    return [(component, axis, other, nodes, others, named["size_um"] * value * UM)]


def _own(share: np.ndarray, across: np.ndarray, beam: bool, named: dict[str, float]) -> np.ndarray:
    """(K, L) of a sag by its own place (K, 1) alone, on two rails also by that (1, L) between
    them."""
    out = (named[name] for name in ("free_end", "propped", "begins", "ram"))
    one = _bent(share, share, named["beam"], named["overhang"]) if beam else _held(share, *out)
    return one * (_shared(across) if named["rails"] >= 0 else np.ones_like(across))


def _cross(rails: float) -> str:
    """The axis that runs from rail to rail; "" for none."""
    return XYZ[int(rails)] if rails >= 0 else ""
