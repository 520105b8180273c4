"""Recordings to rows: what was measured, what the machine's file predicts, and the state that every effect may look at.

All rows of all recordings of an experiment stand in one table, in the order of files. A reading is the part of the tool's
deviation along a direction, or of an axis' own scale; a feature of a part is the difference of two places.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from postproc.effects import State
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

XYZ = "XYZ"
OVERRUN = 3.0  # mm: by how much a target is usually overrun before it is approached from the other side
MOST_ROWS = 5000  # per signal: traces are averaged down to it
RESTS = 2e-5  # mm from sample to sample
FAR = 1e6  # mm and s: nobody knows when an axis turned back last
INSIDE = {"pocket_size": 1.0, "bore_diameter": 1.0, "boss_diameter": -1.0}
MATERIAL = {"pocket_size": 1.0, "bore_diameter": 1.0, "boss_diameter": -1.0}


@dataclass(frozen=True)
class Rows:
    """N rows. y, known (N,) mm: measured, predicted by the machine's file; direction (N, 3): how the tool's deviation
    enters; sees: per row what kind of signal it is ("laser", "angle", "tool", "scale", "part"); file, run, signal, line (N,);
    state: of the rows; far: of the second place of a feature, None where there is none. signals: names."""

    y: np.ndarray
    known: np.ndarray
    direction: np.ndarray
    sees: np.ndarray
    file: np.ndarray
    run: np.ndarray
    signal: np.ndarray
    line: np.ndarray
    state: State
    signals: tuple[str, ...]
    files: tuple[str, ...]
    kinds: tuple[str, ...]
    other: dict[str, np.ndarray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.y)

    @property
    def residual(self) -> np.ndarray:
        """(N,) mm: measured minus predicted."""
        return self.y - self.known

    def pick(self, which: np.ndarray) -> Rows:
        """Some of the rows."""
        arrays = ("y", "known", "direction", "sees", "file", "run", "signal", "line")
        return replace(
            self, state=pick_state(self.state, which), other={x: v[which] for x, v in self.other.items()},
            **{name: getattr(self, name)[which] for name in arrays},
        )  # fmt: skip


def pick_state(state: State, which: np.ndarray) -> State:
    """Some of the rows."""

    def of_each(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {k: v[..., which] for k, v in values.items()}

    return State(
        of_each(state.position), of_each(state.approach), state.travel, of_each(state.velocity), of_each(state.acceleration),
        of_each(state.distance), of_each(state.since), state.time[which], state.run[which], of_each(state.channels),
        of_each(state.angles), state.beam[which], state.passage[which], state.file[which], state.width[which],
    )  # fmt: skip


def of(recordings: list[Recording], machine: Machine) -> Rows:
    """All rows of an experiment. Raises RecordingError for an axis that the machine has not, or a kind without rows."""
    parts = []
    signals: list[str] = []
    for number, recording in enumerate(recordings):
        for letter in recording.axes:
            if letter not in machine.letters:
                raise RecordingError(
                    f"{recording.file} records {letter}, which is no axis of {machine.name}",
                    f"its axes are {' '.join(machine.letters)}",
                )
        for name, columns in _signals(recording, machine):
            columns["file"] = np.full(len(columns["y"]), number)
            columns["signal"] = np.full(len(columns["y"]), len(signals))
            signals.append(name)
            parts.append(columns)
    if not parts:
        raise RecordingError(
            "there is nothing to compare in these recordings", "targets, ballbar, trace or features are wanted"
        )
    return _joined(parts, machine, signals, recordings)


def _joined(parts: list[dict], machine: Machine, signals: list[str], recordings: list[Recording]) -> Rows:
    letters = [x for x in machine.letters if x in XYZ]
    n = sum(len(p["y"]) for p in parts)

    def column(name: str, default: float = 0.0) -> np.ndarray:
        return np.concatenate([np.broadcast_to(p.get(name, default), len(p["y"])).astype(float) for p in parts])

    position = {x: column(f"{x} position") for x in letters}
    approach = {x: column(f"{x} approach") for x in letters}
    channels = sorted({name.removeprefix("channel ") for p in parts for name in p if name.startswith("channel ")})
    state = State(
        position=position, approach=approach, travel=_travels(machine, letters),
        velocity={x: column(f"{x} velocity") for x in letters}, acceleration={x: column(f"{x} acceleration") for x in letters},
        distance={x: column(f"{x} distance", FAR) for x in letters}, since={x: column(f"{x} since", FAR) for x in letters},
        time=column("time"), run=column("run"), channels={c: _filled(column(f"channel {c}", np.nan)) for c in channels},
        angles={}, beam=column("beam"), passage=_passages(parts), file=column("file"), width=column("width"),
    )  # fmt: skip
    angles = {x: _angles(machine, x, state) for x in letters}
    state = replace(state, angles={x: a for x, a in angles.items() if a is not None and a.any()})
    direction = np.concatenate([p["direction"] for p in parts])
    sees = np.concatenate([np.full(len(p["y"]), p["sees"]) for p in parts])
    rows = Rows(
        column("y"), np.zeros(n), direction, sees, column("file").astype(int), column("run").astype(int),
        column("signal").astype(int), column("line").astype(int), state, tuple(signals),
        tuple(r.file for r in recordings), tuple(r.kind for r in recordings),
        {x: column(f"{x} other", np.nan) for x in letters} if any(p["sees"] == "part" for p in parts) else {},
    )  # fmt: skip
    return replace(rows, known=predicted(rows, machine))


def _passages(parts: list[dict]) -> np.ndarray:
    """(N,) number of each unbroken sampled motion, alike in all signals of a file; -1 at rest."""
    result: list[int] = []
    seen: dict[tuple[int, int], int] = {}
    for p in parts:
        for file, run, dense in zip(
            p["file"],
            np.broadcast_to(p["run"], len(p["y"])),
            np.broadcast_to(p.get("dense", 0.0), len(p["y"])),
            strict=True,
        ):
            result.append(seen.setdefault((int(file), int(run)), len(seen)) if dense else -1)
    return np.array(result, float)


def _travels(machine: Machine, letters: list[str]) -> dict[str, tuple[float, float]]:
    """The range over which shapes are drawn: the travel, as for the compensator and the simulator."""
    return {x: machine.axes[x].travel for x in letters}


def _filled(values: np.ndarray) -> np.ndarray:
    """A channel with its mean where it was not recorded: there it tells nothing."""
    known = np.isfinite(values)
    return np.where(known, values, values[known].mean() if known.any() else 0.0)


def _angles(machine: Machine, letter: str, state: State) -> np.ndarray | None:
    table = machine.tables.get(letter)
    if table is None or not any(row >= 3 for row in table.rows):
        return None
    parts = table.evaluate(state.position[letter], state.approach[letter])
    return np.stack([np.zeros(len(state)) if v is None else v for v in parts[3:]])


def predicted(rows: Rows, machine: Machine) -> np.ndarray:
    """(N,) mm: what the machine's file says these readings are, apart from their zeros."""
    from postproc.diagnose import library  # it builds on this module

    result = np.zeros(len(rows))
    tool = np.isin(rows.sees, ("laser", "tool")) | _turned(rows)
    bare = replace(machine, effects=tuple(e for e in machine.effects if e.module is None))
    if tool.any():
        part = pick_state(rows.state, tool)
        result[tool] = (deviation_at(bare, part) * rows.direction[tool].T).sum(axis=0)
    part = (rows.sees == "part") & ~_turned(rows)
    if part.any():
        near, far = pick_state(rows.state, part), second_place(rows, part)
        between = deviation_at(bare, near) - deviation_at(bare, far)
        result[part] = (between * rows.direction[part].T).sum(axis=0)
    for term in machine.effects:  # with their history: what a place alone decides is only what a program can correct
        if term.module is not None and library.needed(rows, term.module, term.axis):
            value, shape = term.module.coefficients(**term.parameters)
            result += library.read(rows, term.module, term.axis, shape) @ value
    for axis, angle in rows.state.angles.items():
        turned = (rows.sees == "angle") & _moving(rows, axis)
        result[turned] += (angle[:, turned] * rows.direction[turned].T).sum(axis=0)
    return result


def second_place(rows: Rows, which: np.ndarray) -> State:
    """The state at the other wall of features: its own place, reached from the other side."""
    there = pick_state(rows.state, which)
    position = {x: np.nan_to_num(rows.other[x][which]) for x in there.position}
    return replace(there, position=position, approach={x: -a for x, a in there.approach.items()})


def _turned(rows: Rows) -> np.ndarray:
    """(N,) bool: diameters of a lathe, whose place on the slide is known."""
    if not rows.other:
        return np.zeros(len(rows), bool)
    return (rows.sees == "part") & np.any([np.isnan(v) for v in rows.other.values()], axis=0)


def _moving(rows: Rows, axis: str) -> np.ndarray:
    """(N,) whether the axis moves in the row's signal."""
    moves = np.zeros(len(rows), bool)
    for signal in np.unique(rows.signal):
        which = rows.signal == signal
        moves[which] = np.ptp(rows.state.position[axis][which]) > 1e-6
    return moves


def deviation_at(machine: Machine, state: State) -> np.ndarray:
    """(3, N) mm of the machine's model; axes that were not recorded stand at zero."""
    n = len(state)
    position = np.stack([state.position.get(x, np.zeros(n)) for x in machine.letters])
    approach = np.stack([state.approach.get(x, np.zeros(n)) for x in machine.letters])
    deviation = machine.deviation(position, approach)
    result = np.zeros((3, n))
    for i, x in enumerate(machine.letters):
        if x in XYZ:
            result[XYZ.index(x)] = deviation[i]
    return result


# -- one recording -------------------------------------------------------------------------------------------------------


def _signals(recording: Recording, machine: Machine):
    """(name, columns) of every signal of a recording."""
    makers = {"targets": _targets, "ballbar": _ballbar, "trace": _trace, "features": _features}
    yield from makers[recording.kind](recording, machine)


def _common(recording: Recording) -> dict[str, np.ndarray]:
    n = len(recording)
    columns: dict[str, np.ndarray] = {
        "time": recording.columns.get("t_s", np.arange(n, dtype=float)),
        "run": recording.columns.get("run", np.ones(n)),
        "line": recording.lines if len(recording.lines) == n else np.arange(n),
    }
    for name, values in recording.columns.items():
        if name.startswith(("T_", "force_", "spindle_rpm", "feed_mm_min")) and values.dtype != object:
            columns[f"channel {name}"] = values
    return columns


def _targets(recording: Recording, machine: Machine):
    columns = _common(recording)
    n = len(recording)
    vector = np.array([recording.sensitive.get(x, 0.0) for x in XYZ])
    angle = recording.quantity == "angle"
    if angle:
        vector = np.array(
            [recording.sensitive.get(x, recording.sensitive.get("ABC"[i], 0.0)) for i, x in enumerate(XYZ)]
        )
    path = np.zeros(n)
    for x in recording.axes:
        if x not in XYZ:
            continue
        p = recording.position(x)
        columns[f"{x} position"], columns[f"{x} approach"] = p, recording.approach(x)
        columns[f"{x} distance"] = _since_turn(p, recording.approach(x), columns["run"])
        path += vector[XYZ.index(x)] * p
    columns["beam"] = path - path.min() if not angle and recording.quantity == "displacement" else np.zeros(n)
    laser = "laser" if recording.quantity == "displacement" else "tool"
    yield "reading_urad" if angle else "reading_um", columns | {
        "y": recording.reading, "direction": np.repeat(vector[None], n, axis=0), "sees": "angle" if angle else laser,
    }  # fmt: skip


def _since_turn(position: np.ndarray, approach: np.ndarray, run: np.ndarray) -> np.ndarray:
    """(N,) mm travelled since the axis turned back, as far as the targets tell: each is overrun a little before a turn."""
    result = np.full(len(position), FAR)
    gone = FAR
    for k in range(1, len(position)):
        step = abs(position[k] - position[k - 1])
        if approach[k] != approach[k - 1]:
            gone = step + OVERRUN if step < 1e-9 or approach[k] * (position[k] - position[k - 1]) >= 0 else OVERRUN
        else:
            gone = gone + step
        result[k] = gone
    if np.ptp(position) < 1e-9:
        return np.full(len(position), FAR)
    return result


def _motion(columns: dict, letter: str, position: np.ndarray, time: np.ndarray, run: np.ndarray) -> None:
    """Velocity, acceleration, approach and what has passed since a turn, from the commanded path of each run."""
    n = len(position)
    names = ("velocity", "acceleration", "approach", "distance", "since")
    v, a, s, d, since = (np.zeros(n) for _ in names)
    edges = np.flatnonzero((np.diff(run) != 0) | (np.diff(time) <= 0)) + 1
    for part in np.split(np.arange(n), edges):
        if len(part) < 3:
            continue
        t, p = time[part], position[part]
        v[part] = np.gradient(p, t)
        a[part] = np.gradient(v[part], t)
        jitter = RESTS / max(float(np.median(np.diff(t))), 1e-9)  # a log rounds the place of an axis that rests
        still = np.abs(v[part]) < max(1e-4 * float(np.abs(v[part]).max()), jitter)
        sign = np.sign(v[part]) * ~still
        held = np.maximum.accumulate(np.where(sign != 0, np.arange(len(part)), -1))
        s[part] = np.where(held >= 0, sign[np.maximum(held, 0)], 0)
        turn = np.concatenate([[False], (s[part][1:] != s[part][:-1]) & (s[part][:-1] != 0)])
        last = np.maximum.accumulate(np.where(turn, np.arange(len(part)), -1))
        gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(p)))])
        d[part] = np.where(last >= 0, gone - gone[np.maximum(last, 0)], FAR)
        since[part] = np.where(last >= 0, t - t[np.maximum(last, 0)], FAR)
    for name, value in zip(names, (v, a, s, d, since), strict=True):
        columns[f"{letter} {name}"] = value
    columns[f"{letter} position"] = position


def _ballbar(recording: Recording, machine: Machine):
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
    unit /= np.maximum(np.linalg.norm(unit, axis=1), 1e-9)[:, None]
    sure = _sure(columns, [x for x in recording.axes if x in centre], run)
    columns |= {"y": recording.reading, "direction": unit, "dense": np.ones(n)}
    columns = {name: value[sure] for name, value in columns.items()}
    yield "radial_um", _averaged(columns | {"sees": "tool"}, run[sure])


def _unbroken(run: np.ndarray, sense: np.ndarray) -> np.ndarray:
    """Runs, cut where the sense changes."""
    change = np.concatenate([[0], np.cumsum((np.diff(run) != 0) | (np.diff(sense) != 0))])
    return change.astype(float)


def _trace(recording: Recording, machine: Machine):
    columns = _common(recording)
    scale = recording.head.get("sees", "scale") == "scale"
    letters = [x for x in recording.axes if x in XYZ]
    for x in letters:
        _motion(columns, x, recording.position(x), columns["time"], columns["run"])
    # Before an axis has moved, nobody knows from which side it came; and in the very sample in which it turns neither.
    sure = _sure(columns, [x for x in letters if np.ptp(recording.position(x)) > 0], columns["run"])
    for x in letters:
        y = recording.columns[f"{x}_act_mm"] - recording.position(x)
        direction = np.zeros((len(recording), 3))
        direction[:, XYZ.index(x)] = 1.0
        one = columns | {"y": y, "dense": np.ones(len(y)), "direction": direction, "sees": "scale" if scale else "tool"}
        one = {name: v[sure] if isinstance(v, np.ndarray) else v for name, v in one.items()}
        yield f"{x}_act_mm", _averaged(one, one["run"])


def _sure(columns: dict, letters: list[str], run: np.ndarray) -> np.ndarray:
    """(N,) bool: samples whose directions of approach are known."""
    result = np.ones(len(run), bool)
    for x in letters:
        side = columns[f"{x} approach"]
        turn = np.flatnonzero((np.diff(side) != 0) & (np.diff(run) == 0))
        result &= side != 0
        result[turn] = False
        result[turn + 1] = False
    return result


def _averaged(columns: dict, run: np.ndarray) -> dict:
    """Neighbouring samples of a run averaged until at most MOST_ROWS are left."""
    n = len(columns["y"])
    width = int(np.ceil(n / MOST_ROWS))
    if width == 1:
        return columns
    cut = np.diff(run) != 0
    for name, value in columns.items():
        if name.endswith("approach"):
            cut = cut | (np.diff(value) != 0)
    start = np.concatenate([[0], np.flatnonzero(cut) + 1, [n]])
    edges = np.concatenate([np.arange(a, b, width) for a, b in pairwise(start)])
    size = np.diff(np.append(edges, n))
    step = np.median(np.diff(columns["time"])) if n > 1 else 0.0
    result: dict = {"width": size * float(step)}
    for name, value in columns.items():
        if not isinstance(value, np.ndarray):
            result[name] = value
        elif name in ("run", "line") or name.endswith("approach"):
            result[name] = value[np.minimum(edges + size // 2, n - 1)]
        else:
            mean = np.add.reduceat(value, edges, axis=0)
            result[name] = mean / (size if value.ndim == 1 else size[:, None])
    return result


def _features(recording: Recording, machine: Machine):
    columns = _common(recording)
    kind, axis = recording.columns["kind"], recording.columns["axis"]
    nominal = recording.columns["nominal_mm"]
    use = np.array(
        [k in (*MATERIAL, "centre_distance", "step") and str(a)[:1] in XYZ for k, a in zip(kind, axis, strict=True)]
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
        middle = (low + high) / 2 if np.isfinite(low + high) else 0.0
        columns[f"{x} position"] = np.where(turned & (size > 0), size / 2, middle + size / 2)
        columns[f"{x} other"] = np.where(turned, np.nan, middle - size / 2)
        # A wall is reached from the inside of a pocket or a bore, from the outside of a boss.
        columns[f"{x} approach"] = np.where(size > 0, [INSIDE.get(str(k), 0.0) for k in kind], 0.0)
    part = recording.columns.get("part", np.ones(n))
    columns["channel part"] = np.array([float(p) if str(p).replace(".", "").isdigit() else 0.0 for p in part])
    columns["channel material"] = np.where(turned, 0.0, [MATERIAL.get(str(k), 0.0) for k in kind])
    columns["channel wall"] = np.where(turned, 1.0, [-MATERIAL.get(str(k), 0.0) for k in kind])
    columns["channel bore"] = np.array([float(k == "bore_diameter") for k in kind]) * turned
    columns["run"] = columns["channel part"]
    columns["y"], columns["direction"] = recording.columns["measured_mm"] - nominal, direction
    names = np.array([f"{f} {k}" for f, k in zip(recording.columns["feature"], kind, strict=True)])
    for name in sorted(set(names[use])):
        which = use & (names == name)
        yield f"measured_mm {name}", {c: v[which] for c, v in columns.items()} | {"sees": "part"}
