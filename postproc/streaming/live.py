"""The controller's own zeros, tool length, modal state and place, told to the filter, so that the
map stands where the part stands."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from postproc import offsets
from postproc.errors import Notice, UsageError
from postproc.filter import Filter
from postproc.nc.codes import code_number
from postproc.streaming.events import Status
from postproc.streaming.protocols import Controller
from postproc.units import TICKS_PER_MM

SAME_MM = 0.0006  # controllers report whole um
TOOL = "G43.1"
CONTROLLER_AXES = "XYZABCUVW"  # in the order in which GRBL's kin report them
MOTIONS = frozenset({"G0", "G1", "G2", "G3", "G38.2", "G38.3", "G38.4", "G38.5", "G80"})
STATES = ("units", "distance", "plane", "feed mode", "work offset", "motion")


@dataclass(frozen=True)
class Live:
    """work: offset name to axis to mm; length: axis to mm, the tool length in force; place: axis to
    mm, where it stands in machine coordinates, where that is known; modal: G words in force."""

    work: dict[str, dict[str, float]]
    length: dict[str, float]
    place: dict[str, float]
    modal: tuple[str, ...]
    notices: tuple[str, ...] = ()


def read(controller: Controller, status: Status | None, letters: tuple[str, ...]) -> Live:
    """What the controller said, for a machine with these axes. Raises UsageError for an answer that
    can not be read."""
    work: dict[str, dict[str, float]] = {}
    length: dict[str, float] = {}
    notices: list[str] = []
    if controller.offsets:
        text = "\n".join(controller.offsets).encode()
        found = offsets.read(
            text, "the controller's offsets", format="grbl", inch=controller.inches
        ).of(letters)
        work = dict(found.work)
        if not any(work.get("G92", {}).values()):
            work.pop("G92", None)
        length = {axis: v for axis, v in found.tools.get(TOOL, {}).items() if axis in letters}
        notices = found.notices
    said = getattr(status, "place", None) or ()
    place = {x: v for x, v in zip(CONTROLLER_AXES, said, strict=False) if x in letters}
    return Live(
        work, length, place, tuple(w for w in controller.modal if w.startswith("G")), tuple(notices)
    )


def conflicts(live: Live, stated: dict[str, dict[str, float]], start: dict[str, float]) -> None:
    """Raises UsageError where the user states other zeros or another start than the controller
    reports."""
    for name, mine in stated.items():
        theirs = live.work.get(name)
        if theirs is None:
            continue
        for axis, value in mine.items():
            if axis in theirs and abs(theirs[axis] - value) > SAME_MM:
                raise UsageError(
                    f"{name} is stated with {axis} = {value:g} mm, and the controller has {axis} ="
                    f" {theirs[axis]:g} mm",
                    "leave it out: gcomp stream takes it from the controller; or set the"
                    " controller's to this",
                )
    for axis, value in start.items():
        if axis in live.place and abs(live.place[axis] - value) > SAME_MM:
            raise UsageError(
                f"--start says {axis} = {value:g} mm, and the controller stands at {axis} ="
                f" {live.place[axis]:g} mm",
                "leave it out: gcomp stream takes it from the controller",
            )


def merged(
    live: Live, assumed: dict[str, dict[str, float]]
) -> tuple[dict[str, dict[str, float]], list[Notice]]:
    """The offsets to use, and what to tell where the machine's file assumed others."""
    notices = []
    for name, mine in assumed.items():
        theirs = live.work.get(name)
        if theirs and any(abs(theirs.get(axis, 0.0) - v) > SAME_MM for axis, v in mine.items()):
            said = " ".join(f"{axis}{v:g}" for axis, v in theirs.items())
            notices.append(
                Notice(
                    f"live {name}",
                    f"{name} is taken from the controller ({said}), not from the machine's file",
                )
            )
    return {**assumed, **live.work}, notices


def stand(filter_: Filter, live: Live) -> None:
    """Put the filter, which has read nothing yet, into the controller's state."""
    setup, dialect = filter_.setup, filter_.dialect
    letters = setup.axes
    modal = filter_.modal
    codes = dict(modal.codes)
    for word in live.modal:
        number = code_number(word)
        code = dialect.by_number.get(number)
        if code is not None and code.group in STATES:
            codes[code.group] = number
    position, known = modal.position.copy(), modal.known.copy()
    for i, x in enumerate(letters):
        if x in live.place:
            position[i], known[i] = round(live.place[x] * TICKS_PER_MM), True
    frame = modal.frame
    if frame is not None and any(live.length.values()):
        length = np.array(
            [round(live.length.get(x, 0.0) * TICKS_PER_MM) for x in letters], np.int64
        )
        frame = replace(frame, length=length)
    # An axis that the first blocks do not name stays where the controller has it: that is its last
    # command.
    filter_.carry = replace(filter_.carry, issued=np.where(known, position, filter_.carry.issued))
    filter_.modal = replace(modal, codes=codes, position=position, known=known, frame=frame)
