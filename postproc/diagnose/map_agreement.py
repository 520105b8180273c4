"""Whether readings are of this machine at all: how much of the fine structure of its map they hold.

A map has details that no simple effect has: what is left of it without zeros, lines and reversals.
Readings in their right unit, sign and place hold once as much of them; the regression of the
readings on the details says how much it is; where the map states its uncertainty, no surer than
that leaves its details.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.diagnose import nuisances
from postproc.diagnose.assembly import of
from postproc.diagnose.rows import Rows
from postproc.errors import Place
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

SURE = 0.12  # standard error of the share from which on it says something
WIDE = 4.0  # standard errors
HALF, TWICE = 0.5, 2.0
READINGS = {1000.0: "nm", 0.001: "mm", 1 / 25.4: "thousandths of an inch", -1.0: "the other sign"}
LIKE = 0.2  # of a factor
PLACES = {1000.0: "m", 25.4: "inch", 0.001: "um"}
FEWEST = 12  # readings at places that were visited again
SCATTER = 0.9  # of the scatter of all readings
SCATTERED = 3.0  # standard errors
NO_INSTRUMENT = 0.1  # mm
CIRCLE = 24  # places of a circle that tell something of their own


# Whole: the ways to miss a map, in their order of precedence.
def disagreements(
    recordings: list[Recording], rows: Rows, machine: Machine
) -> dict[int, list[str]]:
    """What speaks against these being readings of this machine: sentences by the number of the
    recording that does not follow the map.

    Raises RecordingError where another unit or sign would make it follow.
    """
    result: dict[int, list[str]] = {}
    for number, recording in enumerate(recordings):
        if recording.kind not in ("targets", "ballbar"):
            continue
        share, error = _share(rows.pick(rows.file == number), machine)
        if (
            error <= SURE * max(1.0, abs(share))
            and share + WIDE * error >= HALF
            and share - WIDE * error <= TWICE
        ):
            continue
        unit = _places(recording, machine, share, error)
        if unit:
            raise RecordingError(
                f"the places fit the map of {machine.name} as {unit}, and not as mm",
                "give them in mm, or the head another machine",
                Place(recording.file, int(recording.lines[0])),
            )
        if error > SURE * max(1.0, abs(share)):
            result[number] = _scattered(recording, rows.pick(rows.file == number), machine)
            continue
        for factor, words in READINGS.items():
            if abs(share / factor - 1) < LIKE and error < LIKE * abs(factor):
                raise RecordingError(
                    f"the readings hold {share:.4g} times what the map of {machine.name} says, as"
                    f" if {'they had ' if factor < 0 else 'they were in '}{words}",
                    "readings are in um (angles in urad), actual minus commanded",
                    Place(recording.file, int(recording.lines[0])),
                )
        if share > HALF or share < -TWICE:
            # an effect that looks like a detail of the map, and is larger: for others to name
            continue
        # a lag, a give, a scale of one axis make an ellipse; so may the map
        if recording.kind == "ballbar":
            finer, its_error = _share(rows.pick(rows.file == number), machine, ellipses=True)
            if its_error > SURE * max(1.0, abs(finer)) or finer + WIDE * its_error >= HALF:
                continue
        result[number] = [
            f"{recording.file}: what the map of {machine.name} says is not in these readings: they"
            f" hold {share:.2f} of it ({share - 2 * error:.2f} to {share + 2 * error:.2f}). Another"
            " machine, rows mixed up, or a table of the control that the machine's file does not"
            " know of"
        ]
    return result


def remaining(
    disagreements: dict[int, list[str]], rows: Rows, machine: Machine, named: np.ndarray
) -> list[str]:
    """Sentences of the recordings that do not follow the map beside the effects that were named
    either. named: (N,) mm, the effects in these rows, without curves of many terms: these could
    stand for the map of another machine."""
    result = []
    for number, sentences in disagreements.items():
        which = rows.file == number
        if not sentences or not named[which].any():  # or all of its readings were left out
            result += sentences
            continue
        share, error = _share(replace(rows, y=rows.y - named).pick(which), machine)
        if not (share > 2.0 * error and abs(share - 1.0) <= max(HALF, 2.0 * error)):
            result += sentences
    return result


def _scattered(recording: Recording, rows: Rows, machine: Machine) -> list[str]:
    """A sentence where readings at the same place differ as much as all readings do, and the map is
    not in them."""
    grain = 2 if recording.kind == "targets" else 0  # digits of a mm
    where = np.stack([*rows.state.position.values(), *rows.state.approach.values()])
    _, place = np.unique(np.round(where, grain), axis=1, return_inverse=True)
    again = np.bincount(place.ravel())[place.ravel()] > 1
    if again.sum() < FEWEST:
        return []
    y, known = rows.y[again] - rows.y[again].mean(), rows.known[again] - rows.known[again].mean()
    _, place = np.unique(place.ravel()[again], return_inverse=True)
    means = np.bincount(place, y) / np.bincount(place)
    within = float(np.sqrt(np.sum((y - means[place]) ** 2) / max(len(y) - len(means), 1)))
    power = float(known @ known)
    if power == 0 or within < SCATTER * float(np.std(y)):
        return []
    if within > NO_INSTRUMENT:
        return [
            f"{recording.file}: readings at the same place differ by {within * 1e3:.0f} um (one"
            " standard deviation): no measurement of a machine"
        ]
    share = float(known @ y) / power
    error = float(np.std(y - share * known)) / np.sqrt(power)
    error = float(np.hypot(error, _unsure(rows.pick(again), machine, known)))
    if share + SCATTERED * error >= HALF:
        return []
    return [
        f"{recording.file}: readings at the same place differ as much as all readings do, by"
        f" {within * 1e3:.2f} um, and hold {share:.2f} of what the map of {machine.name} says"
        f" ({share - 2 * error:.2f} to {share + 2 * error:.2f}). Rows mixed up, or another machine"
    ]


# Whole: one unit to a pass, under all the conditions for it.
def _places(recording: Recording, machine: Machine, share: float, error: float) -> str:
    """The unit in which the places would fit the map, or ""."""
    for factor, unit in PLACES.items():
        columns = dict(recording.columns)
        inside = True
        for letter in (x for x in recording.axes if x in machine.letters and x in "XYZ"):
            name = next(
                n
                for n in columns
                if n.startswith(letter) and n in (f"{letter}_mm", f"{letter}_cmd_mm")
            )
            columns[name] = columns[name] * factor
            low, high = machine.axes[letter].travel
            inside &= bool(columns[name].min() >= low - 1 and columns[name].max() <= high + 1)
        if not inside or recording.kind != "targets":
            continue
        again, its_error = _share(of([replace(recording, columns=columns)], machine), machine)
        if (
            its_error < SURE
            and abs(again - 1) < 0.25
            and not (error < SURE and abs(share - 1) < 0.5)
        ):
            return unit
    return ""


def _share(rows: Rows, machine: Machine, ellipses: bool = False) -> tuple[float, float]:
    """How much of the map's details the readings hold, and its standard error; (1, inf) where the
    map has none. ellipses: what goes with the place, the speed or the side of an axis, as a circle
    shows it, is no detail either."""
    columns = []
    for signal in np.unique(rows.signal):
        which = (rows.signal == signal).astype(float)
        columns.append(which)
        for run in np.unique(rows.run):
            columns.append(which * (rows.run == run))
        for x, p in rows.state.position.items():
            side = rows.state.approach[x]
            columns += [which * p, which * side, which * side * p]
            if ellipses:
                along = which * rows.direction[:, XYZ.index(x)]
                columns += [along * q for q in rows.state.position.values()]
                columns += [along * side, along * rows.state.velocity[x]]
        columns += (
            [which * rows.direction[:, i] for i in range(3)]
            if rows.state.passage[rows.signal == signal][0] >= 0
            else []
        )
    base = np.stack(columns, axis=1)
    base = base / np.maximum(np.abs(base).max(axis=0), 1e-12)
    # Columns that say the same (places that go with runs) would make the base singular: they are
    # left out by the diagonal of R.
    q, r = np.linalg.qr(base)
    q = q[:, np.abs(np.diag(r)) > 1e-8 * max(float(np.abs(r).max()), 1e-30)]
    detail = rows.known - q @ (q.T @ rows.known)
    power = float(detail @ detail)
    if power < 1e-10 * len(rows):
        return 1.0, np.inf
    y = rows.y - q @ (q.T @ rows.y)
    share = float(detail @ y) / power
    places = len(
        np.unique(
            np.round(np.stack([*rows.state.position.values(), *rows.state.approach.values()]), 2),
            axis=1,
        ).T
    )
    places = min(places, CIRCLE) if rows.state.passage[0] >= 0 else places
    left = y - share * detail
    # Runs at one target repeat what is not explained there: places count, and not readings.
    freedom = max(places - 3 * len(rows.state.position), 1)
    error = float(np.sqrt(left @ left / power / freedom))
    return share, float(np.hypot(error, _unsure(rows, machine, detail)))


def _unsure(rows: Rows, machine: Machine, detail: np.ndarray) -> float:
    """Standard error of the share by what the map states that it may be wrong; 0 where it states
    nothing. detail: (N,) mm."""
    if all(machine.axes[x].uncertainty is None for x in rows.state.position):
        return 0.0
    power = float(detail @ detail)
    groups = nuisances.of_map(rows, machine)
    return float(
        np.sqrt(sum(np.sum((g.sd * detail @ g.columns) ** 2) for g in groups if g.kind == "map"))
    ) / max(power, 1e-30)
