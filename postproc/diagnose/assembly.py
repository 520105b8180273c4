"""Recordings of an experiment to rows: all in one table, in the order of files, with the state of
the machine at each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.diagnose.averages import Columns
from postproc.diagnose.predicted import angles_of, predicted
from postproc.diagnose.rows import ENTERS, Rows
from postproc.diagnose.signals import FAR, signals_of
from postproc.effects import State
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

APART = 20.0  # mm between two lines: nearer, a rotation of 10 urad differs by less than 0.2 um
CELLS, FEWEST_CELLS = 24, 4  # of a travel; those in which lines lie apart
TURNED = ("A_deg", "B_deg", "C_deg")
NONE_ELSEWHERE = ("spindle_rpm", "part", "wall", "material", "bore", "hole", *TURNED)


def of(recordings: list[Recording], machine: Machine) -> Rows:
    """All rows of an experiment. Raises RecordingError for an axis that the machine has not, or a
    kind without rows."""
    parts = []
    signals: list[str] = []
    for number, recording in enumerate(recordings):
        for letter in recording.axes:
            if letter not in machine.letters:
                raise RecordingError(
                    f"{recording.file} records {letter}, which is no axis of {machine.name}",
                    f"its axes are {' '.join(machine.letters)}",
                )
        for name, columns in signals_of(recording, machine):
            columns["file"] = np.full(len(columns["y"]), number)
            columns["signal"] = np.full(len(columns["y"]), len(signals))
            signals.append(name)
            parts.append(columns)
    if not parts:
        raise RecordingError(
            "there is nothing to compare in these recordings",
            "targets, ballbar, trace or features are wanted",
        )
    return _joined(parts, machine, signals, recordings)


# Whole: one line to a column; a branch is a column that is missing.
def _joined(
    parts: list[Columns], machine: Machine, signals: list[str], recordings: list[Recording]
) -> Rows:
    letters = [x for x in machine.letters if x in XYZ]
    n = sum(len(p["y"]) for p in parts)

    def column(name: str, default: float = 0.0) -> np.ndarray:
        return np.concatenate(
            [np.broadcast_to(p.get(name, default), len(p["y"])).astype(float) for p in parts]
        )

    position = {x: column(f"{x} position") for x in letters}
    approach = {x: column(f"{x} approach") for x in letters}
    slips = {x: own for p in parts for x, own in p.get("slips", {}).items()}
    channels = sorted(
        {name.removeprefix("channel ") for p in parts for name in p if name.startswith("channel ")}
    )
    # What a signal has no column of counts as "never": FAR since a turn, so that what a turn sets
    # off has faded; a channel NaN, which `_filled` takes up.
    state = State(
        position=position,
        approach=approach,
        travel=_travels(machine, letters),
        velocity={x: column(f"{x} velocity") for x in letters},
        acceleration={x: column(f"{x} acceleration") for x in letters},
        distance={x: column(f"{x} distance", FAR) for x in letters},
        since={x: column(f"{x} since", FAR) for x in letters},
        time=column("time"),
        run=column("run"),
        channels={c: column(f"channel {c}", np.nan) for c in channels},
        angles={},
        beam=column("beam"),
        passage=_passages(parts),
        file=column("file"),
        width=column("width"),
        inside=_inside(parts, letters),
        slipped={x: column(f"{x} slipped", np.nan) for x in slips},
    )
    # In steps, for each looks at the state before it: channels go by the times, ways by sides and
    # distances, angles by the places.
    state = replace(
        state, channels={c: _filled(c, state) for c in channels}, path=_paths(parts, state)
    )
    angles = {
        x: a if (a := angles_of(machine, x, state)) is not None else _recorded(parts, x, state)
        for x in letters
    }
    state = replace(state, angles={x: a for x, a in angles.items() if a is not None and a.any()})
    direction = np.concatenate([p["direction"] for p in parts])
    sees = np.concatenate([np.full(len(p["y"]), p["sees"]) for p in parts])
    state = replace(
        state,
        lines=_lines(parts, state, direction),
        arms={x: machine.arm_at(x, position) for x in letters if not machine.chain.rotary},
        on_arm="".join(x for x in letters if machine.on_own_arm(x)),
        turned=sees == "angle",
    )
    rows = Rows(
        column("y"),
        np.zeros(n),
        direction,
        sees,
        column("file").astype(int),
        column("run").astype(int),
        column("signal").astype(int),
        column("line").astype(int),
        state,
        tuple(signals),
        tuple(r.file for r in recordings),
        tuple(r.kind for r in recordings),
        (
            {x: column(f"{x} other", np.nan) for x in letters}
            if any(p["sees"] == "part" for p in parts)
            else {}
        ),
        column("grain"),
        column("rounding"),
        tuple(sorted({f for p in parts for f in p.get("fast_hz", ())})),
        slips,
    )
    return replace(rows, known=predicted(rows, machine))


def _inside(parts: list[Columns], letters: list[str]) -> dict[str, np.ndarray]:
    """Axis, or "time", to (W, N): where, and when, the samples of each row were taken."""
    most = max((len(p["inside"]["time"]) for p in parts if "inside" in p), default=0)
    if most == 0:
        return {}
    result = {}
    for name in ("time", *letters):
        columns = []
        for p in parts:
            one = np.full((most, len(p["y"])), np.nan)
            #          rows of a part   rows of samples
            #     [0]  its own place    x0                 W: the most samples that any row has
            #     [1]  nan              x1
            #     ...  nan              nan                this row has two
            one[0] = p.get("time" if name == "time" else f"{name} position", 0.0)
            own = p.get("inside", {}).get(name)
            if own is not None:
                one[: len(own)] = own
            columns.append(one)
        result[name] = np.concatenate(columns, axis=1)
    return result


def _paths(parts: list[Columns], state: State) -> dict[str, np.ndarray]:
    """Axis to (M, N) mm: the ways that its drive remembers; of rows without a path one turn, after
    a long way."""
    result = {}
    for x in state.position:
        most = max((p[f"{x} path"].shape[1] for p in parts if f"{x} path" in p), default=0)
        if not most:
            continue
        ways = np.zeros((max(most, 2), len(state)))
        # as one that came from far away, turned, and has gone `distance` since
        ways[0], ways[1] = -FAR * state.approach[x], state.distance[x] * state.approach[x]
        first = 0
        for p in parts:
            n = len(p["y"])
            if f"{x} path" in p:
                own = p[f"{x} path"].T
                ways[:, first : first + n] = 0.0
                ways[: len(own), first : first + n] = own
            first += n
        result[x] = ways
    return result


def _passages(parts: list[Columns]) -> np.ndarray:
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
    """The range over which shapes are drawn: the travel, as for the compensator and the
    simulator."""
    return {x: machine.axes[x].travel for x in letters}


def _filled(name: str, state: State) -> np.ndarray:
    """A channel where it was not recorded: a temperature as it went from reading to reading, else
    the mean, which tells nothing. A machine begins its day as warm as its room. A spindle of which
    nobody says that it turned stood still, and what is no part has no walls."""
    values, room = state.channels[name], state.channels.get("T_air_C")
    if name == "program_line":  # no line is the mean of others
        return values
    known, timed = np.isfinite(values), _timed(state)
    mean = known.any() and name not in NONE_ELSEWHERE
    filled = np.where(known, values, values[known].mean() if mean else 0.0)
    timed_known = known & timed
    if not name.startswith("T_") or not timed_known.any():
        return filled
    order = np.argsort(state.time[timed_known], kind="stable")
    t, level = state.time[timed_known][order], values[timed_known][order]
    # before its own first reading, from the room's first one on: as warm as the room
    if room is not None and (felt := np.isfinite(room) & timed).any():
        first = np.flatnonzero(felt)[np.argmin(state.time[felt])]
        if state.time[first] < t[0]:
            t, level = np.append(state.time[first], t), np.append(room[first], level)
    return np.where(timed & ~known, np.interp(state.time, t, level), filled)


def _timed(state: State) -> np.ndarray:
    """(N,) bool: rows of recordings whose times were recorded."""
    files = [f for f in np.unique(state.file) if np.ptp(state.time[state.file == f]) > 0]
    return np.isin(state.file, files)


def _recorded(parts: list[Columns], letter: str, state: State) -> np.ndarray | None:
    """(3, N) rad: the rotations of an axis as this very experiment measured them, where the
    machine's file has none; by the direction of approach where both were measured."""
    result = np.zeros((3, len(state)))
    for p in parts:
        place = p.get(f"{letter} position")
        if p["sees"] != "angle" or place is None or np.ptp(place) < 1e-3:
            continue
        k = int(np.abs(p["direction"][0]).argmax())
        for side in (-1, 1):
            own = p[f"{letter} approach"] == side
            own = own if own.any() else np.ones(len(place), bool)
            at, group = np.unique(np.round(place[own], 3), return_inverse=True)
            # A reading about -X is that about X with the other sign: direction is +-1 there.
            value = np.bincount(group, p["y"][own] * p["direction"][own, k]) / np.bincount(group)
            # rows whose side nobody recorded take the curve of +
            rows = (np.sign(state.approach[letter]) == side) | (
                (state.approach[letter] == 0) & (side > 0)
            )
            # level beyond the first and the last target: no slope is carried on
            result[k, rows] = np.interp(state.position[letter][rows], at, value)
    return result if result.any() else None


def _lines(parts: list[Columns], state: State, direction: np.ndarray) -> dict[str, str]:
    """Axis to the axes that stood at two places, APART or more, while readings along it were taken
    at rest at the same places."""
    sees = np.concatenate([np.full(len(p["y"]), p["sees"]) for p in parts])
    result: dict[str, str] = {}
    for x in state.position:
        own = (
            np.isin(sees, ("laser", "tool"))
            & (state.passage < 0)
            & (np.abs(direction[:, XYZ.index(x)]) > ENTERS)
        )
        if not own.any():
            continue
        # Of the travel, -1..1 to 0..1. Lines are held against each other within a cell of it, so
        # that two places of x itself are no second line.
        share = (state.share(x)[own] + 1) / 2
        cell = np.clip((share * CELLS).astype(int), 0, CELLS - 1)
        found = ""
        for other, q in state.position.items():
            if other != x and _apart(cell, q[own]):
                found += other
        if found:
            result[x] = found
    return result


def _apart(cell: np.ndarray, place: np.ndarray) -> bool:
    """Whether some readings in the same cells of one axis have places of another that lie APART."""
    low, high = np.full(CELLS, np.inf), np.full(CELLS, -np.inf)
    np.minimum.at(low, cell, place)
    np.maximum.at(high, cell, place)
    return bool(np.count_nonzero(high - low >= APART) >= FEWEST_CELLS)
