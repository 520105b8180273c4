"""What was read, as rows of a residual: points of a tracker, lengths from stations, displacements
along lines, angles, spheres.

Each kind has nuisances of its own, which belong to the set-up: six of a free frame (a tracker
stands where it stands), three and a dead path of a station, a zero of every line, a zero and a
slope of every straightness, the place of a sphere on its table.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from postproc.errors import Place
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.poses import tips
from postproc.machine.rotary import rotation
from postproc.recordings import Recording, RecordingError
from postproc.units import UM, URAD
from postproc.volumetric import VolumetricError, stairs
from postproc.volumetric.unknowns import Unknowns

SAME = 1e-3  # mm
# mm, standard deviation of a station's stated place: a ball on a table is set with a rule
STATED = 1.0
FITS = 0.1  # mm: lengths from a station fit its place so well where it is the right one
PLACES = ("mx_mm", "my_mm", "mz_mm")
SHIFTS = ("dx_um", "dy_um", "dz_um")


@dataclass(frozen=True)
class Rows:
    """N readings of one set-up. kind: cloud, shift, length, line, stair, straightness, angle,
    sphere; q, approach (A, N); value: mm, of clouds and shifts (3, N), else (N,); u: mm or rad,
    nan: not stated; tool (3,) mm; along (3,): direction of lines; letter, row: of angles; aside (3,
    N) mm: of stairs, from their line; start: nuisances to begin with; loose: 1/mm, by how much each
    is held there, nothing: not at all; name: of the file."""

    kind: str
    q: np.ndarray
    approach: np.ndarray
    value: np.ndarray
    u: float
    tool: np.ndarray
    start: np.ndarray
    name: str
    along: np.ndarray
    letter: str = ""
    row: int = 0
    aside: np.ndarray = field(default_factory=lambda: np.zeros((3, 0)))
    loose: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __len__(self) -> int:
        return self.value.size

    def residual(
        self, off: np.ndarray, own: np.ndarray, nominal: np.ndarray, angle: np.ndarray
    ) -> np.ndarray:
        """(R,) mm or rad: model less reading. off (3, N) mm at the tip; own: nuisances; nominal (3,
        N) mm: of the tip; angle (N,) rad."""
        if self.kind == "cloud":
            return (nominal + off - _turn(own[:3]) @ self.value - own[3:, None]).ravel()
        if self.kind == "shift":
            return (off + own[:, None] - self.value).ravel()
        if self.kind == "sphere":
            return (nominal + off - own[:, None]).ravel()
        if self.kind == "length":
            return np.linalg.norm(nominal + off - own[:3, None], axis=0) + own[3] - self.value
        if self.kind == "angle":
            return angle + own[0] - self.value
        return self.along @ off + own[0] - self.value + own[1:] @ self._more

    def slopes(
        self,
        columns: np.ndarray,
        off: np.ndarray,
        own: np.ndarray,
        nominal: np.ndarray,
        angles: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(R, P) by the unknowns, whose columns (P, 3, N) act at the tip, and (R, M) by the
        nuisances."""
        n = self.q.shape[1]
        if self.kind in ("cloud", "shift", "sphere"):
            by = columns.reshape(len(columns), -1).T
            if self.kind == "cloud":
                each = 1e-7
                turned = [
                    (_turn(own[:3] + each * e) - _turn(own[:3] - each * e))
                    @ self.value
                    / (2 * each)
                    for e in np.eye(3)
                ]
                more = [-t.ravel() for t in turned] + [-np.repeat(e, n) for e in np.eye(3)]
                return by, np.array(more).T
            sign = 1.0 if self.kind == "shift" else -1.0
            return by, sign * np.array([np.repeat(e, n) for e in np.eye(3)]).T
        if self.kind == "length":
            away = nominal + off - own[:3, None]
            way = away / np.linalg.norm(away, axis=0)
            return np.einsum("pin,in->np", columns, way), np.vstack([-way, np.ones(n)]).T
        if self.kind == "angle":
            return angles.T, np.ones((n, 1))
        by = np.einsum("pin,i->np", columns, self.along)
        return by, np.vstack([np.ones(n), self._more]).T

    @property
    def _more(self) -> np.ndarray:
        """(M, N): what the set-up adds by its own numbers, beyond its zero: a slope of a
        straightness, mm per turn of (-1 to 1); of a stair the motions aside, mm, which a mirror's
        lean is times."""
        if self.kind == "straightness":
            return self._way[None]
        if self.kind == "stair":
            found: np.ndarray = stairs.across(self.aside) @ self.aside
            return found
        return np.zeros((0, self.q.shape[1]))

    @property
    def _way(self) -> np.ndarray:
        """(N,) from -1 to 1 along the motion of a straightness."""
        moved = self.q[int(np.argmax(np.ptp(self.q, axis=1)))]
        found: np.ndarray = 2 * (moved - moved.mean()) / max(float(np.ptp(moved)), SAME)
        return found


def nominal_tip(machine: Machine, q: np.ndarray, tool: np.ndarray) -> np.ndarray:
    """(3, N) mm: where the tip is without errors, in the part where rotary axes turn it."""
    m = replace(machine, tool=tool)
    if machine.chain.rotary:
        return tips(m, q)
    slides = np.array(
        [q[m.letters.index(x)] if x in m.letters else np.zeros(q.shape[1]) for x in XYZ]
    )
    return slides + tool[:, None]


def to_machine(machine: Machine, q: np.ndarray) -> np.ndarray:
    """(3, 3, N): directions of the part to those of the machine, where rotary axes carry the
    part."""
    turn = np.repeat(np.eye(3)[:, :, None], q.shape[1], axis=2)
    for x in machine.chain.rotary:
        if machine.chain.side(x) == "workpiece":
            turn = np.einsum(
                "ijn,jkn->ikn", turn, rotation(x, np.radians(q[machine.letters.index(x)]))
            )
    return turn.transpose(1, 0, 2)


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
    if recording.kind == "targets":
        return _lines(recording, machine, base)
    raise VolumetricError(
        f"a recording of {recording.kind} tells nothing of the volume here",
        "kinds: points, lengths, sphere, targets",
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


def _picked(base: Rows, which: np.ndarray, **more) -> Rows:
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
        if len(which) < 5:
            raise VolumetricError(
                "a station needs five lengths at least: its own place and its dead path are four"
                " numbers",
                "",
                Place(recording.file, 1),
            )
        nominal = nominal_tip(machine, base.q[:, which], base.tool)
        said = _said(recording, which)
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
    """(4,) mm: place and dead path of a station: as said, else of the circle through the lengths
    (squares are linear in it)."""
    if said is not None:
        return np.append(
            said, float((value - np.linalg.norm(nominal - said[:, None], axis=0)).mean())
        )
    from scipy.optimize import least_squares

    middle, far = nominal.mean(axis=1), float(value.mean())
    best = None
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


def _lines(recording: Recording, machine: Machine, base: Rows) -> list[Rows]:
    moved = [x for x in XYZ if x in recording.axes and np.ptp(recording.position(x)) > SAME]
    along = np.array([recording.sensitive.get(x, 0.0) for x in XYZ])
    reading = recording.reading
    if recording.quantity == "angle":
        rotation = next(
            (r for r in XYZ + ROTARY if abs(recording.sensitive.get(r, 0.0)) > 0.999), ""
        )
        if len(moved) != 1 or not rotation:
            raise VolumetricError(
                "angles are read while one axis moves, about one axis", "", Place(recording.file, 1)
            )
        row = 3 + (ROTARY.index(rotation) if rotation in ROTARY else XYZ.index(rotation))
        sign = float(np.sign(recording.sensitive[rotation]))
        return [
            _picked(
                base,
                which,
                kind="angle",
                value=sign * reading[which],
                start=np.zeros(1),
                letter=moved[0],
                row=row,
            )
            for which in _parts(recording, "setup")
        ]
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
        base,
        which,
        kind="straightness" if across else "line",
        value=recording.reading[which],
        start=np.zeros(2 if across else 1),
        along=along,
    )


def _stair(
    recording: Recording, machine: Machine, base: Rows, along: np.ndarray, which: np.ndarray
) -> Rows | None:
    """A set-up of a step diagonal; None where its readings are of no stair."""
    if not stairs.may_be(along):
        return None
    aside = stairs.aside(nominal_tip(machine, base.q[:, which], base.tool), along)
    if not stairs.is_one(aside):
        return None
    leans = len(stairs.across(aside))
    return _picked(
        base,
        which,
        kind="stair",
        value=recording.reading[which],
        along=along,
        aside=aside,
        start=np.zeros(1 + leans),
        loose=stairs.held(recording, leans),
    )


def _aligned(value: np.ndarray, nominal: np.ndarray) -> np.ndarray:
    """(6,) rad and mm: the turn and shift that bring a cloud (3, N) nearest to its nominal places
    (Kabsch)."""
    a, b = value.mean(axis=1), nominal.mean(axis=1)
    u, _, v = np.linalg.svd((nominal - b[:, None]) @ (value - a[:, None]).T)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    from scipy.spatial.transform import Rotation

    return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), b - turn @ a])


def _turn(vector: np.ndarray) -> np.ndarray:
    """(3, 3) of a rotation vector (3,) rad (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0:
        return np.eye(3)
    k = vector / angle
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    found: np.ndarray = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return found


def angle_columns(unknowns: Unknowns, rows: Rows) -> np.ndarray:
    """(P, N) of angles, nothing of other kinds."""
    if rows.kind != "angle":
        return np.zeros((unknowns.number, 0))
    return unknowns.of_axis(rows.letter, rows.row, rows.q)


def unit_of(rows: Rows) -> float:
    """mm or rad of one unit of these readings, as told to a person."""
    return URAD if rows.kind == "angle" else UM
