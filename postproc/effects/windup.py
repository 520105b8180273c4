"""Windup: a reversal error that builds up with the distance after the reversal (pre-sliding
friction, an elastic drive).

After a long way and one turn it is Dahl's model (A solid friction model, 1968): 1 - 2 exp(-way /
length). That is a drive of plays (Prandtl-Ishlinskii) whose thresholds r are as frequent as exp(-2
r / length), and such a drive has Masing's rules: every way since a turn, until it is as long as the
one before, adds its own size * (1 - exp(-way / length)) to what was remembered (Al-Bender,
Lampaert, Swevers, The generalized Maxwell-slip model, IEEE Trans. Automatic Control 50, 2005). A
screw is the softer the farther the nut is from the end that is held (Altintas and others, Machine
tool feed drives, CIRP Annals 60 (2011) 779): then it winds up more at one end of the travel.
"""

import numpy as np

from postproc.effects import UM, State, Table, along, grid, sampled
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": "um, lost motion when it is fully built up",
    "length_mm": "mm, distance over which it builds up",
    "grows_um": "um, by how much more it is at the high end of the travel than in the middle",
    "grows": "1, it differs along the travel; 0, it does not",
    "spread": (
        "1, it builds up over ways of all lengths between a fifth of that and five times it, as"
        " asperities of many sizes let go; 0, over one; -1, in proportion to the way until all"
        " lets go at once"
    ),
    "stairs": (
        "1, every row of steps in one direction begins at a turn, whatever was travelled before it;"
        " 0, the axis turned where the targets say"
    ),
}
OPTIONAL = {"grows_um": 0.0, "grows": 0.0, "spread": 0.0, "stairs": 0.0}
SPREAD = (0.2, 0.45, 1.0, 2.25, 5.0)  # of the length: evenly in its logarithm
# Twice the friction over the stiffness: 50 N on a belt of 100 N/mm are 1 mm, on a screw of 50 N/um
# 2 um.
PLAUSIBLE = {
    "size_um": (0.0, 1000.0),
    "grows_um": (-1000.0, 1000.0),
}  # beyond, it is something else (unverified: usual belts)
EXPECTED = {"size_um": 1}
STEP = 0.5  # mm: steps of a row that shows how lost motion builds up
BUILT_UP = 5.0  # lengths after which less than 1 % is to come
CONTINUOUS = {"length_mm": (0.05, 15.0)}
KIND, USE, PER = "machine", "compensate", "axis"
ALONG = True
NEEDS, SEES = ("approach", "distance"), ("tool", "part")
TEXT = (
    "The drive winds up before the slide follows. A staircase of small reversals shows its length;"
    " the compensator takes it up over three of them, over five where it is spread, over one where"
    " all lets go at once (reversal = ramp)."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near = float(np.min(state.distance[axis], initial=np.inf)) if axis in state.distance else 0.0
    lengths = grid(0.1, 10.0, 9)
    # Where every reading lies so far behind its turn that all is built up, what differs along the
    # travel is backlash_position.
    reached = [v for v in lengths if near < BUILT_UP * v]
    partly = [v for v in lengths if near < v]  # until all lets go at once
    since = _stairs(state, axis)
    stairs = bool(np.any((since > 0) & (since < STEP)))
    kinds = [
        (lengths, 0.0, 0.0, 0.0),
        (reached, 1.0, 0.0, 0.0),
        (reached, 0.0, 1.0, 0.0),
        (partly, 0.0, -1.0, 0.0),
        *([(lengths, 0.0, spread, 1.0) for spread in (0.0, 1.0)] if stairs else []),
    ]
    return [
        {"length_mm": v, "grows": grows, "spread": spread, "stairs": row}
        for among, grows, spread, row in kinds
        for v in among
    ]


def _stairs(state: State, axis: str) -> np.ndarray:
    """(N,) mm of each reading at rest behind the first of its row of targets in one direction;
    infinite in motions and where no time is known."""
    since = np.full(len(state), np.inf)
    if len(state.time) != len(state):
        return since
    rests = ~sampled(state)
    file = state.file if len(state.file) == len(state) else np.zeros(len(state))
    for number in np.unique(file[rests]):
        own = np.flatnonzero((file == number) & rests)
        own = own[np.argsort(state.time[own], kind="stable")]
        place, side = state.position[axis][own], np.sign(state.approach[axis][own])
        again = (np.diff(side) != 0) | (np.diff(place) * side[1:] < 0)  # it went back
        for part in np.split(np.arange(len(own)), np.flatnonzero(again) + 1):
            since[own[part]] = np.abs(place[part] - place[part[:1]])
    return since


def sensible(size_um: float, grows_um: float = 0.0, **_: float) -> bool:
    """Whether it winds up against its friction everywhere: less than nothing is another effect."""
    return abs(grows_um) <= size_um


def columns(
    state: State,
    axis: str,
    length_mm: float,
    grows: float = 0.0,
    spread: float = 0.0,
    stairs: float = 0.0,
) -> np.ndarray:
    lengths = np.multiply(SPREAD if spread > 0 else (1.0,), length_mm)
    built_up = _at_once if spread < 0 else _built_up
    if axis in state.path:
        #    lag +1/2 |          .---       A column of ways: endless towards +, then back by d. The
        #             |       .'           endless one gives -1/2 (it stops short), the way back
        #        -1/2 |------'             adds 1 - exp(-d / length), and each further turn takes or
        #                    turn -> d     adds its own likewise (Masing).
        ways = state.path[axis]
        each = np.sign(ways) * built_up(np.abs(ways), lengths)
        wound = each[0] / 2 - each.sum(axis=0)
    else:
        wound = _since_a_turn(state, axis, built_up(state.distance[axis], lengths))
    if stairs:
        since = _stairs(state, axis)
        stair = _since_a_turn(state, axis, built_up(since, lengths))
        wound = np.where(np.isinf(since), wound, stair)
    return along(axis, wound, *([wound * state.share(axis)] if grows else []))


def _since_a_turn(state: State, axis: str, share: np.ndarray) -> np.ndarray:
    """(N,) of the size, by the last turn alone; share (N,): what has built up since then."""
    return -state.approach[axis] / 2 * (2 * share - 1)


def _built_up(way: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Of a way (any shape, mm) the share that has built up, over all lengths (K,) mm alike."""
    return np.mean([-np.expm1(-way / v) for v in lengths], axis=0)


def _at_once(way: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """The same of one play behind one spring (Jenkins' element: Iwan, A distributed-element model
    for hysteresis, J. Applied Mechanics 33, 1966, 893)."""
    return np.minimum(way / lengths[0], 1.0)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um", "grows_um", second_if="grows")


def ramp_mm(size_um: float, length_mm: float, spread: float = 0.0, **_: float) -> float:
    """mm of travel after a turn over which a compensator takes it up: 3 lengths, or 5 where it is
    spread, when 0.9 of it has come; 1 where it lets go at once. Taken up at the turn it would be
    all there before the slide asks for it, and leave twice what it leaves uncorrected."""
    return (3.0 if not spread else 5.0 if spread > 0 else 1.0) * length_mm


def tables(
    axis: str,
    travel: tuple[float, float],
    size_um: float,
    length_mm: float,
    grows_um: float = 0.0,
    **_: float,
) -> list[Table]:
    """Fully built up; ramp_mm says over which way after a turn."""
    # at the low and at the high end of the travel, linear between: two nodes tell it all
    half = np.array([size_um - grows_um, size_um + grows_um]) * UM / 2
    return [(f"E{axis}", axis, np.array(travel), -half, half)]
