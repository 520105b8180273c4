"""One recording to its signals: columns of readings, of the path that was commanded, and of what
has passed since a turn.

A signal is one reading over rows: `reading_um` of targets, `radial_um` of a circle, `X_act_mm` of a
trace, `measured_mm` of one feature. Columns are named by what they are ("X position", "Z since",
"channel T_air_C"); mm, s.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc import effects
from postproc.diagnose import creep, order, rounding
from postproc.diagnose.averages import Columns, averaged, together
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.recordings import Recording

Signal = tuple[str, Columns]  # its name, its columns

# mm: by how much a target is usually overrun before it is approached from the other side
OVERRUN = 3.0
RESTS = 2e-5  # mm from sample to sample
STAMP = 1.1e-3  # s: by how much a time that was written with three decimals may be off
SMOOTH = 0.02  # s
FAR = 1e6  # mm and s: unknown when an axis turned back last
FACES = ("gauge", "probe", "indicator", "dial")  # read from face to face
TOUCHING = (*FACES, "comparator", "micrometer", "coordinate measuring", "scale", "encoder")
# reads by a beam, whatever else its name holds: a laser gauge, a laser with a probe for the air
LIGHT = ("laser", "interferometer")
STANDARDS = ("step gauge", "gauge block", "block gauge")
INSIDE = {"pocket_size": 1.0, "bore_diameter": 1.0, "boss_diameter": -1.0}
MATERIAL = {"pocket_size": 1.0, "bore_diameter": 1.0, "boss_diameter": -1.0}


def signals_of(recording: Recording, machine: Machine) -> Iterator[Signal]:
    """(name, columns) of every signal of a recording."""
    makers = {"targets": _targets, "ballbar": _ballbar, "trace": _trace, "features": _features}
    yield from makers[recording.kind](recording, machine)


def _common(recording: Recording) -> dict[str, np.ndarray]:
    n = len(recording)
    columns: dict[str, np.ndarray] = {
        # not recorded: nothing can be told by it
        "time": recording.columns.get("t_s", np.zeros(n)),
        "run": recording.columns.get("run", np.ones(n)),
        "line": recording.lines if len(recording.lines) == n else np.arange(n),
        # workpieces are, between two cuts; what is compared with a standard is none
        "channel gauged": np.full(n, float(_reads(recording, ("gauge",), but=STANDARDS))),
        "channel lit": np.full(n, float(not _reads(recording, TOUCHING))),
        "channel faces": np.full(n, float(_reads(recording, FACES))),
    }
    for name, values in recording.columns.items():
        if (
            name.startswith(("T_", "force_", "load_", "spindle_rpm", "feed_mm_min"))
            and values.dtype != object
        ):
            columns[f"channel {name}"] = values
    if "line" in recording.columns and recording.columns["line"].dtype != object:
        columns["channel program_line"] = recording.columns["line"]
    turned = (x for x in recording.axes if x not in XYZ)
    return columns | {f"channel {x}_deg": recording.position(x) for x in turned}


def _targets(recording: Recording, machine: Machine) -> Iterator[Signal]:
    columns = _common(recording)
    n = len(recording)
    vector = np.array([recording.sensitive.get(x, 0.0) for x in XYZ])
    angle = recording.quantity == "angle"
    if angle:
        vector = np.array(
            [
                # An angle is read about a direction: named by it, or by the turn about it (A about
                # X, B about Y, C about Z, ISO 841).
                recording.sensitive.get(x, recording.sensitive.get("ABC"[i], 0.0))
                for i, x in enumerate(XYZ)
            ]
        )
    path = np.zeros(n)
    overrun = _overrun(recording)
    for x in recording.axes:
        if x not in XYZ:
            continue
        p = recording.position(x)
        columns[f"{x} position"], columns[f"{x} approach"] = p, recording.approach(x)
        columns[f"{x} distance"] = _since_turn(p, recording.approach(x), overrun)
        if np.ptp(p) > 1e-9:
            columns[f"{x} path"] = _through_targets(p, recording.approach(x), overrun)
        path += vector[XYZ.index(x)] * p
    length = not angle and recording.quantity == "displacement"
    # From the lowest target along the reading on: at which end the laser stood is not recorded, and
    # what lies before the first target is the dead path, an effect of its own.
    columns["beam"] = path - path.min() if length else np.zeros(n)
    laser = "laser" if recording.quantity == "displacement" else "tool"
    yield (
        "reading_urad" if angle else "reading_um",
        columns
        | {
            "y": recording.reading,
            "direction": np.repeat(vector[None], n, axis=0),
            "sees": "angle" if angle else laser,
        },
    )


def _reads(recording: Recording, words: tuple[str, ...], but: tuple[str, ...] = ()) -> bool:
    """Whether its instrument is of this kind; where nobody wrote down what it was, of none."""
    name = recording.instrument.lower().replace("-", " ")
    return any(word in name for word in words) and not any(w in name for w in (*LIGHT, *but))


def _overrun(recording: Recording) -> np.ndarray:
    """(N,) mm by which the target before was overrun where the axis turned: as usual, or less where
    at the recorded feed there was no time for it; NaN where times or feeds do not tell. The rest at
    a target is the shortest time that no way explains."""
    result = np.full(len(recording), np.nan)
    time, feed = recording.columns.get("t_s"), recording.columns.get("feed_mm_min")
    if time is None or feed is None or feed.dtype == object or len(result) < 3:
        return result
    #     wait = rest + (step + 2 overrun) / speed
    #
    #              target k-1       overrun
    #     --------------+----------------.
    #     <---target k------ step -------'
    #
    # Only the sum of rest and overrun shows in one wait. The shortest rest of all is taken for that
    # of each, so that what a wait has beyond it is way.
    step = np.sqrt(sum(np.diff(recording.position(x)) ** 2 for x in recording.axes if x in XYZ))
    wait, speed = np.diff(time), feed[1:] / 60.0
    known = (wait > 0) & (speed > 0)
    if not known.any():
        return result
    rest = max(float(np.min(wait[known] - step[known] / speed[known])), 0.0)
    room = (speed[known] * (wait[known] - rest) - step[known]) / 2
    result[1:][known] = np.clip(room, 0.0, OVERRUN)
    return result


def _since_turn(position: np.ndarray, approach: np.ndarray, overrun: np.ndarray) -> np.ndarray:
    """(N,) mm travelled since the axis turned back, as far as the targets tell: each is overrun
    (N,) a little before a turn."""
    result = np.full(len(position), FAR)
    gone = FAR
    for k in range(1, len(position)):
        step = abs(position[k] - position[k - 1])
        if approach[k] != approach[k - 1]:
            #      turn     k-1                 k          the new side is +
            #        |<------+------------------           came in -, went on beyond k-1,
            #        +------>+------------------>|         and back: gone = beyond + ahead
            # A target that does not lie ahead was passed first, so that only `beyond` was gone
            # since.
            ahead = approach[k] * (position[k] - position[k - 1])
            gone = max(ahead, 0.0) + _beyond(ahead, overrun[k])
        else:
            gone = gone + step
        result[k] = gone
    if np.ptp(position) < 1e-9:
        return np.full(len(position), FAR)
    return result


def _beyond(ahead: float, overrun: float) -> float:
    """mm beyond a target at which an axis turns. ahead mm: how far the next one lies in the new
    direction; a step shorter than a usual overrun is made to read what the turn does; overrun mm:
    what the time of the step says, NaN where it is not known."""
    if ahead <= 1e-9:
        return OVERRUN
    usual = OVERRUN if ahead >= OVERRUN else 0.0
    return usual if np.isnan(overrun) else overrun


def _through_targets(position: np.ndarray, approach: np.ndarray, overrun: np.ndarray) -> np.ndarray:
    """(N, M) mm: the ways that a drive remembers (effects.reversal_memory), along the targets one
    after the other: a target is overrun before the axis turns there, and a target behind the last
    one is passed before it is approached from the same side again."""
    known = np.flatnonzero(approach)
    if not len(known):
        return np.zeros((len(position), 2))
    begin, at = [], []
    side = np.sign(approach[known[0]])
    for k in range(int(known[0]) + 1, len(position)):
        new, step = np.sign(approach[k]), position[k] - position[k - 1]
        if new == -side:
            beyond = side * _beyond(new * step, overrun[k])
            begin.append(k)
            at.append((position[k - 1] if new * step >= 0 else position[k]) + beyond)
            side = new
        elif new == side and side * step < -1e-9:
            begin += [k, k]
            at += [position[k - 1], position[k] - side * OVERRUN]
    ways = effects.reversal_memory(
        position, float(np.sign(approach[known[0]])), np.array(begin, int), np.array(at)
    )
    through_targets: np.ndarray = (ways * (approach != 0)).T
    return through_targets


def _motion(
    columns: Columns,
    letter: str,
    position: np.ndarray,
    time: np.ndarray,
    run: np.ndarray,
    speed: np.ndarray | None = None,
) -> None:
    """Velocity, acceleration, approach and what has passed since a turn, from the commanded path of
    each run; speed (N,) mm/s: the commanded one, where the log has it."""
    n = len(position)
    names = ("velocity", "acceleration", "approach", "distance", "since")
    v, a, s, d, since = (np.zeros(n) for _ in names)
    ways: list[tuple[np.ndarray, np.ndarray]] = []
    edges = np.flatnonzero((np.diff(run) != 0) | (np.diff(time) <= 0)) + 1
    for part in np.split(np.arange(n), edges):
        if len(part) < 3:
            continue
        t, p = _even(time[part]), position[part]
        v[part] = np.gradient(p, t, edge_order=2)
        if speed is not None:  # where a cell is empty, as the places say
            v[part] = np.where(np.isfinite(speed[part]), speed[part], v[part])
        a[part] = _slope(v[part], t)
        # a log rounds the place of an axis that rests
        jitter = RESTS / max(float(np.median(np.diff(t))), 1e-9)
        still = np.abs(v[part]) < max(1e-4 * float(np.abs(v[part]).max()), jitter)
        v[part] = np.where(still, 0.0, v[part])
        sign = np.sign(v[part])
        held = np.maximum.accumulate(np.where(sign != 0, np.arange(len(part)), -1))
        # An axis at rest bears on the side of its last motion; 0 before the first one.
        s[part] = np.where(held >= 0, sign[np.maximum(held, 0)], 0)
        turn = np.concatenate([[False], (s[part][1:] != s[part][:-1]) & (s[part][:-1] != 0)])
        last = np.maximum.accumulate(np.where(turn, np.arange(len(part)), -1))
        gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(p)))])
        # mm and s since the last turn; before the first one of a run nobody knows: FAR, as if long
        # ago
        d[part] = np.where(last >= 0, gone - gone[np.maximum(last, 0)], FAR)
        since[part] = np.where(last >= 0, t - t[np.maximum(last, 0)], FAR)
        moved = np.flatnonzero(s[part])
        if len(moved):
            turns = np.flatnonzero(turn)
            memory = effects.reversal_memory(p, float(s[part][moved[0]]), turns, p[turns])
            ways.append((part, memory * (s[part] != 0)))
    for name, value in zip(names, (v, a, s, d, since), strict=True):
        columns[f"{letter} {name}"] = value
    columns[f"{letter} path"] = path = np.zeros((n, max((len(m) for _, m in ways), default=2)))
    for part, memory in ways:
        path[part, : len(memory)] = memory.T
    columns[f"{letter} position"] = position


def _even(t: np.ndarray) -> np.ndarray:
    """(N,) s: what a clock without rounding would have said of samples that were taken at even
    steps."""
    n = np.arange(len(t))
    step = (t[-1] - t[0]) / max(len(t) - 1, 1)
    straight = t.mean() + (n - n.mean()) * step
    return straight if np.abs(t - straight).max() < min(STAMP, 0.4 * step) else t


def _slope(v: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(N,) slope of a line through the neighbours within SMOOTH: second differences of rounded
    places are mostly noise."""
    slope: np.ndarray
    steps = np.diff(t)
    half = int(SMOOTH / max(float(np.median(steps)), 1e-9))
    if half < 2 or np.ptp(steps) > 1e-3 * steps.max() or len(v) < 2 * half + 1:
        slope = np.gradient(v, t, edge_order=2)
        return slope
    k = np.arange(-half, half + 1)
    # Least squares over 2 half + 1 samples: sum(k v) / sum(k^2) / step (Savitzky-Golay of first
    # order). Ends go on turned about the end point, as a line does; mirrored, they would be level
    # there.
    head, tail = 2 * v[0] - v[half:0:-1], 2 * v[-1] - v[-2 : -half - 2 : -1]
    slope = np.convolve(np.concatenate([head, v, tail]), k[::-1] / (k @ k), "valid") / steps[0]
    return slope


def _ballbar(recording: Recording, machine: Machine) -> Iterator[Signal]:
    columns = _common(recording)
    run = _unbroken(columns["run"], recording.columns["sense"])
    centre = recording.head["centre"]
    n = len(recording)
    unit = np.zeros((n, 3))
    for x in recording.axes:
        p = recording.position(x)
        _motion(columns, x, p, columns["time"], run)
        if x in centre:
            unit[:, XYZ.index(x)] = p - centre[x]
    #     centre o-----------+ commanded ---> unit
    # The bar reads + where the tool is too far out: reading = deviation . unit.
    unit /= np.maximum(np.linalg.norm(unit, axis=1), 1e-9)[:, None]
    moving = [x for x in recording.axes if x in centre]
    sure = ~_changing(columns, moving, run)
    for x in moving:  # before it moved the side that it came from is unknown
        sure &= columns[f"{x} approach"] != 0
    columns |= {"y": recording.reading, "direction": unit, "dense": np.ones(n)}
    columns = {name: value[sure] for name, value in columns.items()}
    yield "radial_um", averaged(columns | {"sees": "tool", "cut": run[sure]})


def _unbroken(run: np.ndarray, sense: np.ndarray) -> np.ndarray:
    """Runs, cut where the sense changes."""
    change = np.concatenate([[0], np.cumsum((np.diff(run) != 0) | (np.diff(sense) != 0))])
    return change.astype(float)


def _trace(recording: Recording, machine: Machine) -> Iterator[Signal]:
    columns = _common(recording)
    scale = recording.head.get("sees", "scale") == "scale"
    letters = [x for x in recording.axes if x in XYZ]
    for x in letters:
        speed = recording.columns.get(f"{x}_cmd_velocity_mm_s")
        _motion(columns, x, recording.position(x), columns["time"], columns["run"], speed)
    # How lost motion stood at the start is a nuisance parameter (nuisances.py).
    moving = [x for x in letters if np.ptp(recording.position(x)) > 0]
    known = np.flatnonzero(~_changing(columns, moving, columns["run"]))
    for name in list(columns):  # one by one: of a long trace all of them twice is a lot
        columns[name] = columns[name][known]
    for x in letters:
        commanded, actual = recording.position(x)[known], recording.columns[f"{x}_act_mm"][known]
        coarse = rounding.noise(recording.position(x), recording.columns[f"{x}_act_mm"])[known]
        one = columns | {"rounding": coarse, "y": actual - commanded} | _slips(x, columns, actual)
        same = rounding.alike(commanded, coarse)
        rows = averaged(together(one, same) if same.any() else one)
        rows["direction"] = np.zeros((len(rows["y"]), 3))
        rows["direction"][:, XYZ.index(x)] = 1.0
        rows |= {"dense": np.ones(len(rows["y"])), "sees": "scale" if scale else "tool"}
        yield f"{x}_act_mm", rows


def _slips(letter: str, columns: Columns, actual: np.ndarray) -> Columns:
    """Columns of the slips of an axis whose actual place is `actual` (N,) mm; empty where it does
    not stick."""
    place = columns[f"{letter} position"]
    lag = (place - actual) * columns[f"{letter} approach"]
    found = creep.of(place, lag, columns[f"{letter} velocity"], columns["run"])
    return {} if found is None else {f"{letter} slipped": found.since, "slips": {letter: found}}


def _changing(columns: Columns, letters: list[str], run: np.ndarray) -> np.ndarray:
    """(N,) bool: samples in which an axis starts, stops or turns; at the first one of a run it
    stands where the run before left it."""
    result = np.zeros(len(run), bool)
    first = np.concatenate([[True], np.diff(run) != 0])
    for x in letters:
        side, moves = columns[f"{x} approach"], columns[f"{x} velocity"] != 0
        turn = np.flatnonzero(((np.diff(side) != 0) | (np.diff(moves) != 0)) & (np.diff(run) == 0))
        result[turn] = True
        result[turn + 1] = True
        result |= first & moves
    return result


# Whole: a column to each driver of a feature; a branch is a kind of feature.
def _features(recording: Recording, machine: Machine) -> Iterator[Signal]:
    columns = _common(recording)
    kind, axis = recording.columns["kind"], recording.columns["axis"]
    nominal = recording.columns["nominal_mm"]
    use = np.array(
        [
            k in (*MATERIAL, "centre_distance", "step") and str(a)[:1] in XYZ
            for k, a in zip(kind, axis, strict=True)
        ]
    )
    if not use.any():
        return
    n = len(recording)
    direction = np.zeros((n, 3))
    turned = np.zeros(n, bool)  # a diameter of a lathe: twice what the tool is off at its radius
    for k in range(n):
        letters = [x for x in str(axis[k]) if x in XYZ]
        turned[k] = kind[k] in MATERIAL and len(letters) == 1 and letters[0] in machine.diameter
        for x in letters:
            direction[k, XYZ.index(x)] = 2.0 if turned[k] else 1.0 / len(letters)
    for x in (x for x in machine.letters if x in XYZ):
        low, high = machine.axes[x].travel
        size = nominal * (direction[:, XYZ.index(x)] != 0)
        #      other           middle of the travel         position
        #        |<------------------ size ------------------>|   two walls
        # Where the part stood is seldom recorded; what the map says of it is the difference of its
        # errors at the two walls. A diameter on a lathe has one wall, at its radius.
        middle = (low + high) / 2 if np.isfinite(low + high) else 0.0
        columns[f"{x} position"] = np.where(turned & (size > 0), size / 2, middle + size / 2)
        columns[f"{x} other"] = np.where(turned, np.nan, middle - size / 2)
        # A wall is reached from the inside of a pocket or a bore, from the outside of a boss.
        columns[f"{x} approach"] = np.where(size > 0, [INSIDE.get(str(k), 0.0) for k in kind], 0.0)
    columns["channel part"] = order.parts(recording.columns.get("part", np.ones(n)))
    columns["channel material"] = np.where(turned, 0.0, [MATERIAL.get(str(k), 0.0) for k in kind])
    columns["channel wall"] = np.where(turned, 1.0, [-MATERIAL.get(str(k), 0.0) for k in kind])
    holes = np.array([float(k == "bore_diameter") for k in kind])
    columns["channel bore"], columns["channel hole"] = holes * turned, holes * ~turned
    columns["run"] = columns["channel part"]
    columns["y"], columns["direction"] = recording.columns["measured_mm"] - nominal, direction
    names = np.array([f"{f} {k}" for f, k in zip(recording.columns["feature"], kind, strict=True)])
    for name in sorted(set(names[use])):
        which = use & (names == name)
        yield f"measured_mm {name}", {c: v[which] for c, v in columns.items()} | {"sees": "part"}
