"""The physics beyond the geometric tables. One file an effect, found by its name.

Every module holds

- PARAMETERS: name with unit (size_um) to "unit, meaning"; those that enter linearly and those of a
  shape. A number that stands for something: "0, 1, 2: X, Y, Z, the direction" or "1, this is so; 0,
  it is not" (diagnose/words.py);
- KIND, whose error it is: "machine", "instrument" or "data" (the log);
- USE, what may be done about it: "compensate" (a written machine corrects it: programs where it has
  tables(), grids() or by_angle(), else offsets or a warm-up), "simulate" (of a machine, and no
  program can correct it), "recording" (not of a machine: the recording is to be corrected);
- PER: "axis" (one of each moving axis), "pair" (of two axes) or "all" (axis is null); LINE: True
  where it is of no axis on a line along which several move;
- NEEDS: what must be known of a row: fields of State, "force", channels (T_air_C) that changed;
  SEES: which signals it can show in: "tool" (an instrument at the tool), "angle", "scale" (the
  axis' own scale or encoder), "part" (features of a part);
- TEXT: what it is and what to do about it;
- shapes(state, axis) -> list of dicts: the parameters that do not enter linearly, as a grid; [{}]
  where there are none;
- columns(state, axis, **shape) -> (K, 3, N) mm of deviation at the tool (actual - commanded) for
  unit coefficients of 1 um (rad where state.turned); of instruments (K, N) mm of the reading;
- parameters(coefficients, shape) -> named parameters of a fit, and coefficients(**parameters) ->
  (K,), shape: its inverse; _named.by_name makes both where coefficients are parameters themselves.

And it may hold

- OPTIONAL: value of those of PARAMETERS that may be left out; EXPECTED: a parameter's usual sign;
  PLAUSIBLE: its range, beyond which it is something else;
- special(**shape) -> (name, shape) of its special case, tried in its place; sensible(**parameters):
  False where such parameters are another effect's;
- HIGHEST_DEGREE: what a degree of its polynomials may be at most;
- RESTING: True where its axis is the direction of the error, which need not move itself; LISTED:
  True of a fault of the data, listed where rows show it: simulated, never fitted;
- ALONG: True where it is along its axis and told by each signal alone;
- WALLS: True where what goes with time changes what lies between two walls;
- fuller(shape, state, axis) -> shapes with more that may come with it, each worth its price;
- further_cost(axis, shape) -> twice the logarithm of how much seldomer it is than its kin;
- CONTINUOUS: range of parameters of a shape that have values between those of the grid; at 0 or
  below they mean something else and are not moved;

An effect that moves the tool the same way whenever the slides stand in the same place, come from
the same side, also holds tables(axis, travel, **parameters) -> list of (component, axis, nodes,
forward, reverse), mm: what a compensator applies; where a second axis matters too grids(axis,
travel of every axis, **parameters) -> list of (component, axis, other, nodes, others, values (K,
L)); where it lives on the rotations of the machine's file by_angle(axis, nodes, forward, reverse,
**parameters), as tables(), where on its arms arm_tables(axis, travel, measured, **parameters), rad
for EA EB EC. ramp_mm(**parameters): the travel after a turn over which its reversal is taken up.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Callable
from dataclasses import field
from functools import cache
from types import ModuleType

import numpy as np

from postproc.records import record

UM = 1e-3  # mm
XYZ = "XYZ"
FASTEST, ENDLESS = 1000.0, 1e6  # mm/s; mm: a way after which nothing from before is remembered
DEEPEST, AT_ONCE = 16, 1 << 15  # ways that a drive remembers; samples worked out at once
SETTLES = (2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # ms: position gains of 500 to 16 per s
# component, axis, nodes mm, mm (rad of EA EB EC) towards plus and minus
Table = tuple[str, str, np.ndarray, np.ndarray, np.ndarray]
# component, axis, other, nodes and others mm, values (K, L) mm
Grid = tuple[str, str, str, np.ndarray, np.ndarray, np.ndarray]
CHOICE = re.compile(r"number|\d or \d|\d, .*(; |: )")  # "0, 1, 2: X, Y, Z"; "1, so; 0, not"


@record
class State:
    """N rows of a recording or a simulation, and what led there. What is not known is empty.

    position mm, approach -1..+1, velocity mm/s, acceleration mm/s2, distance mm and since s (since
    that axis turned back last): axis to (N,). travel: axis to (low, high) mm. time (N,) s. run
    (N,): which passage. channels: name to (N,), as recorded: T_screw_X_C, force_X_N, load_X_N,
    spindle_rpm. angles: axis to (3, N) rad, the measured rotations of that axis; arms: axis to
    (3, N) mm, on which they act; on_arm: axes whose own position is on their arm; turned (N,) bool:
    rows that read an angle. beam (N,) mm: the length that is read, beyond its zero. passage (N,):
    number of the unbroken sampled motion that a row belongs to, -1 at rest; file (N,): number of
    the recording. width (N,) s: over which samples were averaged to a row. inside: axis, or "time",
    to (W, N) mm or s: where, or when, the samples of a row were taken, NaN beyond their number.
    lines: axis to the other axes across which readings along it were taken on lines that lie apart.
    path: axis to (M, N) mm, the ways between turns that its drive still remembers, see
    reversal_memory(). slipped: axis to (N,) mm, the way that a creeping slide was driven on since
    it slipped last, as it stopped while it rests; NaN where no slips were seen.
    """

    position: dict[str, np.ndarray]
    approach: dict[str, np.ndarray]
    travel: dict[str, tuple[float, float]]
    velocity: dict[str, np.ndarray] = field(default_factory=dict)
    acceleration: dict[str, np.ndarray] = field(default_factory=dict)
    distance: dict[str, np.ndarray] = field(default_factory=dict)
    since: dict[str, np.ndarray] = field(default_factory=dict)
    time: np.ndarray = field(default_factory=lambda: np.zeros(0))
    run: np.ndarray = field(default_factory=lambda: np.zeros(0))
    channels: dict[str, np.ndarray] = field(default_factory=dict)
    angles: dict[str, np.ndarray] = field(default_factory=dict)
    beam: np.ndarray = field(default_factory=lambda: np.zeros(0))
    passage: np.ndarray = field(default_factory=lambda: np.zeros(0))
    file: np.ndarray = field(default_factory=lambda: np.zeros(0))
    width: np.ndarray = field(default_factory=lambda: np.zeros(0))
    lines: dict[str, str] = field(default_factory=dict)
    inside: dict[str, np.ndarray] = field(default_factory=dict)
    path: dict[str, np.ndarray] = field(default_factory=dict)
    slipped: dict[str, np.ndarray] = field(default_factory=dict)
    arms: dict[str, np.ndarray] = field(default_factory=dict)
    on_arm: str = ""
    turned: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))

    def __len__(self) -> int:
        return len(next(iter(self.position.values())))

    def share(self, axis: str) -> np.ndarray:
        """(N,) place along the travel, -1 to +1."""
        low, high = self.travel[axis]
        return 2 * (self.position[axis] - low) / (high - low) - 1

    def channel(self, *names: str) -> np.ndarray | None:
        """The first of these channels that was recorded."""
        return next((self.channels[n] for n in names if n in self.channels), None)


def along(axis: str, *values: np.ndarray) -> np.ndarray:
    """(K, 3, N) mm of values (N,) um along one axis."""
    result = np.zeros((len(values), 3, len(values[0])))
    result[:, XYZ.index(axis)] = np.stack(values) * UM
    return result


def first_timed(state: State) -> int:
    """The first row of the recordings whose times were recorded; in the others all are zero."""
    # of one that was not timed the first row would stand for the beginning of all
    timed = state.time != 0
    if len(state.file) == len(timed):
        timed = np.isin(state.file, state.file[timed])
    return int(np.argmin(np.where(timed, state.time, np.inf)))


def temperature_rise(state: State, axis: str, tau_s: float, by_travel: float = 0.0) -> np.ndarray:
    """(N,) K of a screw above its first temperature; for tau_s > 0 the share of a heat that comes
    with time, 0 to 1, or of what the axis' own travel makes and the room takes away again."""
    measured = state.channel(f"T_screw_{axis}_C", f"T_scale_{axis}_C")
    if tau_s == 0 and measured is not None:
        return measured - measured[first_timed(state)]
    if tau_s == 0 and not by_travel:
        return np.zeros(len(state))  # by its temperature, and nobody recorded it
    if not by_travel:
        return 1.0 - np.exp(
            -np.maximum(state.time - state.time[first_timed(state)], 0.0) / max(tau_s, 1.0)
        )
    heat = low_pass(state, travel_speed(state, axis), max(tau_s, 1.0))
    # of the largest, so that the size is what the screw grew at its hottest
    return heat / max(float(heat.max(initial=0.0)), 1e-12)


def travel_speed(state: State, axis: str) -> np.ndarray:
    """(N,) mm/s at which the axis came to each row, as far as the rows tell: what heats a screw."""
    order = np.argsort(state.time, kind="stable")
    t, p = state.time[order], state.position[axis][order]
    rate = np.zeros(len(t))
    # a rapid between two targets: no faster than FASTEST, however coarse the times are
    rate[1:] = np.abs(np.diff(p)) / np.maximum(np.diff(t), 1e-3)
    result = np.empty(len(t))
    result[order] = np.minimum(rate, FASTEST)
    return result


def low_pass(state: State, driver: np.ndarray, tau_s: float) -> np.ndarray:
    """(N,) a driver (N,) as it comes through a body that takes tau_s, s, to follow; it was at rest
    before the first row."""
    order = np.argsort(state.time, kind="stable")
    kept = np.exp(-np.diff(state.time[order]) / tau_s)
    back = np.empty(len(order))
    back[order] = recurrence(kept, (1.0 - kept) * driver[order][1:])
    return back


def followed(state: State, driver: np.ndarray, tau_s: float) -> np.ndarray:
    """(N,) a driver (N,) of sampled motions as a first-order element of the time constant tau_s, s,
    follows it, in steady state at the first row of each passage; the driver goes in lines from row
    to row (first-order hold: Franklin, Powell, Workman, Digital Control of Dynamic Systems, section
    6.3)."""
    result = driver.astype(float)
    for passage in np.unique(state.passage[state.passage >= 0]):
        own = np.flatnonzero(state.passage == passage)
        own = own[np.argsort(state.time[own], kind="stable")]
        step, u = np.diff(state.time[own]), result[own]
        keep = np.exp(-step / tau_s)
        # what a line from u[k] to u[k + 1] adds over one step
        weight = np.divide(tau_s * (1 - keep), step, out=np.ones(len(step)), where=step > 0)
        added = (weight - keep) * u[:-1] + (1 - weight) * u[1:]
        result[own] = u[0] + recurrence(keep, added - (1 - keep) * u[0])
    return result


def settling(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same shape with time constants of a loop, ms, that sampled motions can show."""
    shows = len(state.passage) == len(state) and np.any(state.passage >= 0)
    return [shape | {"settle_ms": t} for t in SETTLES] if shows else []


def recurrence(kept: np.ndarray, added: np.ndarray) -> np.ndarray:
    """(N + 1,) x, from 0 on: x of each step is `kept` (N,) of the x before and `added` (N,). By
    doubling (Hillis and Steele, Communications of the ACM 29, 1986, 1170): after each pass the
    steps are twice as long."""
    kept, x, far = kept.copy(), added.copy(), 1
    # x[k] = kept[k] x[k-1] + added[k]: two steps in a row are again such a step, with the product
    # of both `kept`. After log2 N passes every x counts from the beginning.
    while far < len(x):
        x[far:] += kept[far:] * x[:-far]
        kept[far:] = kept[far:] * kept[:-far]
        far *= 2
    return np.concatenate([[0.0], x])


def reversal_memory(
    place: np.ndarray, first: float, begin: np.ndarray, at: np.ndarray
) -> np.ndarray:
    """(M, N) mm: the ways between turns that a drive still remembers at each row, with the sign of
    their direction, the oldest (ENDLESS) first, the one since the last turn last, 0 behind it.
    place (N,) mm in order of time; first, -1 or +1: the direction of the first row, in which it
    came from far; begin (T,): the first row behind each turn; at (T,) mm: where it turned.

    A way that is as long as the one before ends what was remembered of both (Madelung 1905;
    Mayergoyz, Mathematical Models of Hysteresis, 1991: the wiping-out property, which every sum of
    plays has).
    """
    result = np.zeros((2, len(place)))
    turns: list[float] = []  # places, each way shorter than the one before

    def note(a: int, b: int) -> None:
        nonlocal result
        # rows of a column:  first * ENDLESS | turns[1] - turns[0] | ... | place - turns[-1] | 0
        depth = len(turns) + 1
        if depth > len(result):
            result = np.concatenate([result, np.zeros((depth - len(result), len(place)))])
        result[0, a:b] = first * ENDLESS
        for m in range(1, depth - 1):
            result[m, a:b] = turns[m] - turns[m - 1]
        if turns:
            result[depth - 1, a:b] = place[a:b] - turns[-1]

    side = first
    for k in range(len(begin) + 1):
        a, b = (int(begin[k - 1]) if k else 0), (int(begin[k]) if k < len(begin) else len(place))
        #    ^      2               It turned at 1, 2, 3 and goes up again (side +1). Where it
        #    |     / \   /          passes 2 the way to 3 and back is as good as never travelled:
        #    |    /   \ /           the last two turns are forgotten, and it goes on as on the way
        #    |   1     3            that led to 2.
        while a < b and len(turns) > 1:
            passed = np.flatnonzero(side * (place[a:b] - turns[-2]) >= 0)
            if not len(passed):
                break
            note(a, a + int(passed[0]))
            a += int(passed[0])
            del turns[-2:]
        if a < b:
            note(a, b)
        if k == len(begin):
            break
        end = float(at[k])
        while len(turns) > 1 and side * (end - turns[-2]) >= 0:
            del turns[-2:]
        turns.append(end)
        side = -side
        if len(turns) >= DEEPEST:  # two ways that are nearly alike undo each other
            way = np.abs(np.diff(turns))
            alike = int(np.argmin((way[:-2] - way[1:-1]) / np.maximum(way[:-2], 1e-12)))
            del turns[alike + 1 : alike + 3]
    return result


def loads(state: State, axis: str) -> list[np.ndarray]:
    """(N,) N, what was recorded of the force and of the load along an axis, as far as it
    changed."""
    found = (state.channels.get(f"{name}_{axis}_N") for name in ("force", "load"))
    return [v for v in found if v is not None and np.ptp(v) > 0]


def lost_motion_share(state: State, axis: str, play_mm: float) -> np.ndarray:
    """(N,) share of a lost motion that an axis lags by: from -1, on the old side, to 1, over so
    much way after a turn."""
    near = state.distance.get(axis)
    if play_mm <= 0 or near is None:
        return np.ones(len(state))
    # at the turn still on the old side (-1), halfway in the middle, behind the play on the new one
    return np.clip(2 * near / play_mm - 1, -1.0, 1.0)


def sampled(state: State) -> np.ndarray:
    """(N,) bool: rows of motions that were sampled; all where that is unknown."""
    return state.passage >= 0 if len(state.passage) == len(state) else np.ones(len(state), bool)


def waves_of(state: State, name: str, per_unit: float) -> list[np.ndarray]:
    """(N,) cosine and sine, so many a mm of the place of an axis or a second of the "time", as rows
    that are means of samples show them: the samples of an instrument are moments, so waves shorter
    than their distance are in a mean too."""
    own = state.time if name == "time" else state.position[name]
    # A row that averages samples shows a wave by its mean over them, smaller than the wave itself;
    # (W, N) places, one row of places where nothing was averaged.
    angle = 2 * np.pi * per_unit * state.inside.get(name, own[None])
    parts = np.array_split(angle, 1 + angle.size // AT_ONCE, axis=1)
    waves = [[np.nanmean(wave(part), axis=0) for part in parts] for wave in (np.cos, np.sin)]
    return [np.concatenate(one) for one in waves]


def amplitude_and_phase(coefficients: np.ndarray) -> dict[str, float]:
    """Amplitude and phase of a cosine and a sine."""
    cosine, sine = coefficients
    return {
        "amplitude_um": float(np.hypot(cosine, sine)),
        "phase_deg": float(np.degrees(np.arctan2(sine, cosine))),
    }


def harmonic_coefficients(amplitude_um: float, phase_deg: float) -> np.ndarray:
    """(2,) cosine and sine."""
    return amplitude_um * np.array([np.cos(np.radians(phase_deg)), np.sin(np.radians(phase_deg))])


def legendre(u: np.ndarray, degree: int) -> np.ndarray:
    """(N,) Legendre polynomial; u within -1 to +1."""
    return np.polynomial.legendre.Legendre.basis(degree)(u)


def grid(low: float, high: float, number: int) -> list[float]:
    """Values at equal ratios."""
    return [float(v) for v in np.geomspace(low, high, number)]


def one_way(
    axis: str,
    component: str,
    travel: tuple[float, float],
    number: int,
    of: Callable[[np.ndarray], np.ndarray],
) -> Table:
    """A table (component, axis, nodes, forward, reverse) in mm of a function of the position, in
    um."""
    nodes = np.linspace(*travel, number)
    value = of(nodes) * UM
    return component, axis, nodes, value, value


@cache
def names() -> tuple[str, ...]:
    """The effects that there are."""
    return tuple(sorted(m.name for m in pkgutil.iter_modules(__path__) if m.name[0] != "_"))


def load(name: str) -> ModuleType:
    """The effect's module. Raises KeyError for a name that there is not."""
    if name not in names():
        raise KeyError(name)
    return importlib.import_module(f"{__name__}.{name}")


def sizes(module: ModuleType) -> list[str]:
    """The parameters that have a size, and so may have an uncertainty: not those that say which
    one, or whether."""
    return [name for name, meaning in module.PARAMETERS.items() if not CHOICE.match(meaning)]


def of_axes(module: ModuleType, name: str) -> tuple[float, ...]:
    """What a parameter that is the number of an axis may be; () of any other."""
    meaning = module.PARAMETERS[name]
    if not meaning.startswith("0, 1, 2: "):
        return ()
    return (0.0, 1.0, 2.0, -1.0) if "; -1, " in meaning else (0.0, 1.0, 2.0)


def too_high(module: ModuleType, name: str, value: float) -> str:
    """What is wrong with the degree of polynomials of which there are not so many; "" if not."""
    most = getattr(module, "HIGHEST_DEGREE", {}).get(name, ENDLESS)
    return f"{name} = {value:g} is above {most}, the highest" if abs(value) > most else ""


def deviation(module: ModuleType, state: State, axis: str, **parameters: float) -> np.ndarray:
    """(3, N) mm: what an effect adds at the tool, (N,) mm of an instrument's reading."""
    value, shape = module.coefficients(**parameters)
    return np.tensordot(value, module.columns(state, axis, **shape), axes=1)
