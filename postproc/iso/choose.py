"""Which test of the ISO 230 series each recording is for, and all results of a set of
recordings."""

from __future__ import annotations

from collections.abc import Sequence

from postproc.errors import Place
from postproc.iso import IsoError, Options, Result, ballbar, drift, targets
from postproc.iso.assign import Motion, motions
from postproc.recordings import Recording

VOLUME = ("points", "lengths", "sphere")


def _not_evaluated(recording: Recording) -> str:
    hint = "; gcomp volumetric makes a map of it" if recording.kind in VOLUME else ""
    return (
        f"{recording.file}: no test of the ISO 230 series is evaluated from {recording.kind}{hint}"
    )


def results(recordings: Sequence[Recording], options: Options) -> tuple[list[Result], list[str]]:
    """Every result, and what was left out. Raises IsoError where a recording is not what it looks
    like, or none is left."""
    out: list[Result] = []
    left: list[str] = []
    of_test: dict[str, list[tuple[Motion, Result]]] = {}
    resting: list[drift.Drift] = []
    for recording in recordings:
        left += [f"{recording.file}:{f.line}: left out: {f.message}" for f in recording.faults]
        if not len(recording):
            raise IsoError("there are no rows", "", Place(recording.file, 1))
        if recording.kind == "ballbar":
            out.append(ballbar.result_of(recording, options))
        # before motions(), which refuses targets of which none moves
        elif recording.kind == "targets" and drift.rests(recording):
            one, result = drift.result_of(recording, options)
            resting.append(one)
            out.append(result)
        elif recording.kind == "targets":
            for motion in motions(recording):
                result = targets.result_of(motion, options)
                out.append(result)
                of_test.setdefault(motion.test, []).append((motion, result))
        else:
            left.append(_not_evaluated(recording))
    if not out:
        raise IsoError("there is nothing to evaluate", "\n    ".join(left))
    rest = (
        targets.diagonals_of(of_test.get("diagonal", []))
        + targets.squareness_of(of_test.get("straightness", []), options)
        + drift.tilts_of(resting, options)
    )
    return out + rest, left
