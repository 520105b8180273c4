"""Nominal poses of a chain with rotary axes: from slides to the tool tip's place in the part, and
back.

The tip is where the axes, read from the tool to the workpiece, take the tool's point: tip = D s +
f, where the columns of D are the directions of the slides, turned by the rotary axes before them,
and f is the tip while all slides stand at zero (ISO 230-1, rigid bodies). So the slides for a tip
are one solution of three equations, and every pose has one.

Places of the tip are told as the slides would stand with every rotary axis at zero and no tool
length: the tip less the point `[tool]`. Then a work offset means the same with the tool point on
and off.
"""

from __future__ import annotations

import itertools

import numpy as np

from postproc.errors import MachineError
from postproc.machine import face
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.rotary import SINGULAR, cross, rotation
from postproc.spaces import Space


def frames(machine: Machine, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """D (3, 3, N), whose columns are the directions of X Y Z in the part, and f (3, N) mm, at
    rotary positions of q (A, N)."""
    n = q.shape[1]
    rows = {x: i for i, x in enumerate(machine.letters)}
    place = np.repeat(machine.tool[:, None].astype(float), n, axis=1)
    ways = np.zeros((3, 3, n))
    # From the tool to the part. A rotary axis turns all that lies between it and the tool about its
    # own line: a head the tool and the slides that it carries, a table everything, as seen from the
    # part (positive is the tool's motion relative to the part, ISO 841, also of a table).
    #
    #   w --- C --- b --- Y --- X --- Z --- A --- t
    #                                       |<--->|    turned by A
    #         |<--------------------------------->|    turned by C
    for letter in reversed(machine.chain.axes):
        if letter in XYZ:
            ways[XYZ.index(letter), XYZ.index(letter)] = 1.0
            continue
        turn = rotation(letter, np.radians(q[rows[letter]]))
        centre = machine.axes[letter].centre[:, None]
        place = np.einsum("ijn,jn->in", turn, place - centre) + centre
        ways = np.einsum("ijn,jkn->ikn", turn, ways)
    return ways, place


def axes_of(machine: Machine, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(R, 3, N) directions of the rotary axes of the chain, and (3, N) of the tool, away from the
    part, both in the part."""
    n = q.shape[1]
    rows = {x: i for i, x in enumerate(machine.letters)}
    tool = np.repeat(np.array([[0.0], [0.0], [1.0]]), n, axis=1)
    found: dict[str, np.ndarray] = {}
    for letter in reversed([x for x in machine.chain.axes if x in ROTARY]):
        turn = rotation(letter, np.radians(q[rows[letter]]))
        tool = np.einsum("ijn,jn->in", turn, tool)
        # what turns with an axis are the tool and the rotary axes nearer to it; its own direction
        # does not turn
        found = {x: np.einsum("ijn,jn->in", turn, way) for x, way in found.items()}
        found[letter] = np.repeat(np.eye(3)[:, [ROTARY.index(letter)]], n, axis=1)
    return np.stack([found[x] for x in machine.chain.rotary]), tool


def tips(machine: Machine, q: np.ndarray) -> np.ndarray:
    """(3, N) mm: the tip in the part, at slide positions and angles q (A, N)."""
    ways, place = frames(machine, q)
    slides = np.stack([q[machine.letters.index(x)] for x in XYZ])
    tip: np.ndarray = np.einsum("ijn,jn->in", ways, slides) + place
    return tip


def slides_at(machine: Machine, tip: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(A, N): q with the slides where they bring the tip to (3, N) mm. Raises MachineError where
    their directions do not span space."""
    ways, place = frames(machine, q)
    matrix = ways.transpose(2, 0, 1)
    bad = np.flatnonzero(np.abs(np.linalg.det(matrix)) < SINGULAR)
    if len(bad):
        pose = ", ".join(
            f"{x} = {q[machine.letters.index(x)][bad[0]]:g}" for x in machine.chain.rotary
        )
        raise MachineError(
            f"at {pose} degrees the slides no longer move in directions of their own",
            "the tool tip can not be held there: keep away from this pose",
        )
    # rotary places, and a printer's E, stay as they are
    result = q.copy()
    solved = np.linalg.solve(matrix, (tip - place).T[:, :, None])[:, :, 0]
    for k, x in enumerate(XYZ):
        result[machine.letters.index(x)] = solved[:, k]
    return result


ONE = 1e-6  # rad: directions that are nearer are one


class Poses:
    """The kinematics of one machine, as the text layer may ask for it
    (postproc.spaces.Kinematics)."""

    def __init__(self, machine: Machine):
        self.machine = machine
        self.rotary = machine.chain.rotary
        self.carrying = tuple(x for x in self.rotary if machine.chain.side(x) == "workpiece")
        self.needs = machine.chained
        self.linear = tuple(i for i, x in enumerate(machine.letters) if x in XYZ)
        self.frame = machine.tool_point.frame
        self.planes = machine.tool_point.planes
        self.codes = machine.tool_point.codes
        self.at_start = machine.tool_point.at_start
        self.lacking = _lacking(machine)
        turns = "X" in machine.chain.axes and self.carrying == ("C",)
        self.face = (machine.letters.index("X"), machine.letters.index("C")) if turns else None

    def convert(
        self,
        position: np.ndarray,
        one: tuple[Space | None, np.ndarray],
        other: tuple[Space | None, np.ndarray],
    ) -> np.ndarray:
        """(A,): the place that `position` (A,) of the first space and length is in the second."""
        return into(self.machine, *other, out_of(self.machine, *one, position[:, None]))[:, 0]

    def tool_axis(self, position: np.ndarray) -> np.ndarray:
        """(3,): the tool's direction in the part, away from it, at `position` (A,)."""
        return axes_of(self.machine, position[:, None])[1][:, 0]

    def aligned(self, normal: np.ndarray, position: np.ndarray) -> list[np.ndarray]:
        """Positions (A,) within the travels whose tool has the direction `normal` (3,) of the part;
        that with the shortest way of the axis nearest to the part first, then of the other."""
        rows = [self.machine.letters.index(x) for x in self.rotary]
        travels = [self.machine.axes[x].travel for x in self.rotary]
        found = []
        for angles in _turns_to(self.machine, normal):
            # the same direction of the tool, other places of the axes: cables tell them apart
            places = map(_places, angles, position[rows], travels)
            for place in itertools.product(*places):
                pose = position.copy()
                pose[rows] = place
                found.append((np.abs(pose - position)[rows].round(6).tolist(), pose))
        found.sort(key=lambda one: one[0])
        return [pose for _, pose in found]

    def space_at(self, position: np.ndarray) -> Space:
        """The frame of the part whose axes are the machine's while the rotary axes stand at
        `position` (A,)."""
        none = np.zeros((len(position), 4))
        for x in self.carrying:
            none[self.machine.letters.index(x)] = position[self.machine.letters.index(x)]
        for k, x in enumerate(XYZ):
            none[self.machine.letters.index(x), k + 1] = 1.0
        # One place with all slides at zero and one a millimetre along each of X Y Z, with the
        # tables where they stand: the differences are the columns of a rotation, exact since poses
        # are linear in slides.
        there = tips(self.machine, none) - self.machine.tool[:, None]
        turn = there[:, 1:] - there[:, :1]
        return Space(
            tuple(turn.ravel().tolist()),
            (float(there[0, 0]), float(there[1, 0]), float(there[2, 0])),
        )


def _places(angle: float, here: float, travel: tuple[float, float]) -> list[float]:
    """Degrees: where within the travel an axis has the angle, of whole turns those two either way
    of the place that is nearest to `here`."""
    low, high = (travel[0] - 1e-6 - angle) / 360.0, (travel[1] + 1e-6 - angle) / 360.0
    nearest = round(min(max((here - angle) / 360.0, low), high))
    turns = range(nearest - 2, nearest + 3)
    return [angle + 360.0 * turn for turn in turns if low <= turn <= high]


def _turns_to(machine: Machine, normal: np.ndarray) -> list[tuple[float, ...]]:
    """Angles of the rotary axes, degrees, in the order of the chain, at which the tool has the
    direction `normal` (3,).

    With R1 R2 z = normal the second axis is where the first one's own direction a sees the tool as
    it sees the normal: a . R2 z = a . normal, a sine of the angle; the first then turns R2 z into
    the normal. Where that leaves the first one free (a pole) it stays at zero, and so does a second
    one along the tool, which turns nothing.
    """
    ways = [np.eye(3)[ROTARY.index(x)] for x in machine.chain.rotary]
    tool = np.array([0.0, 0.0, 1.0])
    if len(ways) == 1:
        return _about_to(ways[0], tool, normal)
    first, second = ways
    along = tool - second * (second @ tool)
    across = cross(second, tool)
    lifted = second * (second @ tool)
    # a . R2 z is a . lifted + size cos(angle - phase): the angle is phase +- arccos(rest).
    size, phase = np.hypot(first @ along, first @ across), np.arctan2(first @ across, first @ along)
    if size < ONE:
        return [(one, 0.0) for (one,) in _about_to(first, tool, normal)]
    rest = (first @ normal - first @ lifted) / size
    if abs(rest) > 1 + ONE:
        return []
    half_angle = np.arccos(np.clip(rest, -1.0, 1.0))
    found: list[tuple[float, ...]] = []
    for angle in sorted({round(phase + half_angle, 12), round(phase - half_angle, 12)}):
        turned = lifted + along * np.cos(angle) + across * np.sin(angle)
        found += [(one, float(np.degrees(angle))) for (one,) in _about_to(first, turned, normal)]
    return found


def _about_to(axis: np.ndarray, one: np.ndarray, other: np.ndarray) -> list[tuple[float, ...]]:
    """The angle, degrees, by which `axis` turns direction `one` into `other`; none where it can
    not."""
    # Turning about `axis` keeps what a direction has along it: where that differs the one never
    # becomes the other. What lies across turns; along the axis nothing turns, and any angle will
    # do: zero.
    flat = [v - axis * (axis @ v) for v in (one, other)]
    if abs(axis @ one - axis @ other) > ONE:
        return []
    if np.linalg.norm(flat[0]) < ONE:
        return [(0.0,)]
    # sine from the cross product, cosine from the dot product: the sign comes out right
    return [(float(np.degrees(np.arctan2(axis @ cross(*flat), flat[0] @ flat[1]))),)]


def with_length(machine: Machine, length: np.ndarray) -> Machine:
    """The machine with a tool of length (A,) mm."""
    x, y, z = machine.xyz(length).tolist()
    return machine.with_tool((x, y, z)) if x or y or z else machine


def out_of(
    machine: Machine, space: Space | None, length: np.ndarray, place: np.ndarray
) -> np.ndarray:
    """(A, N) slide positions of places (A, N) that are told in a space, with a tool of length
    (A,)."""
    if space is None:
        return place
    if space.polar:
        return face.slides_of(machine.letters, space, place)
    rows = [machine.letters.index(x) for x in XYZ]
    tip = (
        turned(space.matrix, place[rows]) + np.array(space.origin)[:, None] + machine.tool[:, None]
    )
    return slides_at(with_length(machine, length), tip, place)


def into(
    machine: Machine, space: Space | None, length: np.ndarray, slides: np.ndarray
) -> np.ndarray:
    """(A, N) places of a space of slide positions (A, N): the other way round."""
    if space is None:
        return slides
    if space.polar:
        return face.places_of(machine.letters, space, slides)
    rows = [machine.letters.index(x) for x in XYZ]
    tip = tips(with_length(machine, length), slides) - machine.tool[:, None]
    result = slides.copy()
    result[rows] = turned(space.matrix.T, tip - np.array(space.origin)[:, None])
    return result


def turned(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(3, N): a rotation (3, 3) of vectors (3, N), each in the same way however many there are: a
    product of matrices would round by their number, and output must not depend on how the input was
    cut."""
    return np.stack(
        [row[0] * vectors[0] + row[1] * vectors[1] + row[2] * vectors[2] for row in matrix]
    )


def _lacking(machine: Machine) -> tuple[str, str] | None:
    """What machine.toml must state before the tip can be followed: where the rotary axes' lines
    lie, and for a head how far the tool stands before them."""
    if missing := sorted({*XYZ}.difference(machine.chain.axes)):
        return (
            (
                f"the machine has no slide {' '.join(missing)}, and no tip can be held with rotary"
                " axes then"
            ),
            "let the CAM program write the places of the axes themselves",
        )
    for x in machine.chain.rotary:
        across = XYZ.replace(XYZ[ROTARY.index(x)], "")
        if not set(across) <= set(machine.axes[x].centre_stated):
            words = ", ".join(f"{a} = .." for a in across)
            return (
                f"machine.toml does not say where the line of {x} lies",
                (
                    f"state a point on it in [axes.{x}], mm, all slides at zero: centre = {{"
                    f" {words} }}"
                ),
            )
    heads = [x for x in machine.chain.rotary if machine.chain.side(x) == "tool"]
    if heads and not machine.tool_stated:
        return (
            (
                "machine.toml does not say how far the spindle's nose stands from the line of"
                f" {' '.join(heads)}"
            ),
            "state its place in [tool], mm, all axes at zero, without a tool: Z = -150.0",
        )
    return None
