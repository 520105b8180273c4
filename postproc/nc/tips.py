"""Tool centre point control: G43.4 of Fanuc, G234 of Haas, TRAORI, M128, and M codes of a machine
(LinuxCNC's switchkins).

From the call on, X Y Z are places of the tool tip in a frame that goes with the part; rotary words
leave the tip where it is. The length is the control's to reckon with, so words know none. Where
nothing moves at the call, the tip is where the slides have it; from then on it is followed, and
what the slides do is the machine's affair (postproc.spaces).

Sources: Fanuc A-79348E, "Tool center point control for 5-axis machining" (the frame is that of the
table as it stands at the call, parameter 19696 bit 5 = 0); LinuxCNC, src/emc/kinematics/trtfuncs.c
and docs/src/motion/switchkins.txt (the frame of the table at zero); Siemens NC Programming Manual
Job Planning, "TRAORI"; Heidenhain TNC 640, ISO programming, M128.
"""

from __future__ import annotations

import numpy as np

from postproc.nc import face
from postproc.nc.batch import AxisWords, Batch
from postproc.nc.dialects import Dialect
from postproc.nc.lengths import length_of
from postproc.nc.state import Frame, Setup, no_frame
from postproc.nc.zeros import values_of, with_known, work_columns
from postproc.records import replace
from postproc.spaces import Kinematics, Space
from postproc.units import TICKS_PER_MM

# the parts of a frame's unknowns that are about the tip and about a tilted plane
FOLLOWED, PLANE = "tip", "plane"
AROUND = "switch it off before, and on again behind"
STATE_FRAME = (
    'say which frame the control takes, in machine.toml: [tool_point] frame = "zero" (X Y Z are the'
    ' machine\'s while the table stands at zero) or "call" (as it stands there)'
)


def tip_by_length(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G43.4 H, G234 H: the length, and from here on the tip."""
    length_of(b, axis_words, word)
    tip_on(b, axis_words, word)


def _stands_unknown(word: str, unknown: list[str]) -> tuple[str, str] | None:
    """Why the frame of the table is not known; None: no axis stands at an unknown place."""
    if not unknown:
        return None
    return (
        f"{word} takes the frame of the table as it stands, and where {' '.join(unknown)} stands"
        " is not known",
        f"move {' '.join(unknown)} to an absolute position first, or say where it is: --start"
        f" {','.join(f'{x}0' for x in unknown)}",
    )


# Whole: a list of reasons in their order of precedence.
def tip_on(b: Batch, axis_words: AxisWords, word: str) -> None:
    """TRAORI, M128: from here on X Y Z are places of the tip."""
    #   frame "zero"   X Y Z are the machine's while the table stands at zero, and turn with it
    #   frame "call"   they are the machine's as the table stands at the call, and turn from there
    # With the table at zero both are the same: only then need nobody say which.
    kinematics = b.setup.kinematics
    if kinematics is None:  # no rotary axis: the tip goes as the slides do
        return
    reason = kinematics.lacking
    space: Space | None = Space()
    frame = kinematics.frame or b.dialect.tip_frame
    turned = [x for x in kinematics.carrying if _stands(b, x) != 0]
    named = [x for x in kinematics.carrying if x in values_of(b, axis_words)]
    if reason is not None:
        reason = (f"{word} holds the tool tip while rotary axes move, and {reason[0]}", reason[1])
    elif frame == "call" and named:
        reason = (
            (
                f"{word} and {' '.join(named)} in one block: the frame is that of the table as it"
                " stands at the call"
            ),
            f"write {' '.join(named)} in a block before it",
        )
    elif frame == "call" and turned:
        reason = _stands_unknown(word, [x for x in turned if _stands(b, x) is None])
        if reason is None:
            space = kinematics.space_at(b.state.position / TICKS_PER_MM)
    elif not frame and turned:
        reason = (
            (
                f"{word} while {' '.join(turned)} does not stand at zero: in which frame X Y Z"
                " count then differs"
            ),
            STATE_FRAME,
        )
    b.frame = with_known(replace(b.frame, tip=space), FOLLOWED, reason)


def tip_off(b: Batch, axis_words: AxisWords, word: str) -> None:
    """TRAFOOF, M129, and codes of the group of G43.4: X Y Z are the slides' again."""
    b.frame = with_known(replace(b.frame, tip=None), FOLLOWED)


def switched(b: Batch, axis_words: AxisWords) -> None:
    """M codes of the first block that switch the tool point on or off."""
    place = b.places.get("M")
    for k in place[b.words.block[place] == 0].tolist() if place is not None else ():
        number = int(b.words.mantissa[k])
        on = tip_codes(b.dialect, b.setup).get(number)
        if on is not None and b.words.decimals[k] == 0 and b.live[0]:
            (tip_on if on else tip_off)(b, axis_words, f"M{number}")
            if b.has_axis[0]:
                b.blame(
                    np.zeros(1, np.int64),
                    f"M{number} and a motion in one block: which comes first differs",
                    f"write M{number} in a block of its own",
                )


def tip_codes(dialect: Dialect, setup: Setup) -> dict[int, bool]:
    """M numbers that switch the tool point on (True) and off, on this control and machine."""
    return {**dialect.tip_codes, **setup.kinematics.codes} if setup.kinematics is not None else {}


def settle(b: Batch) -> None:
    """Tell the places where the axes stand in the space that is in force now; they have not
    moved."""
    old, new = b.state.frame or no_frame(len(b.rows)), b.frame
    if new is old:
        return
    if old.space != new.space or (
        new.space is not None and not np.array_equal(old.length, new.length)
    ):
        position, known = transformed(
            b.setup.kinematics, b.state.position, b.state.known, (old, new)
        )
        b.state = replace(b.state, position=position, known=known)


def transformed(
    kinematics: Kinematics | None,
    position: np.ndarray,
    known: np.ndarray,
    frames: tuple[Frame | None, Frame],
) -> tuple[np.ndarray, np.ndarray]:
    """(A,) ticks and (A,) bool: where the axes stand, told in the second frame's space instead of
    the first's; None: the slides'."""
    old, new = frames
    if new.face is not None or (old is not None and old.face is not None):
        return face.transformed(kinematics, position, known, frames)
    if (old is None or old.space is None) and new.space is None:
        return position, known
    # X Y Z alone are told anew: rotary axes have the same places in every space
    row = list(kinematics.linear) if kinematics is not None else []
    if (
        kinematics is None
        or kinematics.lacking
        or {FOLLOWED, PLANE} & set(new.unknown)
        or not known[list(kinematics.needs)].all()
    ):
        known = known.copy()
        known[row] = False
        return position, known
    none = np.zeros(len(position))
    # one pose of the machine, told in both
    ends = [
        (f.space, f.length / TICKS_PER_MM) if f is not None else (None, none) for f in (old, new)
    ]
    there = kinematics.convert(position / TICKS_PER_MM, ends[0], ends[1])
    position = position.copy()
    position[row] = np.rint(there * TICKS_PER_MM).astype(np.int64)[row]
    return position, known


def refuse_tips(b: Batch) -> None:
    """What can not be followed while X Y Z are places of the tip."""
    kinematics = b.setup.kinematics
    if b.frame.space is None or b.frame.face is not None or kinematics is None:
        return
    # A zero of a table beside that of the machine, C of G54 at 30 degrees: under "call" the frame
    # is that of the table as it stands, whatever its zero; under "zero" it would have to be known
    # which of the two zeros is meant.
    work = work_columns(b)
    shifted = [x for x in kinematics.carrying if (work[b.rows[x]] + b.frame.shift[b.rows[x]]).any()]
    frame = kinematics.frame or b.dialect.tip_frame
    if shifted and (frame != "call" or b.frame.plane is not None):
        b.blame(
            np.arange(b.n),
            f"the work offset turns {' '.join(shifted)} while the frame goes with the part: in"
            " which frame X Y Z count then differs",
            "write the offset of the rotary axes into the program's words, with zero in the offset",
        )
    b.blame(np.flatnonzero(b.machine), f"G53 while {_coordinates(b)}", AROUND)
    lost(
        b,
        np.flatnonzero(b.loses),
        f"a reference point while {_coordinates(b)}: it takes the tip along",
    )
    if len(b.presets):
        lost(b, np.zeros(1, np.int64), f"a new zero while {_coordinates(b)}")
    if b.frame.tip is not None:
        cutter = np.broadcast_to(b.held("cutter"), b.n)
        b.blame(
            np.flatnonzero((cutter >= 0) & (cutter != 400)),
            "cutter radius compensation while the tool point is on",
            "let the CAM program write the path of the tool's centre",
        )


def _coordinates(b: Batch) -> str:
    """What X Y Z are."""
    return (
        "X Y Z are"
        f" {'places of the tool tip' if b.frame.tip is not None else 'coordinates of a tilted plane'}"  # noqa: E501
    )


def lost(b: Batch, blocks: np.ndarray, message: str) -> None:
    """From the first of these blocks on the tip can not be followed, until the tool point or the
    plane is called anew."""
    if len(blocks):
        b.blame(np.arange(int(blocks[0]), b.n), message, AROUND)
        b.frame = with_known(
            b.frame, FOLLOWED if b.frame.tip is not None else PLANE, (message, AROUND)
        )


def refuse_cycles(b: Batch, motion: np.ndarray, moving: np.ndarray) -> None:
    """Holes while the tool point is on: along which line they are drilled is the control's affair.
    motion (B,): the code in force; moving (B,)."""
    if b.frame.tip is not None:
        drills = moving & b.dialect.is_hole[np.maximum(motion, 0)]
        b.blame(
            np.flatnonzero(drills),
            "a drilling cycle while the tool point is on",
            "let the CAM program write it out as G0 and G1",
        )


def first_frame(kinematics: Kinematics | None, frame: Frame) -> Frame:
    """The frame before the first block, on a machine that starts with the tool point on."""
    if kinematics is None or not kinematics.at_start:
        return frame
    return with_known(replace(frame, tip=Space()), FOLLOWED, kinematics.lacking)


def _stands(b: Batch, letter: str) -> float | None:
    """Ticks at which an axis stands, None where unknown."""
    row = b.rows[letter]
    return int(b.state.position[row]) if b.state.known[row] else None
