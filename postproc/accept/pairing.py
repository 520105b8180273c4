"""Which recording after belongs to which before: the same motion with the same targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from postproc.accept import AcceptError
from postproc.errors import Place
from postproc.iso.assign import Motion, motions
from postproc.iso.targets import subject
from postproc.recordings import Recording

SAME = 1e-3  # mm: targets that differ by less are the same, written with fewer digits
ALIKE = 0.9999  # cosine of the angle between the directions of two readings
STOOD = 0.1  # mm: axes at rest that differ by less stood at one place
NEAR = 0.6  # mm: a corrected target lies no farther from its nominal one (max_correction 0.5 mm)


def split(
    recordings: Sequence[Recording], after: Sequence[Recording]
) -> tuple[list[Recording], list[Recording]]:
    """Before and after. Without a list of its own, what comes second of a motion is after.

    Raises AcceptError where that can not be told, or a file's head says otherwise (`compensated`).
    """
    first: list[Recording] = list(recordings)
    second: list[Recording] = list(after)
    if not second:
        # as a shell lists them: x_before z_before x_after z_after
        half = len(first) // 2
        if len(first) % 2:
            raise AcceptError(
                f"{len(first)} recordings: which were made before and which after?",
                "all of before, then as many of after in the same order; or --after FILE...",
            )
        first, second = first[:half], first[half:]
    for group, said in ((first, False), (second, True)):
        for one in group:
            if one.head.get("compensated", said) is not said:
                raise AcceptError(
                    f"{one.file} was named as measured {'after' if said else 'before'}"
                    f" compensation, and its head says compensated = {str(not said).lower()}",
                    "name what was measured before first",
                    Place(one.file, 1),
                )
    return first, second


def pairs(
    before: Sequence[Recording], after: Sequence[Recording], commanded: bool
) -> list[tuple[Motion, Motion]]:
    """Motions before and after, in the order of before. Raises AcceptError for one without a
    partner."""
    old = [m for r in before for m in motions(r)]
    points = [(r, _points(r)) for r in before]
    new = [m for r in after for m in motions(_nominal(r, points, commanded))]
    found = [(motion, _partner(motion, new)) for motion in old]
    partners = {id(partner) for _, partner in found}
    for motion in new:
        if id(motion) not in partners:
            raise AcceptError(
                f"{subject(motion)} of {motion.recording.file} was not measured before"
            )
    return found


def _partner(motion: Motion, new: list[Motion]) -> Motion:
    """The one of `new` that is the same motion."""
    # by what was measured, not by the files' order: a person may name them as they come
    same = [m for m in new if _same(m, motion)]
    if len(same) != 1:
        files = ", ".join(m.recording.file for m in same)
        raise AcceptError(
            f"{subject(motion)} of {motion.recording.file} was measured {len(same)} times"
            f" after: {files or 'among ' + ', '.join(subject(m) for m in new)}",
            "one recording of a component before, and one after",
        )
    return same[0]


def _same(one: Motion, other: Motion) -> bool:
    """Whether both are of one test along one line."""
    if (one.test, one.subject, one.axes) != (other.test, other.subject, other.axes):
        return False
    # where the others stood is read off a display, and a correction moves them by um
    return one.at.keys() == other.at.keys() and all(
        abs(one.at[x] - other.at[x]) < STOOD for x in one.at
    )


def _alike(one: Recording, other: Recording) -> bool:
    """Whether both were read along the same direction; a corrected diagonal leans by its
    correction."""
    return sum(v * other.sensitive.get(x, 0.0) for x, v in one.sensitive.items()) > ALIKE


def _vector(recording: Recording) -> str:
    return " ".join(f"{x}{v:+.4f}" for x, v in recording.sensitive.items() if v)


def _positions(recording: Recording) -> np.ndarray:
    """(N, A) mm: places of a recording's readings."""
    return np.stack([recording.position(x) for x in recording.axes], axis=1)


def _points(recording: Recording) -> np.ndarray:
    """(K, A) mm: places of a recording, each once."""
    return np.unique(_positions(recording), axis=0)


def _nominal(
    recording: Recording, before: list[tuple[Recording, np.ndarray]], commanded: bool
) -> Recording:
    """The recording on the targets of before: as it is, or from the corrected ones that its program
    commanded.

    Raises AcceptError where its targets are others.
    """
    own = _positions(recording)
    read = (recording.axes, recording.quantity)
    alike = [(r, p) for r, p in before if (r.axes, r.quantity) == read]
    nearest = _nearest(recording, own, alike)
    against = commanded or recording.head.get("against") == "commanded"
    if nearest is None:
        if alike and against:
            raise AcceptError(
                f"its readings are along {_vector(recording)}, and those before along"
                f" {_vector(alike[0][0])}",
                "measure along the same direction; of a corrected program gcomp simulate --nominal"
                " FILE does",
                Place(recording.file, 1),
            )
        return recording  # another quantity: pairs() names it
    source, targets = nearest
    far = float(np.abs(own - targets).max())
    if far <= SAME:
        return recording
    if far > NEAR or not against:
        raise _elsewhere(recording, np.abs(own - targets))
    return _shifted(recording, own, targets, source)


def _elsewhere(recording: Recording, off: np.ndarray) -> AcceptError:
    """What is said of targets that are `off`, (N, axes) mm, those of before."""
    far = float(off.max())
    say = (
        "readings are wanted against the nominal targets, those of before; where they are"
        " against what the corrected program commands, say --commanded"
    )
    return AcceptError(
        f"its target lies {far:.4g} mm beside the next one of before",
        say if far <= NEAR else "measure at the same targets as before",
        Place(recording.file, int(recording.lines[int(off.max(axis=1).argmax())])),
    )


def _nearest(
    recording: Recording, own: np.ndarray, before: list[tuple[Recording, np.ndarray]]
) -> tuple[Recording, np.ndarray] | None:
    """The recording along the same direction whose targets lie nearest, and (R, A) mm its target
    next to each of `own`."""
    from scipy.spatial import cKDTree  # not all pairs: of fine records they are billions

    # the nearest of several diagonals or lines with the same axes: by direction first, then by
    # targets
    found = []
    for other, points in before:
        if _alike(recording, other):
            found.append((other, points[cKDTree(points).query(own, p=np.inf)[1]]))
    return min(found, key=lambda one: float(np.abs(own - one[1]).max()), default=None)


def _shifted(
    recording: Recording, own: np.ndarray, targets: np.ndarray, source: Recording
) -> Recording:
    """Readings against `own` targets as readings against those of `source`, (R, A) mm."""
    columns = dict(recording.columns)
    if recording.quantity != "angle":
        #    nominal target  T      reading against the corrected command C = T + c:  actual - C
        #    against T:      actual - T = reading + (C - T)
        shift = own - targets
        along = sum(
            recording.sensitive.get(x, 0.0) * shift[:, i] for i, x in enumerate(recording.axes)
        )
        # a linear reading gets the shift's share along it; an angle does not change with the target
        columns["reading_um"] = columns["reading_um"] + along / recording.unit
    columns |= {
        f"{x}_{'mm' if x in 'XYZ' else 'deg'}": targets[:, i] for i, x in enumerate(recording.axes)
    }
    head = recording.head | {"sensitive": dict(source.sensitive)}
    return replace(recording, head=head, columns=columns)
