"""Which test of the ISO 230 series each recording is for, and all results of a set of
recordings."""

from __future__ import annotations

from collections.abc import Sequence

from postproc.errors import Place
from postproc.iso import IsoError, Options, Result, ballbar, drift, targets
from postproc.iso.assign import Motion, motions
from postproc.recordings import Recording

VOLUME = ("points", "lengths", "sphere")


def results(recordings: Sequence[Recording], options: Options) -> tuple[list[Result], list[str]]:
    """Every result, and what was left out. Raises IsoError where a recording is not what it looks
    like, or none is left."""
    out: list[Result] = []
    left: list[str] = []
    straight: list[tuple[Motion, Result]] = []
    across: list[tuple[Motion, Result]] = []
    resting: list[drift.Drift] = []
    for recording in recordings:
        for fault in recording.faults:
            left.append(f"{recording.file}:{fault.line}: left out: {fault.message}")
        if not len(recording):
            raise IsoError("there are no rows", "", Place(recording.file, 1))
        if recording.kind == "ballbar":
            out.append(ballbar.result_of(recording, options))
        elif recording.kind == "targets" and drift.rests(recording):
            one, result = drift.result_of(recording, options)
            resting.append(one)
            out.append(result)
        elif recording.kind == "targets":
            for motion in motions(recording):
                result = targets.result_of(motion, options)
                out.append(result)
                if motion.test == "straightness":
                    straight.append((motion, result))
                elif motion.test == "diagonal":
                    across.append((motion, result))
        else:
            hint = "; gcomp volumetric makes a map of it" if recording.kind in VOLUME else ""
            left.append(
                f"{recording.file}: no test of the ISO 230 series is evaluated from"
                f" {recording.kind}{hint}"
            )
    if not out:
        raise IsoError("there is nothing to evaluate", "\n    ".join(left))
    rest = (
        targets.diagonals_of(across)
        + targets.squareness_of(straight, options)
        + drift.tilts_of(resting, options)
    )
    return out + rest, left
