"""Who carries whom: "w-b-Z-X-t" reads workpiece, bed, Z carries X, tool. An axis between w and b
carries the workpiece. A lathe, w-b-Z-X-t:

    workpiece ... bed === Z carriage === X slide --- tool tip
                             |<---------- r_Z ---------->|     the tool, and where X stands
                                            |<-- r_X --->|     the tool alone

Deviation of the tool relative to the workpiece, first order (ISO 230-1, rigid-body kinematics):

    e = sum over axes j of  d_j + eps_j x (r_j - m_j) + c_j x (q_j u_j)

d_j, eps_j: translations and rotations of axis j at its position q_j; r_j: the arm from j's carriage
to the tool tip, the tool plus the positions of the axes between j and the tool (for an axis that
carries the workpiece its own as well);
m_j: the same arm where j was measured; c_j: squareness. Rotary axes: rotary.py. What is dropped are
products of two errors: 100 urad times 100 um is 10 nm. U V W are second slides along X Y Z (a quill
W on a head Z): links of the chain like any other, whose errors the slides X Y Z make up for.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from postproc.machine.cells import Value
from postproc.records import record, replace

XYZ, ROTARY = "XYZ", "ABC"
LINEAR = "XYZUVW"  # U V W: a second slide along X Y Z
SECOND = dict(zip(XYZ, "UVW", strict=True))
OPTICS = ("tool", "workpiece")
# axis to mm that stay, as arrays without axes, and the slides that add, per direction
Arms = dict[str, list[tuple[np.ndarray, tuple[str, ...]]]]
Position = dict[str, Any]  # axis to its place: a column, or one number
# six (N,) columns of one axis' deviations, or numbers of one place; None: zero everywhere
Parts = list[Any]
# (eps x arm)_i = eps_j arm_k - eps_k arm_j: direction, rotation (3 to 5), arm, whether taken away
TURNS = [
    term
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    for term in ((i, 3 + j, k, False), (i, 3 + k, j, True))
]
ZERO = np.array(0.0)  # without axes: postproc.units
NO_PARTS: Parts = [None] * 6


@record
class Chain:
    """The parsed chain: axes from the workpiece through the bed to the tool, and how many of them
    carry the workpiece."""

    axes: tuple[str, ...]
    workpiece_side: int

    @cached_property
    def rotary(self) -> tuple[str, ...]:
        """Rotary axes that the chain names."""
        return tuple(x for x in self.axes if x in ROTARY)

    @property
    def links(self) -> list[str]:
        """As it is written: w, the axes, b between them, and t."""
        at = self.workpiece_side
        return ["w", *self.axes[:at], "b", *self.axes[at:], "t"]

    def side(self, letter: str) -> str:
        """ "workpiece" for an axis that carries the workpiece, else "tool"."""
        return "workpiece" if self.axes.index(letter) < self.workpiece_side else "tool"

    def arm(self, letter: str, optic: str = "") -> tuple[str, ...]:
        """Linear axes whose positions make up the arm of `letter`.

        optic: what the measured point was fixed to, if not to the side that the axis carries. A
        point fixed to the tool goes along with it, so the axis' own position is no part of the arm;
        one fixed to the workpiece stays behind.
        """
        at = self.axes.index(letter)
        #   tool side:   b === carriage --- tip       the tip goes along: its own way is no part
        #   part side:   carriage(w) === b --- tip    the carriage lies q the other way (ISO 841
        #                                             counts the tool's motion): q is a part of it
        own = (optic or self.side(letter)) == "workpiece"
        return tuple(x for x in self.axes[at if own else at + 1 :] if x in LINEAR)

    def counted(self, letter: str, measured: np.ndarray) -> np.ndarray:
        """(3,) mm: of the place (3,) mm where the others stood while `letter` was measured, what
        its arm counts from.

        Only the axes that it carries, towards the tool, lie in its arm; where any other stood,
        itself among them, changes nothing and is ignored (contract of a machine, "Meaning").
        """
        carried = self.axes[self.axes.index(letter) + 1 :] if letter in self.axes else ()
        return np.where([x in carried or SECOND[x] in carried for x in XYZ], measured, 0.0)


def parse(text: str) -> Chain:
    """Read "w-X-Y-b-Z-t", "w-X-Y-b-Z-W-t" or "w-C-A-b-X-Y-Z-t". Raises ValueError with what is
    wrong."""
    parts = text.split("-")
    if parts[0] != "w" or parts[-1] != "t" or parts.count("b") != 1:
        raise ValueError(
            f"chain {text!r} must begin with w, end with t and hold one b, like w-b-Z-X-t"
        )
    bed = parts.index("b")
    axes = [*parts[1:bed], *parts[bed + 1 : -1]]
    for axis in axes:
        if axis not in {*LINEAR, *ROTARY}:
            raise ValueError(f"chain {text!r}: {axis!r} is not one of X Y Z A B C U V W")
    if len(set(axes)) != len(axes):
        raise ValueError(f"chain {text!r} names an axis twice")
    # With three, one direction of the tool has endlessly many poses: `poses.aligned` solves for one
    # angle or two.
    turning = len(set(axes) & set(ROTARY))
    if turning > 2:
        raise ValueError(f"chain {text!r} has more than two rotary axes")
    for axis in axes:
        if axis in "UVW":
            _check_second(text, axis, axes, turning > 0)
    return Chain(tuple(axes), bed - 1)


def _check_second(text: str, axis: str, axes: list[str], turning: bool) -> None:
    """Raises ValueError for a second slide without its first, or with rotary axes."""
    if XYZ[along(axis)] not in axes:
        raise ValueError(
            f"chain {text!r}: {axis} is a second slide along {XYZ[along(axis)]}, which it does"
            " not name"
        )
    if turning:
        raise ValueError(
            f"chain {text!r} has second slides and rotary axes, which are not followed together"
        )


def along(letter: str) -> int:
    """0, 1, 2: the direction, X Y Z, of a linear axis; U V W lie along X Y Z."""
    return LINEAR.index(letter) % 3


def arms(
    chain: Chain, tool: np.ndarray, measured: dict[str, np.ndarray], optic: dict[str, str]
) -> Arms:
    """Per axis the part of the arm that stays, and per direction the slides of that direction that
    add to it.

    tool (3,) mm; measured: axis to (3,) mm, where the others of its arm stood (`counted`); optic:
    axis to what the measured point was fixed to.
    """
    return {
        x: [
            (
                np.array(float(tool[i] - measured[x][i])),
                tuple(y for y in chain.arm(x, optic.get(x, "")) if along(y) == i),
            )
            for i in range(3)
        ]
        for x in chain.axes
    }


def leans(letter: str, lean: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """How much an axis with squareness (3,) rad drifts in each direction per mm of its own way: c x
    (q u)."""
    # Of X: C0X turns its way q towards +Y by C0X q, B0X towards -Z by B0X q; of Y: A0Y towards +Z,
    # C0Y towards -X; and so on round. Hence one plus and one minus for each axis.
    own = along(letter)
    found = []
    for k, across in ((1, 2), (2, 1)):  # the component across rotates into the other
        i, j = (own + k) % 3, (own + across) % 3
        if lean[j]:
            found.append((i, np.array(lean[j] if k == 1 else -lean[j])))
    return found


@record
class Share:
    """What one axis adds to the deviation, of which components are there: nothing is asked, made or
    added where one is missing. letter; drifts: direction and rate of its squareness; shifts: its
    translations; begins: directions in which nothing comes before its turns, each with 0; arm:
    directions of its arm that count, each with the part that stays and the slides that add; turns:
    its own of TURNS."""

    letter: str
    drifts: Sequence[tuple[int, Value]]
    shifts: list[int]
    begins: Sequence[tuple[int, Value]]
    arm: Sequence[tuple[int, Value, tuple[str, ...]]]
    turns: list[tuple[int, int, int, bool]]

    @property
    def in_numbers(self) -> Share:
        """The same for one place, told in numbers."""
        return replace(
            self,
            drifts=[(i, float(rate)) for i, rate in self.drifts],
            begins=[(i, float(zero)) for i, zero in self.begins],
            arm=[(k, float(stays), slides) for k, stays, slides in self.arm],
        )


def shares(
    arms: Arms, live: dict[str, set[int]], leans: dict[str, list[tuple[int, np.ndarray]]]
) -> list[Share]:
    """Of each axis of a chain without rotary axes. arms, leans: of the functions above; live: axis
    to its components that are not zero everywhere, 0 to 5."""
    found, written = [], set()
    for letter, stays in arms.items():
        own = live.get(letter, set())
        there = [k for k, (constant, slides) in enumerate(stays) if slides or constant]
        turns = [term for term in TURNS if term[1] in own and term[2] in there]
        arm = [(k, *stays[k]) for k in sorted({arm for _, _, arm, _ in turns})]
        drifts, shifts = leans.get(letter, []), [i for i in range(3) if i in own]
        written |= {*shifts, *(i for i, _ in drifts)}
        # tip_deviation adds a turn to what stands there already. In a direction to which neither
        # this axis nor one before it has written a number, a zero must stand first. `written` goes
        # on from axis to axis, so the order of the shares is the order of the chain.
        begins = {i for i, _, _, _ in turns} - written
        written |= begins
        zeros = [(i, ZERO) for i in sorted(begins)]
        found.append(Share(letter, drifts, shifts, zeros, arm, turns))
    return found


def tip_deviation(each: list[Share], parts: dict[str, Parts], position: Position) -> list[Any]:
    """Three (N,) columns X Y Z of the deviation in mm, of a chain without rotary axes; None for one
    that is zero everywhere.

    parts: axis to its six deviations at its position; position: axis to (N,) mm. Of one place all
    of it may be numbers, and is told in numbers then. Not in place: a number has none.
    """
    total: list[Any] = [None, None, None]
    # The order of these sums is part of the result: sums of floats round by their order, and one
    # place told in numbers must come out as the same place within a column does.
    for share in each:
        for i, rate in share.drifts:
            drift = rate * position[share.letter]
            total[i] = drift if total[i] is None else total[i] + drift
        part = parts.get(share.letter, NO_PARTS)
        for i in share.shifts:
            total[i] = part[i] if total[i] is None else total[i] + part[i]
        for i, zero in share.begins:
            total[i] = zero
        arm = {k: _length(constant, slides, position) for k, constant, slides in share.arm}
        for i, j, k, away in share.turns:
            turn = part[j] * arm[k]
            total[i] = total[i] - turn if away else total[i] + turn
    return total


def _length(constant: Value, slides: tuple[str, ...], position: Position) -> Value:
    """(N,) or one number of mm: an arm in one direction."""
    total = constant
    if slides:
        # a constant of zero is left out: each term costs a pass over N places
        total = position[slides[0]] + constant if constant else position[slides[0]]
        for slide in slides[1:]:
            total = total + position[slide]
    return total


def summed(part: Parts | None, more: Parts) -> Parts:
    """Six deviations and six more; None: there are none."""
    if part is None:
        return more
    # None stays None: a column of zeros would be added at every look from here on
    return [b if a is None else a if b is None else a + b for a, b in zip(part, more, strict=True)]
