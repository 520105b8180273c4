"""Tool wear: a ramp with the length that was cut, set back when the tool is changed.

It shows on measured parts, and at a gauge that measures the workpiece between two cuts. There tools
are changed after a number of parts, and parts are cut while the spindle runs.
"""

import numpy as np

from postproc.effects import State, along
from postproc.effects._named import by_name

PARAMETERS = {
    "rate_um": "um, wear of the edge from part to part; at a gauge, of its whole life",
    "start_um": "um, the quick wear of a new edge",
    "change": (
        "number of the part before which the tool was changed, 0: it was changed before no part"
    ),
    "worn_um": "um, wear of the first tool before the first part",
    "bores": (
        "1, a worn tool makes bores larger, as one tool post does; -1, it makes bores smaller, as"
        " an edge does"
    ),
    "life": "runs, of the gauge after which the tool is changed every time; 0, it is seen on parts",
    "older": "1, the first tool had cut before the gauge's first run; 0, it was new",
    "cut": (
        "parts, that a new tool has cut when the walls of its first part are finished: none, or"
        " half of one"
    ),
    "every": "parts, after which it is changed again every time; 0: it is not",
    "file": "number of the one recording in which it is changed, 0 the first; -1: in all",
}
SIZES = ("rate_um", "start_um", "worn_um")
OPTIONAL = {
    "bores": 1.0, "worn_um": 0.0, "life": 0.0, "older": 0.0, "cut": 0.0, "every": 0.0, "file": -1.0,
}  # fmt: skip
HALF = 0.5  # walls are finished, one with the other, when half of the part is cut
# A worn flank of 0.6 mm (ISO 3685, uneven wear) at 7 degrees of clearance has set the edge back by
# 74 um; a grinding wheel between two dressings by less.
PLAUSIBLE = {
    "rate_um": (-100.0, 100.0),
    "start_um": (-100.0, 100.0),
    "worn_um": (-100.0, 100.0),
}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
LINE = True  # an edge that wears on all sides is of no axis
NEEDS, SEES = ("part",), ("part", "gauge")
TEXT = (
    "The tool wears while it cuts. Tool wear offset, or a change of tool in time; measure after a"
    " change to be sure."
)
# of a gauge, of a life, after a change: without one it is any slow growth
FEWEST_RUNS, SHORTEST, AFTER = 8, 4, 3
QUICK = 0.1  # of its life: in which the edge breaks in
QUICKEST = 20.0  # parts: what breaks in and then does not wear is no edge
OF_REST = 0.3  # of the rest: by so much the quick wear may come out with the other sign


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    result = []
    parts = np.unique(_channel(state, "part")[_channel(state, "wall") != 0])
    if len(parts) > 1:
        ways = (1.0, -1.0) if _channel(state, "bore").any() else (1.0,)
        changes = [(0.0, 0.0, -1.0), *((float(p), 0.0, -1.0) for p in parts[1:])]
        # the first tool was new, and all cut the same number of parts
        changes += [(float(parts[n]), float(n), -1.0) for n in range(SHORTEST, len(parts) // 2 + 1)]
        changes += [(p, 0.0, file) for file, p in _of_one_file(state)]
        result += [
            {"change": p, "bores": w, "life": 0.0, "older": 0.0, "cut": c, "every": n, "file": file}
            for p, n, file in changes
            for w in ways
            for c in (0.0, HALF)
        ]
    most = max((len(np.unique(state.run[own])) for own in _gauged(state)), default=0)
    if most >= FEWEST_RUNS:
        lives = range(SHORTEST, most - AFTER + 1)
        result += [
            {
                "change": 0.0,
                "bores": 1.0,
                "life": float(n),
                "older": old,
                "cut": 0.0,
                "every": 0.0,
                "file": -1.0,
            }
            for n in lives
            for old in (0.0, 1.0)
        ]
    return result


def _of_one_file(state: State) -> list[tuple[float, float]]:
    """File and part of every change of tool in one of several recordings of parts."""
    walls = _channel(state, "wall") != 0
    files = np.unique(state.file[walls])
    if len(files) < 2:
        return []
    own = ((f, np.unique(_channel(state, "part")[walls & (state.file == f)])) for f in files)
    return [(float(f), float(p)) for f, parts in own for p in parts[1:]]


def sensible(rate_um: float, start_um: float, worn_um: float, life: float, **_: float) -> bool:
    """A tool only loses: the quick wear of a new edge, and what it had lost before, are of one sign
    with the rest and the quick wear is the smaller part."""
    if life <= 0:
        return abs(start_um) <= QUICKEST * abs(rate_um)
    return (
        start_um * rate_um > -OF_REST * rate_um**2
        and abs(start_um) < abs(rate_um)
        and worn_um * rate_um >= 0
    )


def columns(
    state: State,
    axis: str,
    change: float,
    bores: float = 1.0,
    life: float = 0.0,
    older: float = 0.0,
    cut: float = 0.0,
    every: float = 0.0,
    file: float = -1.0,
) -> np.ndarray:
    if life > 0 and axis:
        age, quick, old = _of_runs(state, life)
        return along(axis, age, quick, old) if older else along(axis, age, quick)
    # the same in every direction, of which a row reads that of its wall
    if not axis:  # of all axes alike: an edge that cuts on all sides
        each = [
            columns(state, x, change, bores, life, older, cut, every, file) for x in state.position
        ]
        return np.sum(each, axis=0)
    part, wall = _channel(state, "part"), _channel(state, "wall")
    wall = np.where(_channel(state, "bore") > 0, bores * wall, wall)
    known = part[wall != 0]
    first = float(known.min()) if len(known) else 0.0
    new = (part >= change) & (change > 0)
    if file >= 0:
        new &= state.file == file
    gone = np.where(new, part - change, part - first)
    gone = (np.mod(gone, every) if every > 0 else gone) + cut
    #    wear ^            .-'        rate_um a part, after start_um with which a new edge
    #         |      .--'            breaks in over its first parts: 1 - exp(-parts)
    #         |   .-'
    #         | /
    #         +-------------> parts  a change sets it back to zero
    parts = [wall * gone, wall * (1.0 - np.exp(-gone))]
    before = change > 0 and every <= 0
    return along(axis, *parts, wall * ~new) if before else along(axis, *parts)


def _of_runs(state: State, life: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(N,) age of the edge as a share of its life, how far it has broken in, and 1 for the first
    tool, of runs of a gauge; elsewhere 0."""
    age, quick, old = np.zeros(len(state)), np.zeros(len(state)), np.zeros(len(state))
    rpm = np.abs(_channel(state, "spindle_rpm"))
    for own in _gauged(state):
        _, number = np.unique(state.run[own], return_inverse=True)
        cut = np.ones(number.max() + 1)
        if rpm[own].any():
            cut = (np.bincount(number, rpm[own]) > 0).astype(float)
        # the first run gauges the workpiece before anything was cut
        cut[0] = 0.0
        first = (np.arange(len(cut)) // life * life).astype(int)  # the tool is new at these
        gone = np.cumsum(cut)
        share = (gone - gone[first])[number] / life
        age[own], quick[own], old[own] = share, 1.0 - np.exp(-share / QUICK), number < life
    return age, quick, old


def _gauged(state: State) -> list[np.ndarray]:
    """(N,) bool of each recording of a gauge."""
    gauged = _channel(state, "gauged") > 0
    return (
        [gauged & (state.file == f) for f in np.unique(state.file[gauged])] if gauged.any() else []
    )


def _channel(state: State, name: str) -> np.ndarray:
    return state.channels.get(name, np.zeros(len(state)))


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    worn_before = (named["change"] > 0 and named["every"] <= 0) or named["older"]
    return SIZES if worn_before else SIZES[:2]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted)
