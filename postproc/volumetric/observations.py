"""Recordings to rows of a residual: points of a tracker, lengths from stations, displacements along
lines, angles, spheres; and at what their nuisances begin."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from postproc.errors import Place
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError
from postproc.units import UM
from postproc.volumetric import VolumetricError, circles, step_diagonals
from postproc.volumetric.rows import SAME, Rows, nominal_tip

# mm, standard deviation of a station's stated place: a ball on a table is set with a rule
STATED = 1.0
FITS = 0.1  # mm: lengths from a station fit its place so well where it is the right one
PLACES = ("mx_mm", "my_mm", "mz_mm")
SHIFTS = ("dx_um", "dy_um", "dz_um")


def rows_of(recording: Recording, machine: Machine, others: dict[str, float]) -> list[Rows]:
    """The rows of a recording, one for each set-up in it. others: mm, of axes that it does not
    record. Raises VolumetricError."""
    q, approach = _places(recording, machine, others)
    tool = machine.tool + _beside(recording)
    u = float("nan") if recording.u is None else float(recording.u)
    base = Rows("", q, approach, np.zeros(0), u, tool, np.zeros(0), recording.file, np.zeros(3))
    if recording.kind == "points":
        return _clouds(recording, machine, base)
    if recording.kind == "lengths":
        return _lengths(recording, machine, base)
    if recording.kind == "sphere":
        return _spheres(recording, machine, base)
    if recording.kind == "ballbar":
        return circles.rows_of(recording, machine, base)
    if recording.kind == "targets":
        return _lines(recording, machine, base)
    raise VolumetricError(
        f"a recording of {recording.kind} tells nothing of the volume here",
        "kinds: points, lengths, ballbar, sphere, targets",
        Place(recording.file, 1),
    )


def _beside(recording: Recording) -> np.ndarray:
    """(3,) mm: from the tool's point of the machine to what was read, the head's `tool`."""
    said = recording.head.get("tool", {})
    if not isinstance(said, dict) or not all(
        k in XYZ and isinstance(v, int | float) and np.isfinite(v) for k, v in said.items()
    ):
        raise RecordingError(
            f"tool = {said!r}: a place is wanted, mm from the machine's tool point",
            "like tool = { X = 0.0, Z = -100.0 }",
            Place(recording.file, 1),
        )
    return np.array([float(said.get(x, 0.0)) for x in XYZ])


def _places(
    recording: Recording, machine: Machine, others: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    n = len(recording)
    q, approach = np.zeros((len(machine.letters), n)), np.zeros((len(machine.letters), n))
    for i, x in enumerate(machine.letters):
        if x in recording.axes:
            q[i], approach[i] = recording.position(x), recording.approach(x)
        elif x in machine.chain.axes and x in others:
            q[i] = others[x]
        elif x in machine.chain.axes and x in XYZ:
            raise VolumetricError(
                f"where {x} stood is not recorded",
                f"a column {x}_mm, or --others {x}0",
                Place(recording.file, 1),
            )
    for x in recording.axes:
        if x not in machine.chain.axes:
            raise VolumetricError(
                f"{x} is recorded, and the chain has no {x}",
                "--like the machine that was measured",
                Place(recording.file, 1),
            )
    return q, approach


def _parts(recording: Recording, name: str) -> list[np.ndarray]:
    """Rows that belong together by a column, all where there is none. Raises VolumetricError where
    a row does not say which it belongs to."""
    column = recording.columns.get(name)
    if column is None:
        return [np.arange(len(recording))]
    empty = np.flatnonzero(np.isnan(column))
    if len(empty):
        raise VolumetricError(
            f"the column {name} is empty in {len(empty)} of {len(column)} rows",
            f"a number in every row says which {name} it belongs to; without the column all rows"
            " are of one",
            Place(recording.file, int(recording.lines[empty[0]])),
        )
    return [np.flatnonzero(column == v) for v in np.unique(column)]


def _picked(base: Rows, which: np.ndarray, **more: Any) -> Rows:
    return replace(base, q=base.q[:, which], approach=base.approach[:, which], **more)


def _clouds(recording: Recording, machine: Machine, base: Rows) -> list[Rows]:
    shift = all(c in recording.columns for c in SHIFTS)
    found = []
    for which in _parts(recording, "setup"):
        if shift:
            value = np.array([recording.columns[c][which] for c in SHIFTS]) * UM
            found.append(_picked(base, which, kind="shift", value=value, start=value.mean(axis=1)))
            continue
        value = np.array([recording.columns[c][which] for c in PLACES])
        if value.shape[1] < 4:
            raise VolumetricError(
                "a cloud of fewer than four points has no frame of its own",
                "more points in each setup",
                Place(recording.file, 1),
            )
        nominal = nominal_tip(machine, base.q[:, which], base.tool)
        found.append(
            _picked(base, which, kind="cloud", value=value, start=_aligned(value, nominal))
        )
    return found


def _lengths(recording: Recording, machine: Machine, base: Rows) -> list[Rows]:
    found = []
    for which in _parts(recording, "station"):
        value = recording.columns["length_mm"][which]
        # place (3) and dead path (1): the fifth length is the first that says anything of the
        # machine
        if len(which) < 5:
            raise VolumetricError(
                "a station needs five lengths at least: its own place and its dead path are four"
                " numbers",
                "",
                Place(recording.file, 1),
            )
        nominal = nominal_tip(machine, base.q[:, which], base.tool)
        said = _said(recording, which)
        # the place as stated, within STATED; the dead path stays free
        loose = np.zeros(4) if said is None else np.array([1 / STATED] * 3 + [0.0])
        start = _station(said, value, nominal)
        found.append(_picked(base, which, kind="length", value=value, start=start, loose=loose))
    return found


def _said(recording: Recording, which: np.ndarray) -> np.ndarray | None:
    """(3,) mm: the place of a station as its columns say, None where there are none."""
    columns = [f"station_{x}_mm" for x in XYZ]
    missing = [c for c in columns if c not in recording.columns]
    if len(missing) == 3:
        return None
    place = Place(recording.file, int(recording.lines[which[0]]))
    if missing:
        raise VolumetricError(
            f"the station's place is said in part: no column {' and no column '.join(missing)}",
            "all three, or none: it is then found by the lengths",
            place,
        )
    said = np.array([recording.columns[c][which] for c in columns])
    if not (np.isfinite(said).all() and (np.ptp(said, axis=1) <= SAME).all()):
        raise VolumetricError(
            "the lengths of one station do not name one place of it",
            "a column station with a number for each station, and its place in each of its rows",
            place,
        )
    return np.asarray(said[:, 0])


def _station(said: np.ndarray | None, value: np.ndarray, nominal: np.ndarray) -> np.ndarray:
    """(4,) mm: place and dead path of a station: as said, else by least squares over the lengths,
    begun on every side of the points until one end fits."""
    if said is not None:
        return np.append(
            said, float((value - np.linalg.norm(nominal - said[:, None], axis=0)).mean())
        )
    from scipy.optimize import least_squares

    middle, far = nominal.mean(axis=1), float(value.mean())
    best = None
    # Lengths alone have mirror images: points that nearly lie in a plane fit a station on either
    # side of it. 26 directions at the mean length, and the middle itself, are beginnings.
    for way in np.array(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1])).reshape(3, -1).T:
        size = float(np.linalg.norm(way))
        begin = np.append(middle + (way / size * far if size else 0.0 * way), 0.0)
        done = least_squares(
            lambda s: np.linalg.norm(nominal - s[:3, None], axis=0) + s[3] - value, begin
        )
        if best is None or done.cost < best.cost:
            best = done
        # what is left are errors of a machine, not another place
        if best.cost < FITS**2 * len(value):
            break
    assert best is not None
    return np.asarray(best.x)


def _spheres(recording: Recording, machine: Machine, base: Rows) -> list[Rows]:
    found = []
    for which in _parts(recording, "sphere"):
        place = nominal_tip(machine, base.q[:, which], base.tool).mean(axis=1)
        found.append(
            _picked(base, which, kind="sphere", value=np.zeros((3, len(which))), start=place)
        )
    return found


def _angles(recording: Recording, base: Rows, moved: list[str]) -> list[Rows]:
    """Angles along one axis. Raises VolumetricError."""
    rotation = next((r for r in XYZ + ROTARY if abs(recording.sensitive.get(r, 0.0)) > 0.999), "")
    if len(moved) != 1 or not rotation:
        raise VolumetricError(
            "angles are read while one axis moves, about one axis", "", Place(recording.file, 1)
        )
    # B, or Y as the axis about which it is read: row 4, EB
    row = 3 + (ROTARY.index(rotation) if rotation in ROTARY else XYZ.index(rotation))
    sign = float(np.sign(recording.sensitive[rotation]))
    return [
        _picked(
            base,
            which,
            kind="angle",
            value=sign * recording.reading[which],
            start=np.zeros(1),
            letter=moved[0],
            row=row,
        )
        for which in _parts(recording, "setup")
    ]


def _moved(recording: Recording) -> list[str]:
    """The slides that move."""
    return [x for x in XYZ if x in recording.axes and np.ptp(recording.position(x)) > SAME]


def _lines(recording: Recording, machine: Machine, base: Rows) -> list[Rows]:
    moved = _moved(recording)
    along = np.array([recording.sensitive.get(x, 0.0) for x in XYZ])
    if recording.quantity == "angle":
        return _angles(recording, base, moved)
    # 0.045 is the sine of 2.6 degrees: a displacement read nearly at right angles is a straightness
    across = recording.quantity == "straightness" or (
        len(moved) == 1 and abs(along[XYZ.index(moved[0])]) < 0.045
    )
    return [
        (None if across else _stair(recording, machine, base, along, which))
        or _line(recording, base, along, which, across)
        for which in _parts(recording, "setup")
    ]


def _line(
    recording: Recording, base: Rows, along: np.ndarray, which: np.ndarray, across: bool
) -> Rows:
    """A set-up of displacements along a line, or of readings across it."""
    places = np.unique(np.round(base.q[:, which], 3), axis=1).shape[1]
    if across and places < 3:
        raise VolumetricError(
            f"a straightness of {places} places in one set-up: its zero and its slope are of"
            " the set-up, and nothing is left",
            "three places at least in each setup",
            Place(recording.file, int(recording.lines[which[0]])),
        )
    return _picked(
        base, which, kind="straightness" if across else "line", value=recording.reading[which],
        # across: a zero and a slope of the set-up; along: a zero alone, since a laser's line has a
        # scale to tell
        start=np.zeros(2 if across else 1), along=along,
    )  # fmt: skip


def _stair(
    recording: Recording, machine: Machine, base: Rows, along: np.ndarray, which: np.ndarray
) -> Rows | None:
    """A set-up of a step diagonal; None where its readings are of no stair."""
    if not step_diagonals.is_diagonal(along):
        return None
    aside = step_diagonals.aside(nominal_tip(machine, base.q[:, which], base.tool), along)
    if not step_diagonals.is_stepped(aside):
        return None
    leans = len(step_diagonals.across(aside))
    return _picked(
        base, which, kind="stair", value=recording.reading[which], along=along, aside=aside,
        start=np.zeros(1 + leans), loose=step_diagonals.mirror_weights(recording, leans),
    )  # fmt: skip


def _aligned(value: np.ndarray, nominal: np.ndarray) -> np.ndarray:
    """(6,) rad and mm: the turn and shift that bring a cloud (3, N) nearest to its nominal places
    (Kabsch)."""
    a, b = value.mean(axis=1), nominal.mean(axis=1)
    # Kabsch: with U S V' of the correlation the best turn is U V'; where that is a mirror image
    # (its determinant is -1) the direction of the smallest singular value is turned round.
    u, _, v = np.linalg.svd((nominal - b[:, None]) @ (value - a[:, None]).T)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    from scipy.spatial.transform import Rotation

    return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), b - turn @ a])
