"""Polar interpolation of turning centres: G12.1 (G112) of Fanuc lathes, G112 of Haas lathes, G137
of Okuma lathes.

From the call on X and a second coordinate are Cartesian coordinates, in mm or inches, of the face
that C turns under the tool; the control makes X and C of them (postproc.machine.face). The second
one stands in the row of C. Where C stands at the call is its zero, C's line the zero of X.

Fanuc B-64604EN-1, "Polar coordinate interpolation (G12.1, G13.1)": the second coordinate is C, a
radius whether X is a diameter or not; I and J are the centre; the plane is that of X and C whatever
G17 to G19 said before; G0, G27 to G30, G52, G53, G92 and cycles in it are alarm PS0146, and so is
a begin or an end within G41 G42. Haas lathe operator's manual 96-8900, "G112 XY to XC
interpolation": the second coordinate is Y, X is a radius, arcs and G41 G42 need G17.
Okuma OSP-P200L / P20L programming manual 5238-E, "Contour generation" (P-244 to P-248), and those
of OSP-P300, as NC-PB/gEdit sums them up: as Haas, with G101 G102 G103 for G1 G2 G3; C of G137 is
the direction of X, where C stands in programs (elsewhere it is refused). One part by one post is
G112 on a Haas and G137 on an Okuma with the same places, sides and senses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from postproc.motions import COUNTER
from postproc.nc.batch import NO_WORDS, AxisWords, Batch
from postproc.nc.codes import TRANSFORM
from postproc.nc.grammar import ABSOLUTE, AXES, RELATIVE
from postproc.nc.queries import lose
from postproc.nc.state import NONE, Frame
from postproc.nc.zeros import with_known, work_columns
from postproc.records import replace
from postproc.spaces import Kinematics, Space
from postproc.units import TICKS_PER_MM

#     second (Y or C)    From the call on the words are x, y of a face that turns with C. The
#      ^    o (x, y)     control makes of them X = hypot(x, y) and C = where it stood at the call
#      |  .'             + atan2(y, x) (postproc/machine/face.py): the part turns until (x, y) lies
#      |.'_______> X     under the tool.
FACE = "face"  # the part of a frame's unknowns
PLANES = {170: ("X", "Y", "I", "J"), 180: ("Z", "X", "K", "I"), 190: ("Y", "Z", "J", "K")}
ON_FACE = ("X", "C", "I", "J")
OWN_WAY = TRANSFORM.partition(": ")[2]
INCREMENT = {"C": "H", "Y": "V"}
SAME = 1e-3  # degrees
BESIDE = 0.1  # mm: a corrected Y stands beside its zero, by less than that
OFF = "end it before, and begin it anew behind"

Spellings = Sequence[tuple[str, tuple[str, ...], tuple[str, ...]]]


def letter_in(b: Batch) -> str:
    """The letter of the second coordinate in this segment, "" while nothing is interpolated."""
    if not b.dialect.polar or "C" not in b.rows:
        return ""
    group = b.dialect.polar_group
    given = b.given.get(group)
    # the code of the first block, for one that begins or ends it begins a segment
    number = NONE if given is None or not b.n else int(given[0])
    number = b.state.codes.get(group, NONE) if number == NONE else number
    return b.dialect.polar if b.dialect.frame_codes.get(number) == "polar on" else ""


def spellings(b: Batch, plain: Spellings) -> Spellings:
    """Under which letters the words of each axis come, in this segment."""
    if not b.polar:
        return plain
    own, more = b.polar, INCREMENT[b.polar]
    polar_axes = {
        "C": ("C", (own, chr(ABSOLUTE + AXES.index(own))), (more, chr(RELATIVE + AXES.index(own)))),
        "Y": ("Y", (), ()),
    }
    return [polar_axes.get(axis, (axis, one, two)) for axis, one, two in plain]


def planes(b: Batch) -> dict[int, tuple[str, str, str, str]]:
    """By the code of the plane: its axes, and the letters of a centre in it."""
    if not b.polar:
        return PLANES
    if b.polar == "C":
        return dict.fromkeys(PLANES, ON_FACE)
    return {170: ON_FACE}


def polar_on(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G12.1, G112: from here on X and the second coordinate are places of the face."""
    if b.frame.face is not None:
        return
    space = Space(polar=b.dialect.polar)
    reason = _lacking(b, axis_words, word)
    kinematics = b.setup.kinematics
    if kinematics is None or kinematics.face is None:
        b.frame = with_known(b.frame, FACE, reason)
        return
    if reason is None:
        x, c = kinematics.face
        shift = _zero(b, x)
        # X of the slide is a hypot from here on, never on C's line or beyond it
        if b.state.position[x] <= shift:
            reason = (
                f"{word} while the tool does not stand outside of C's line",
                "move X to the start of the contour before it",
            )
        heading = float(b.state.position[c] / TICKS_PER_MM)
        cos, sin = float(np.cos(np.radians(heading))), float(np.sin(np.radians(heading)))
        turn = (cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
        across = _zero(b, b.rows["Y"]) / TICKS_PER_MM if "Y" in b.rows else 0.0
        space = replace(
            space, turn=turn, heading=heading, shift=shift / TICKS_PER_MM, across=across
        )
    b.frame = with_known(replace(b.frame, face=space), FACE, reason)


# Whole: a list of refusals, a condition to each.
def _lacking(b: Batch, axis_words: AxisWords, word: str) -> tuple[str, str] | None:
    """Why the interpolation can not be followed from here on."""
    kinematics = b.setup.kinematics
    if kinematics is None or kinematics.face is None:
        return (f"{word} turns the part by C, and no C in the machine's chain carries it", OWN_WAY)
    if any(len(place) and b.words.block[place[0]] == 0 for pair in axis_words.values()
           for place in pair):  # fmt: skip
        return (f"{word} and axis words in one block", "write them in blocks of their own")
    if b.state.codes.get("cutter", NONE) in b.dialect.beside:
        return (f"{word} with cutter radius compensation on", "write G40 before it")
    if b.frame.tip is not None or b.frame.plane is not None:
        return (f"{word} in a tilted plane, or with the tool point on", OFF)
    x, c = kinematics.face
    unknown = [b.setup.axes[row] for row in (x, c) if not b.state.known[row]]
    y = b.rows.get("Y")
    if not unknown and (turned := _turned(b, c)):
        return (f"{word} {turned} is not where C stands", "write G0 and the same C before it")
    if y is not None and not b.state.known[y]:
        unknown.append("Y")
    if unknown:
        return (
            f"where {' '.join(unknown)} stands is not known at {word}",
            f"move {' '.join(unknown)} to an absolute position first, or say where it is: --start"
            f" {','.join(f'{x}100' for x in unknown)}",
        )
    if y is not None and abs(b.state.position[y] - _zero(b, y)) > BESIDE * TICKS_PER_MM:
        return (f"{word} while Y does not stand at zero", "move Y to Y0 before it")
    return None


def _turned(b: Batch, row: int) -> str:
    """C of the block where it is another one than that of the axis."""
    for place in b.places.get("C", ())[:1]:
        at = (b.state.position[row] - _zero(b, row)) / TICKS_PER_MM
        if b.words.block[place] == 0 and abs(float(b.numbers(np.array([place]))[0]) - at) > SAME:
            return f"C{b.words.text[b.words.number[place] : b.words.stop[place]].decode()}"
    return ""


def motions(b: Batch, motion: np.ndarray) -> np.ndarray:
    """(B,) the motion codes with G1 G2 G3 for those of a contour on the face (Okuma's G101)."""
    if not b.polar or not b.dialect.contour:
        return motion
    own = 10 * b.dialect.contour
    plain = b.has_axis & ~b.taken & (motion >= 0) & (motion < own)
    b.foreign |= plain
    b.blame(
        np.flatnonzero(plain),
        "G0 to G3 in polar interpolation",
        f"write G{b.dialect.contour + 1} and its kin, which make X and C of X and Y",
    )
    return np.where((motion > own) & (motion <= own + 30), motion - own, motion)


def _zero(b: Batch, row: int) -> int:
    """Ticks: where the zero of an axis' words lies in the first block."""
    return int(work_columns(b)[row, 0] + b.frame.shift[row])


def polar_off(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G13.1, G113: words are places of the slides again."""
    if FACE in b.frame.unknown:
        lose(b, "XC")
    b.frame = with_known(replace(b.frame, face=None), FACE)


def transformed(
    kinematics: Kinematics | None,
    position: np.ndarray,
    known: np.ndarray,
    frames: tuple[Frame | None, Frame],
) -> tuple[np.ndarray, np.ndarray]:
    """(A,) ticks and (A,) bool: where the axes stand, where one of the frames is a face's."""
    old, new = frames
    if kinematics is None or kinematics.face is None:
        return position, known
    rows = list(kinematics.face)
    lost = FACE in new.unknown or (old is not None and FACE in old.unknown)
    if lost or not known[rows].all():
        known = known.copy()
        known[rows] = False
        return position, known
    none = np.zeros(len(position))
    spaces = [f.face if f is not None else None for f in (old, new)]
    there = kinematics.convert(position / TICKS_PER_MM, (spaces[0], none), (spaces[1], none))
    position = position.copy()
    position[rows] = np.rint(there * TICKS_PER_MM).astype(np.int64)[rows]
    return position, known


def settle_zero(b: Batch) -> None:
    """Count X and the second coordinate from C's line, and refuse a zero that moves meanwhile."""
    if not b.polar:
        return
    x, c = b.rows["X"], b.rows["C"]
    face = b.frame.face
    if face is not None and FACE not in b.frame.unknown:
        moved = np.broadcast_to(b.offset[x] != round(face.shift * TICKS_PER_MM), b.n)
        _blame(b, np.flatnonzero(moved), "a new zero of X in polar interpolation")
    # the zero of X is in the space already (shift), and C's is where it stands at the call
    b.offset = b.offset.copy()
    b.offset[[x, c]] = 0


def refuse_faces(b: Batch, motion: np.ndarray, moving: np.ndarray) -> None:
    """What the control does not do in polar interpolation. motion (B,): the code in force; moving
    (B,)."""
    if not b.polar or not b.n:
        return
    strange = [x for x in ("YV" if b.polar == "C" else "CH") if x in b.places]
    for letter in strange:
        block = b.words.block[b.places[letter]]
        block = block[~b.taken[block]]
        # counted as a motion, for only a motion carries a reason
        moving[block] = True
        _blame(b, block, f"{letter} in polar interpolation")
    if b.polar == "C":
        b.blame(
            np.flatnonzero(moving & (motion == 0)),
            "G0 in polar interpolation",
            "the control stops there (alarm PS0146): write G1",
        )
    cycles = moving & (b.dialect.kind[np.maximum(motion, 0)] > COUNTER)
    _blame(b, np.flatnonzero(cycles), "a cycle in polar interpolation")
    _blame(b, np.flatnonzero(b.machine), "G53 in polar interpolation")
    away = np.flatnonzero(b.loses | np.isin(np.arange(b.n), _sent(b)))
    if len(away):
        message = "a reference point in polar interpolation"
        b.blame(np.arange(int(away[0]), b.n), message, OFF)
        b.frame = with_known(b.frame, FACE, (message, OFF))


def _sent(b: Batch) -> np.ndarray:
    """Blocks with G28 and G30."""
    return np.concatenate([b.single.get(number, NO_WORDS) for number in (280, 300)])


def _blame(b: Batch, blocks: np.ndarray, message: str) -> None:
    b.blame(blocks, message, OFF)
