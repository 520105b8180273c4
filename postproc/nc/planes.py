"""Tilted planes: G68.2 of Fanuc with its Euler angles, G53.1, which turns the tool into the plane,
and G69.

X Y Z are coordinates of the plane: a place w is the place O + Rz(I) Rx(J) Rz(K) w of the work
offset's coordinates, O the words X Y Z of G68.2 (B-64484EN-2, "Tilted working plane indexing",
Euler angles: about Z, the new X, the new Z). The frame goes with the part as it lies with the
tables at zero. Once the tool stands across the plane, a tip at w is a tip in the part, and is
followed as one (tips.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from postproc.nc.batch import AxisWords, Batch
from postproc.nc.queries import lose, tell
from postproc.nc.tips import PLANE, STATE_FRAME, lost
from postproc.nc.zeros import number_of, values_of, with_known, work_columns
from postproc.records import replace
from postproc.spaces import Kinematics, Space
from postproc.units import TICKS_PER_MM

STANDS = 1e-4  # rad: closer to its normal a tool stands across the plane
TURNED = (
    "a rotary axis moves in a tilted plane without the tool point",
    "turn it before the plane is called, or let the control turn it across",
)


def plane_on(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G68.2 X Y Z I J K."""
    reason: tuple[str, str] | None = None
    if number_of(b, "P"):
        reason = (f"{word} P{number_of(b, 'P'):g} tells the plane otherwise than by Euler angles",
                  "let the CAM program write G68.2 with I J K alone")  # fmt: skip
    values = {x: value / TICKS_PER_MM for x, (value, _) in values_of(b, axis_words).items()}
    zero = np.array([values.get(x, 0.0) for x in "XYZ"])
    # about Z by I: X becomes the line in which both planes meet; about it by J: the plane tips;
    # about its normal by K: X turns within it
    turn = turned((2, 0, 2), [number_of(b, x) or 0.0 for x in "IJK"])
    tilt(b, word, turn, zero, reason)


def turned(axes: tuple[int, ...], degrees: list[float]) -> np.ndarray:
    """(3, 3): turns about axes of their own (0 1 2: X Y Z), each in the frame that the one before
    has turned."""
    result = np.eye(3)
    for axis, angle in zip(axes, degrees, strict=True):
        # at the right: the axis is one of the frame so far, not one of the machine
        result = result @ _about(axis, float(np.radians(angle)))
    return result


def tilt(
    b: Batch, word: str, turn: np.ndarray, zero: np.ndarray, reason: tuple[str, str] | None
) -> None:
    """From here on X Y Z are coordinates of the plane zero (3,) mm + turn (3, 3) w of the work
    offset's."""
    kinematics = b.setup.kinematics
    if kinematics is None or kinematics.lacking:
        lacking = kinematics.lacking if kinematics is not None else None
        why = lacking or ("the machine has no rotary axes", "choose the right --machine")
        b.frame = with_known(
            b.frame, PLANE, (f"{word} (tilted plane) is in force, and {why[0]}", why[1])
        )
        return
    counts = kinematics.planes or b.dialect.plane_frame
    reason = _frame_unknown(b, word, kinematics, counts) or reason
    rows, frame = [b.rows[x] for x in "XYZ"], b.frame
    shift = frame.local + frame.trans + (frame.preset if frame.preset_on else 0)
    work = (work_columns(b)[:, 0] + shift)[rows] / TICKS_PER_MM
    base = kinematics.space_at(b.state.position / TICKS_PER_MM) if counts == "call" else Space()
    # Places are told with the work offset in them, x = work + w; a word w means work + O + T w. So
    # the space is T x + (O + work - T work).
    plane = base.of(Space(tuple(turn.ravel().tolist()), _three(zero + work - turn @ work)))
    b.frame = with_known(replace(frame, plane=replace(plane, held=False)), PLANE, reason)


def plane_off(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G69: X Y Z are what they were."""
    b.frame = with_known(replace(b.frame, plane=None), PLANE)


def _say_other_way(b: Batch, word: str, rotary: Sequence[str], found: list[np.ndarray]) -> None:
    """A notice where the rotary axes may turn in two ways; found: degrees, the way taken first."""
    away = np.abs(np.mod(np.array(found) - found[0] + 180.0, 360.0) - 180.0) > 0.001
    if away.any():
        ways = [
            " ".join(f"{x}{v:.3f}" for x, v in zip(rotary, f, strict=True))
            for f in (found[0], found[int(away.any(axis=1).argmax())])
        ]
        said = (
            f"{word} is taken to turn to {ways[0]}, the shorter way; should the control go to"
            f" {ways[1]}, write the rotary axes before it"
        )
        tell(b, "G53.1", said, 0)


def _frame_unknown(
    b: Batch, word: str, kinematics: Kinematics, counts: str
) -> tuple[str, str] | None:
    """Why it is not known from which frame the plane counts; None: it is. counts: "zero", "call",
    or "" where it differs."""
    lost = [x for x in kinematics.carrying if not b.state.known[b.rows[x]]]
    away = [x for x in kinematics.carrying if b.state.position[b.rows[x]]]
    if counts == "zero" or not (lost or (away and not counts)):
        return None
    return (
        f"{word} while {' '.join(lost or away)} does not stand at zero: from which frame the plane"
        " counts then differs",
        STATE_FRAME.replace("frame =", "planes ="),
    )


def _no_pose(word: str, rotary: Sequence[str], several: bool) -> tuple[str, str]:
    """Why it is not known how the rotary axes turn."""
    if several:
        return (
            f"{word} may turn the rotary axes in two ways, and where they stand is not known",
            f"write {' '.join(rotary)} in a block before the plane",
        )
    return (
        "no pose of the rotary axes within their travels turns the tool across the plane",
        f"look at the angles before {word}",
    )


def plane_align(b: Batch, word: str, sign: float = 0.0) -> None:
    """G53.1: the rotary axes turn the tool across the plane; the slides stay. Behind `tips.settle`.
    sign: that of the axis nearest to the tool, where the program says it, else 0."""
    kinematics, frame = b.setup.kinematics, b.frame
    if kinematics is None or frame.plane is None or PLANE in frame.unknown:
        return
    known = b.state.known[[b.rows[x] for x in kinematics.rotary]].all()
    # third column: the plane's normal in the part, which the tool's axis must become
    found = kinematics.aligned(frame.plane.matrix[:, 2], b.state.position / TICKS_PER_MM)
    tilts = b.rows[kinematics.rotary[-1]]
    # the way that SEQ or _DIR asks for, if it is one of the two
    found = [pose for pose in found if pose[tilts] * sign >= 0] or found
    if not found or (len(found) > 1 and not known):
        reason = _no_pose(word, kinematics.rotary, several=bool(found))
        b.frame = with_known(frame, PLANE, reason)
        return
    rotary = [b.rows[x] for x in kinematics.rotary]
    there = np.rint(np.array(found[0]) * TICKS_PER_MM).astype(np.int64)
    if (there != b.state.position)[rotary].any() or not known:
        _say_other_way(b, word, kinematics.rotary, [f[rotary] for f in found])
        turn_to(b, there)


def turn_to(b: Batch, there: np.ndarray) -> None:
    """The rotary axes go to `there` (A,) ticks by themselves; the slides stay."""
    kinematics = b.setup.kinematics
    if kinematics is None:  # whatever rotary axes there are, no slide is carried by them
        lose(b, "ABC")
        return
    position, sent = b.state.position.copy(), np.zeros(len(b.rows), bool)
    rotary = [b.rows[x] for x in kinematics.rotary]
    slides = _slides(b, position)
    position[rotary] = there[rotary]
    position, known_after = slides(position)
    # The slides stand still, but X Y Z of the plane are others now: a place that no block has
    # named, as behind G28.
    sent[rotary] = sent[[b.rows[x] for x in "XYZ"]] = True
    before = b.state.sent if b.state.sent is not None else np.zeros(len(b.rows), bool)
    b.state = replace(b.state, position=position, known=known_after, sent=before | sent)


def shifted_within(b: Batch, word: str) -> None:
    """A datum shift of Klartext while a plane is in force: nobody can say in which of the two
    coordinates it counts."""
    if b.dialect.grammar.klartext and b.frame.plane is not None:
        message = "a datum shift while a tilted plane is in force"
        b.frame = with_known(b.frame, PLANE, (message, "shift the datum before PLANE"))


def _slides(
    b: Batch, position: np.ndarray
) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """A function from ticks with other rotary positions to the places of the space and what is
    known, slides as they are at `position` (A,)."""
    kinematics, frame = b.setup.kinematics, b.frame
    assert kinematics is not None
    here = (frame.space, frame.length / TICKS_PER_MM)
    known = b.state.known.copy()
    xyz = list(kinematics.linear)
    all_known = known[list(kinematics.needs)].all()
    slides = (
        kinematics.convert(position / TICKS_PER_MM, here, (None, here[1])) if all_known else None
    )
    # the control turns them to angles that follow from the plane, wherever they stood
    known[[b.rows[x] for x in kinematics.rotary]] = True

    def turned(after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if slides is None:
            known[xyz] = False
            return after, known
        # the slides as they stand, with the tables turned: then back into the words' coordinates
        pose = after / TICKS_PER_MM
        pose[xyz] = slides[xyz]
        place = kinematics.convert(pose, (None, here[1]), here)
        result = after.copy()
        result[xyz] = np.rint(place * TICKS_PER_MM).astype(np.int64)[xyz]
        return result, known

    return turned


def _across(tool: np.ndarray, normal: np.ndarray) -> bool:
    """Whether the tool's axis is the plane's normal, both (3,) of length 1."""
    return not (np.linalg.norm(np.cross(tool, normal)) > STANDS or tool @ normal < 0)


def refuse_planes(b: Batch, axis_words: AxisWords) -> None:
    """What can not be followed while X Y Z are coordinates of a plane."""
    kinematics, frame = b.setup.kinematics, b.frame
    if frame.plane is None or kinematics is None:
        return
    every = np.arange(b.n)
    if "work offset" in b.given:
        lost(
            b,
            np.flatnonzero(b.given["work offset"] >= 0),
            "a work offset called while a tilted plane is in force",
        )
    if frame.tip is not None:
        return
    words = [p for x in kinematics.rotary for p in axis_words.get(x, ())]
    turning = b.words.block[np.concatenate([every[:0], *words])]
    turning = turning[~b.taken[turning]]
    if len(turning):
        b.blame(every[int(turning.min()) :], *TURNED)
        b.frame = with_known(frame, PLANE, TURNED)  # and so behind this batch
    rotary = [b.rows[x] for x in kinematics.rotary]
    if not b.state.known[rotary].all() or not b.state.position[rotary].any():
        return
    tool = kinematics.tool_axis(b.state.position / TICKS_PER_MM)
    if not _across(tool, frame.plane.matrix[:, 2]):
        b.blame(
            every,
            "the tool does not stand across the tilted plane",
            "let the control turn it: G53.1 behind G68.2, CYCLE800 with a direction",
        )


def _about(axis: int, angle: float) -> np.ndarray:
    """(3, 3) rotation about X, Y or Z, rad."""
    result = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result[i, i] = result[j, j] = np.cos(angle)
    result[j, i] = np.sin(angle)
    result[i, j] = -result[j, i]
    return result


def _three(vector: np.ndarray) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
