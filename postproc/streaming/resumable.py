"""Whether a job can begin with a line of a program: what must not be in force there."""

from __future__ import annotations

import re

from postproc.errors import Place, ProgramError
from postproc.filter import Filter
from postproc.nc.state import NONE
from postproc.streaming.restart import COMMENT, MOVES, PRINTER, kind_of

FIRST_CYCLE = 730
MOTION_CODE = re.compile(rb"G0*[0-3](?![0-9.])", re.IGNORECASE)


def _is_shifted(filter_: Filter) -> bool:
    """Whether the program has moved its zero by where the machine stood."""
    frame = filter_.modal.frame
    if frame is None:
        return False
    slides = [i for i, x in enumerate(filter_.setup.axes) if x not in filter_.dialect.carried]
    # the filament's G92 E0 shifts no slide
    preset = frame.preset_on and frame.preset[slides].any()
    return bool(preset or frame.local.any() or frame.trans.any())


def _is_beside(filter_: Filter) -> bool:
    """Whether the path is not the programmed one, by the tool's radius."""
    modal = filter_.modal
    return modal.beside.on or modal.codes.get("cutter", NONE) in filter_.dialect.beside


def _in_cycle(filter_: Filter) -> bool:
    """Whether a canned cycle is in force."""
    motion = filter_.modal.codes.get("motion", NONE)
    return filter_.modal.cycle is not None or (motion >= FIRST_CYCLE and motion != 800)


def refuse(
    filter_: Filter, rest: bytes, line: int, what: str = "the job can not begin again here"
) -> None:
    """Raises ProgramError where a job can not safely begin with this line. `filter_` has read all
    before it."""
    modal, codes, axes = filter_.modal, filter_.modal.codes, filter_.setup.axes
    motion = codes.get("motion", NONE)
    incremental = codes.get("distance") == 910
    known = zip(axes, modal.known, strict=True)
    unknown = [x for x, is_known in known if x in "XYZ" and not is_known]
    first = next((t for t in rest.split(b"\n") if MOVES.search(COMMENT.sub(b"", t))), b"")
    earlier = "name an earlier line, before that begins"
    # Each would make the first motion another one than the program's: a state that the preamble can
    # not bring back, or a place that is counted from where the machine stood.
    for is_so, message, advice in (
        (modal.ended, "the program has ended before this line", "name an earlier line"),
        (_is_beside(filter_), "cutter radius compensation (G41, G42) is on", earlier),
        (_in_cycle(filter_), "a canned cycle is in force", earlier),
        (
            incremental and kind_of(filter_) == PRINTER,
            "G91 is in force, and this firmware counts E by it too",
            "name a line behind a G90",
        ),
        (
            unknown,
            f"where {', '.join(unknown)} stands before it is not known"
            f"{' in incremental distance (G91)' * incremental}",
            "name a line behind a block that says it",
        ),
        (
            not modal.zero_known,
            "where the program's zero lies is not known",
            "state it: --offset, --start",
        ),
        (
            _is_shifted(filter_),
            "the program has shifted its zero (G92, G52) by where the machine stood",
            earlier,
        ),
        (
            modal.offsets,
            f"the program has written offsets ({', '.join(modal.offsets)}) that may not be what the"
            " controller has now",
            earlier,
        ),
        (
            motion in (20, 30) and not MOTION_CODE.search(COMMENT.sub(b"", first)),
            "it goes on with an arc whose G2 or G3 stands in a line before",
            "name the line that has the G code",
        ),
    ):
        if is_so:
            text = rest.split(b"\n", 1)[0].decode("latin-1")
            raise ProgramError(f"{what}: {message}", advice, Place(filter_.name, line, text))
