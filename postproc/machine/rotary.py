"""The same sum for chains with rotary axes: errors are carried from the tool back to the workpiece,
pose by pose.

Read from the workpiece to the tool, every axis is a motion N_j of what follows it (a translation
along its direction, or a rotation about its centre line), and its errors E_j are a small motion
beside it. To first order the tool tip is off by the sum of every E_j at the place where it acts,
turned by the nominal rotations before it. Translations and rotations of a rotary axis are those of
ISO 230-7: about a point on its centre line, in the frame that does not turn with it. Where its
centre line lies beside the nominal one (X0C, Y0C) or leans (A0C, B0C) is a motion before N_j and
taken back behind it.

The result is told along the slides, as a correction must move them: a table that turns the part
turns their directions. How far the tool leans is told by `orientation`; rotary words are corrected
for it where that is asked for (tip.py).
"""

from __future__ import annotations

import numpy as np

from postproc.errors import MachineError
from postproc.machine.chain import ROTARY, XYZ, Chain, Parts
from postproc.records import columns

# determinant of the slides' directions: below, one slide does nearly what another does
SINGULAR = 0.1
Errors = tuple[np.ndarray | None, np.ndarray | None]  # (3, N) mm and rad; None: all zero
State = tuple[np.ndarray, np.ndarray, np.ndarray]  # (3, N) tip mm, its deviation mm, its lean rad


@columns
class Geometry:
    """What does not move. tool (3,) mm; location: axis to (6,) mm and rad, how its line lies beside
    the nominal one;
    centre, measured: axis to (3,) mm; optic: axis to what its measured point was fixed to."""

    chain: Chain
    location: dict[str, np.ndarray]
    tool: np.ndarray
    centre: dict[str, np.ndarray]
    measured: dict[str, np.ndarray]
    optic: dict[str, str]


def tip_deviation(
    g: Geometry, parts: dict[str, Parts], position: dict[str, np.ndarray]
) -> list[np.ndarray]:
    """Three (N,) columns: mm by which the slides X, Y, Z seem to be off. position: axis to (N,) mm
    or degrees.

    Raises MachineError at a pose where the slides' directions do not span what must be corrected.
    """
    off, _ = carried(g, parts, position)
    return _along_slides(g.chain, off, position)


def carried(
    g: Geometry, parts: dict[str, Parts], position: dict[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """(3, N) mm deviation of the tip and (3, N) rad by which the tool leans, which no slide can
    correct, in the workpiece's frame."""
    n = len(next(iter(position.values())))
    tip = np.repeat(g.tool[:, None].astype(float), n, axis=1)
    off, lean = np.zeros((3, n)), np.zeros((3, n))
    # Each step takes tip, off and lean from the tool's side of an axis to its part's side:
    #     w --- C --- b --- Y --- X --- Z --- t
    #       <===    <=====  <===  <===  <===       a slide adds its own, a table also turns the sum
    # `off` and `lean` are told in the frame of the body that the steps have reached.
    for letter in reversed(g.chain.axes):
        errors, step = _split(parts.get(letter), n), _slid if letter in XYZ else _swivelled
        tip, off, lean = step(g, letter, errors, position[letter], tip, off, lean)
    return off, lean


def _slid(
    g: Geometry,
    letter: str,
    errors: Errors,
    q: np.ndarray,
    tip: np.ndarray,
    off: np.ndarray,
    lean: np.ndarray,
) -> State:
    """The state beyond a slide at q (N,) mm."""
    moves, turns = errors
    way = np.zeros_like(tip)
    way[XYZ.index(letter)] = q
    if turns is not None:
        # Abbe: an angle moves the tip by angle x arm, from the optic to the tip, on the body that
        # the optic rides on: on the tool's the tip stands as it did before this slide, on the
        # part's where the slide's way has taken it.
        own = (g.optic.get(letter) or g.chain.side(letter)) == "workpiece"
        arm = tip + way if own else tip
        off = off + cross(turns, arm - g.measured[letter][:, None])
        lean = lean + turns
    if moves is not None:
        off = off + moves
    stands = g.location.get(letter)
    if stands is not None:
        off = off + cross(stands[3:, None], way)
    return tip + way, off, lean


def _of_line(stands: np.ndarray | None, arm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """mm, rad: what a rotary axis' line beside its nominal one does at the end of an (3, N) arm."""
    if stands is None:
        return np.zeros((3, 1)), np.zeros((3, 1))
    return stands[:3, None] + cross(stands[3:, None], arm), stands[3:, None]


def _swivelled(
    g: Geometry,
    letter: str,
    errors: Errors,
    q: np.ndarray,
    tip: np.ndarray,
    off: np.ndarray,
    lean: np.ndarray,
) -> State:
    """The state beyond a rotary axis at q (N,) degrees: its own errors act before it turns where it
    carries the part, behind it where it carries the tool."""
    centre, measured = g.centre[letter][:, None], g.measured[letter][:, None]
    stands = g.location.get(letter)
    # ISO 230-7 tells the axis' errors in the frame that does not turn with it, the bed's. Seen from
    # a table that frame lies towards the tool, from a head towards the part:
    #     w === C | b ...                 ... b | A === t
    #             ^ before the turn           ^ behind it
    carries_part = g.chain.side(letter) == "workpiece"
    if carries_part:
        off, lean = _added(off, lean, *errors, tip - centre - measured)
    turn = rotation(letter, np.radians(q))
    moved, leant = _of_line(stands, tip - centre)
    tip = _turned(turn, tip - centre) + centre
    # About a line displaced by d a point goes to R (p - d) + d = R p + (1 - R) d: what the
    # displacement does to the arm is taken off before the turn and put back behind it, where the
    # arm has turned.
    off, lean = _turned(turn, off - moved), _turned(turn, lean - leant)
    moved, leant = _of_line(stands, tip - centre)
    off, lean = off + moved, lean + leant
    if not carries_part:
        off, lean = _added(off, lean, *errors, tip - centre - measured)
    return tip, off, lean


def rotation(letter: str, angle: np.ndarray) -> np.ndarray:
    """(3, 3, N) about X, Y or Z for A, B or C; angle (N,) rad, right-handed."""
    i = ROTARY.index(letter)
    j, k = (i + 1) % 3, (i + 2) % 3
    result = np.zeros((3, 3, len(angle)))
    result[i, i] = 1.0
    result[j, j] = result[k, k] = np.cos(angle)
    # Right-handed: A turns Y into Z, B turns Z into X, C turns X into Y; (i, j, k) in that order.
    result[k, j] = np.sin(angle)
    result[j, k] = -result[k, j]
    return result


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3, N) a x b, of (3, N) or (3, 1) each; (3,) of two (3,). As np.cross, which
    takes six times as long where there are 50 columns or fewer."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _split(part: Parts | None, n: int) -> tuple[np.ndarray | None, np.ndarray | None]:
    """(3, n) translations and (3, n) rotations, None where all are zero."""
    if part is None:
        return None, None
    halves = []
    for half in (part[:3], part[3:]):
        live = [np.zeros(n) if column is None else column for column in half]
        halves.append(None if all(column is None for column in half) else np.stack(live))
    return halves[0], halves[1]


def _added(
    off: np.ndarray,
    lean: np.ndarray,
    moves: np.ndarray | None,
    turns: np.ndarray | None,
    arm: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    if moves is not None:
        off = off + moves
    if turns is not None:
        off, lean = off + cross(turns, arm), lean + turns
    return off, lean


def _turned(turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    turned: np.ndarray = np.einsum("ijn,jn->in", turn, vectors)
    return turned


def _along_slides(
    chain: Chain, off: np.ndarray, position: dict[str, np.ndarray]
) -> list[np.ndarray]:
    """A deviation of the workpiece's frame, told along the slides that the machine has."""
    n = off.shape[1]
    # From the part outwards: a slide's direction, as the part sees it, is turned by the rotary axes
    # between both. Where none lies between two slides, their directions stand at right angles, and
    # a projection on each is the answer.
    # (3, 3, N) product of the rotations between the part and the link that is looked at
    before = np.repeat(np.eye(3)[:, :, None], n, axis=2)
    slides: list[str] = []
    directions: list[np.ndarray] = []
    between = False  # whether a rotary axis lies between two slides
    for letter in chain.axes:
        if letter in ROTARY:
            before = np.einsum(
                "ijn,jkn->ikn", before, rotation(letter, np.radians(position[letter]))
            )
            # a slide stands before it already, and one follows: their directions may come to lie
            # alike
            between |= bool(slides) and any(
                x in XYZ for x in chain.axes[chain.axes.index(letter) :]
            )
        else:
            slides.append(letter)
            directions.append(before[:, XYZ.index(letter)])
    result = [np.zeros(n) for _ in XYZ]
    if not between:
        for letter, direction in zip(slides, directions, strict=True):
            result[XYZ.index(letter)] = (direction * off).sum(axis=0)
        return result
    solved = _solved(chain, slides, directions, off, position)
    for k, letter in enumerate(slides):
        result[XYZ.index(letter)] = solved[:, k].copy()
    return result


def _solved(
    chain: Chain,
    slides: list[str],
    directions: list[np.ndarray],
    off: np.ndarray,
    position: dict[str, np.ndarray],
) -> np.ndarray:
    """(N, slides) mm along slides whose `directions`, (3, N), are not at right angles. Raises
    MachineError where two of them are one."""
    matrix = np.stack(directions, axis=1).transpose(2, 0, 1)  # (N, 3, slides)
    # SINGULAR for two slides is the sine of the angle between them: 5.7 degrees. There a deviation
    # across takes ten times as much travel of both, against each other.
    # Normal equations D'D x = D'off: a machine of two slides reaches what lies in their plane. The
    # determinant of D'D is the square of the area or volume that the directions span.
    square = np.einsum("nij,nik->njk", matrix, matrix)
    bad = np.flatnonzero(np.linalg.det(square) < SINGULAR**2)
    if len(bad):
        pose = ", ".join(f"{x} = {position[x][bad[0]]:g}" for x in chain.rotary)
        raise MachineError(
            f"at {pose} degrees the slides {' '.join(slides)} no longer move in directions of"
            " their own",
            "the position can not be corrected there: keep away from this pose",
        )
    return np.linalg.solve(square, np.einsum("nij,in->nj", matrix, off)[:, :, None])[:, :, 0]
