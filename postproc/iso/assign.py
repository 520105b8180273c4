"""Which motion a recording of targets shows: one axis, several times perhaps at other places, or a
diagonal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.errors import Place
from postproc.iso import IsoError, diagonals
from postproc.iso.positioning import SAME, targets_of
from postproc.recordings import Recording

LINEAR, ROTARY = "XYZ", "ABC"
ALONG, ACROSS = (
    0.999,
    0.045,
)  # cosine of the angle between motion and reading: along it, or across it within 2.6 degrees


@dataclass(frozen=True)
class Motion:
    """Readings along one straight motion. test: positioning, rotary, straightness, angle or
    diagonal; subject: EXX, PPP;
    axes: those that move; unit: vector of the motion; at: mm, where the others stood; position (N,)
    along the motion, mm or degrees; approach, reading, run (N,); why: how it was told from the
    data."""

    test: str
    subject: str
    axes: str
    unit: dict[str, float]
    at: dict[str, float]
    position: np.ndarray
    approach: np.ndarray
    reading: np.ndarray
    run: np.ndarray
    recording: Recording
    why: str
    notices: tuple[str, ...] = ()

    @property
    def across(self) -> str:
        """The axis along which a straightness is read."""
        return self.subject[1]


def motions(recording: Recording) -> list[Motion]:
    """The motions in a recording of targets. Raises IsoError with the line where they can not be
    told apart."""
    moved = [x for x in recording.axes if np.ptp(recording.position(x)) > SAME]
    if not moved:
        raise IsoError(
            "no axis moves: all positions are the same",
            "a test along an axis needs two targets at least",
            Place(recording.file, int(recording.lines[0])),
        )
    if len(moved) == 1:
        #     moves          positions                        is
        #     one axis       a line along it                  that axis
        #     several        one straight line                a diagonal (linear axes alone)
        #     several        lines of one axis, side by side  that axis, once for each place
        return [_along_axis(recording, moved[0], {})]
    linear = all(x in LINEAR for x in moved)
    if linear and (direction := _collinear(recording, moved)) is not None:
        return [_along_diagonal(recording, direction)]
    return _at_places(recording, moved)


def _at_places(recording: Recording, moved: list[str]) -> list[Motion]:
    """Motions of one axis, at several places of the others. Raises IsoError."""
    letter = _moving_axis(recording, moved)
    others = [x for x in moved if x != letter]
    places = [targets_of(recording.position(x)) for x in others]
    keys = np.stack([index for _, index in places])
    out = []
    for key in np.unique(keys, axis=1).T:
        rows = np.flatnonzero((keys == key[:, None]).all(axis=0))
        at = {x: float(places[i][0][key[i]]) for i, x in enumerate(others)}
        part = recording.pick(rows)
        if np.ptp(part.position(letter)) <= SAME:
            where = ", ".join(f"{x} {v:g}" for x, v in at.items())
            raise IsoError(
                f"at {where} there is one target of {letter} only: this is neither an axis at"
                " several places nor a diagonal",
                "one file per line of targets; on a diagonal all positions lie on one straight"
                " line",
                Place(recording.file, int(recording.lines[rows[0]])),
            )
        out.append(_along_axis(part, letter, at))
    return out


def _collinear(recording: Recording, moved: list[str]) -> dict[str, float] | None:
    """The direction of the line that all positions lie on, None where they do not lie on one."""
    points = np.stack([recording.position(x) for x in moved], axis=1)
    centred = points - points.mean(axis=0)
    # The first right singular vector is the direction in which the points spread most. All must lie
    # by it within two of the distances that count as one target, and every axis must have a part in
    # it: one that stands still makes no diagonal.
    direction = np.linalg.svd(centred, full_matrices=False)[2][0]
    away = centred - np.outer(centred @ direction, direction)
    if np.abs(away).max() > 2 * SAME or np.abs(direction).min() < 1e-3:
        return None
    return dict(zip(moved, map(float, direction), strict=True))


def _moving_axis(recording: Recording, moved: list[str]) -> str:
    """The axis that moves alone in most steps from one reading to the next."""
    steps = np.stack([np.abs(np.diff(recording.position(x))) > SAME for x in moved])
    #     Z ->->->->->       In lines of Z at several X most steps move Z alone, and X moves alone
    #               X |      only from line to line.
    #     Z <-<-<-<-<-
    alone = steps & (steps.sum(axis=0) == 1)
    counts = alone.sum(axis=1)
    if counts.max() == 0 or (counts == counts.max()).sum() > 1:
        raise IsoError(
            f"{' and '.join(moved)} move, and neither alone nor along one straight line",
            "one file per line of targets",
            Place(recording.file, int(recording.lines[0])),
        )
    return moved[int(np.argmax(counts))]


def _along_axis(recording: Recording, letter: str, at: dict[str, float]) -> Motion:
    stood = {x: float(recording.position(x).mean()) for x in recording.axes if x != letter} | at
    sensitive = {x: v for x, v in recording.sensitive.items() if abs(v) > 1e-9}
    run = recording.columns.get("run", np.ones(len(recording)))
    test, subject, sign, why = _kind(recording, letter, sensitive)
    approach = _approach(recording, [letter], {letter: 1.0})
    turned = (
        ("readings were taken towards - of the axis: their sign is turned",) if sign < 0 else ()
    )
    return Motion(
        test, subject, letter, {letter: 1.0}, stood, recording.position(letter), approach,
        sign * recording.reading, run, recording, why, (*turned, *_left_out(recording, approach)),
    )  # fmt: skip


def _of_angle(
    recording: Recording, letter: str, largest: str, cosine: float
) -> tuple[str, str, float, str]:
    """As `_kind`, of an angle; cosine: of its direction with the axis about which it is read."""
    # sensitive = { Y = 1.0 } of an angle: about Y, which is B
    about = ROTARY[LINEAR.index(largest)] if largest in LINEAR else largest
    if abs(cosine) < ALONG:
        raise IsoError(
            f"the angle is read about no axis: sensitive = {recording.sensitive}",
            "one of X, Y, Z (or A, B, C)",
            Place(recording.file, 1),
        )
    sign, moves = float(np.sign(cosine)), f"{letter} moves"
    if letter in ROTARY and about == letter:
        return "rotary", f"E{letter}{letter}", sign, f"{moves}, its own angle is read"
    return "angle", f"E{about}{letter}", sign, f"{moves}, the angle about {largest} is read"


def _kind(
    recording: Recording, letter: str, sensitive: dict[str, float]
) -> tuple[str, str, float, str]:
    """Test, component, sign of the readings towards + of the axis, and why."""
    largest = max(sensitive, key=lambda x: abs(sensitive[x]))
    cosine = sensitive.get(letter, 0.0)
    place = Place(recording.file, 1)
    moves = f"{letter} moves"
    if recording.quantity == "angle":
        return _of_angle(recording, letter, largest, sensitive[largest])
    if letter in ROTARY:
        raise IsoError(
            f"the rotary axis {letter} moves, but no angle is read",
            'quantity = "angle" for positions of rotary axes',
            place,
        )
    if recording.quantity == "displacement" and abs(cosine) > ALONG:
        return (
            "positioning",
            f"E{letter}{letter}",
            float(np.sign(cosine)),
            f"{moves}, displacement is read along it",
        )
    if abs(cosine) < ACROSS and abs(sensitive[largest]) > ALONG and largest in LINEAR:
        why = f"{moves}, {recording.quantity} is read across it, along {largest}"
        return "straightness", f"E{largest}{letter}", float(np.sign(sensitive[largest])), why
    raise IsoError(
        f"{letter} moves and {recording.quantity} is read along {_vector(recording.sensitive)}:"
        " that is neither along the motion nor across it along one axis",
        "is `sensitive` the direction in which this was read?",
        place,
    )


def _along_diagonal(recording: Recording, direction: dict[str, float]) -> Motion:
    name, unit = diagonals.orient(direction)
    axes = "".join(sorted(unit))
    cosine = sum(recording.sensitive.get(x, 0.0) * v for x, v in unit.items())
    if recording.quantity != "displacement" or abs(cosine) < ALONG:
        raise IsoError(
            f"{' and '.join(axes)} move along a diagonal, but {recording.quantity} is read along"
            f" {_vector(recording.sensitive)}",
            "a diagonal test reads the displacement along the diagonal (ISO 230-6)",
            Place(recording.file, 1),
        )
    position = np.sum([recording.position(x) * v for x, v in unit.items()], axis=0)
    approach = _approach(recording, list(axes), unit)
    stood = {x: float(recording.position(x).mean()) for x in recording.axes if x not in axes}
    turned = (
        ("readings were taken towards the other end: their sign is turned",) if cosine < 0 else ()
    )
    shown = " ".join(f"{x}{unit[x]:+.3f}" for x in axes)
    return Motion(
        # positions along a diagonal count from its first target, since its axes have no common zero
        "diagonal", name, axes, unit, stood, position - position.min(), approach,
        np.sign(cosine) * recording.reading, recording.columns.get("run", np.ones(len(recording))),
        recording, f"{', '.join(axes)} move together along {shown}, displacement is read along it",
        (*turned, *_left_out(recording, approach)),
    )  # fmt: skip


def _approach(recording: Recording, letters: list[str], unit: dict[str, float]) -> np.ndarray:
    """(N,) direction along the motion; 0 where an axis has none or they contradict each other.
    Raises IsoError if it is 0 everywhere."""
    # On NPP X goes towards - while the diagonal goes towards +: its approach counts turned round.
    # Axes that contradict each other have come from nowhere along the diagonal.
    signs = np.stack([recording.approach(x) * np.sign(unit[x]) for x in letters])
    same = np.where((signs == signs[0]).all(axis=0), signs[0], 0.0)
    if not same.any():
        names = ", ".join(f"approach_{x}" for x in letters)
        raise IsoError(
            f"the direction of approach is not recorded: {names}",
            "without it neither direction nor reversal can be evaluated",
            Place(recording.file, int(recording.lines[0])),
        )
    return same


def _left_out(recording: Recording, approach: np.ndarray) -> tuple[str, ...]:
    gone = np.flatnonzero(approach == 0)
    if not len(gone):
        return ()
    return (
        (
            f"{len(gone)} readings without a direction of approach are left out, the first in line"
            f" {int(recording.lines[gone[0]])}"
        ),
    )


def _vector(vector: dict[str, float]) -> str:
    return " ".join(f"{x}{v:+.3f}" for x, v in vector.items() if v) or "nothing"
