"""How the tool stands beside the programmed contour: G41 G42 as columns of the plane, the tool's
radius and its nose.

The control shifts the path by the radius, at right angles to every block. Which radius that is
depends on the control: LinuxCNC takes the diameter of the tool that D names, or of the one in the
spindle, and with G41.1 G42.1 D is the diameter itself (src/emc/rs274ngc/interp_convert.cc,
convert_cutter_compensation_on); Fanuc mills count offsets by the last D, lathes by T0101, Siemens
by T and D. What is not stated is not known: nan.

The first block behind G40 goes to its programmed end in both axes of the plane, named or not.
"""

from __future__ import annotations

import numpy as np

from postproc.motions import ENTRY, FREE, OFFSET
from postproc.nc.batch import Batch
from postproc.nc.columns import one_of, spread
from postproc.nc.face import planes
from postproc.nc.queries import words_of
from postproc.nc.state import NONE, Beside
from postproc.nc.zeros import stated, stated_tool, tool_named
from postproc.records import replace
from postproc.units import MM_PER_INCH

LEFT, DYNAMIC = (410, 411), (411, 421)
# Where the point that the control drives lies from the centre of the nose, in radii along Z and X
# (G18), by the number of the tool's orientation. LinuxCNC: interp_queue.cc, latheorigin_z and
# latheorigin_x; Fanuc: imaginary tool nose.
#   X            The point in radii from the centre o, for each number of Fanuc: for 3, the tip of
#   |  2  6  1   a tool that turns an outside towards the chuck, one radius down X and one towards
#   |  7  o  5   the chuck, (-1, -1). In LinuxCNC's numbers X points down.
#   |  3  8  4
#   +--------Z
FANUC_NOSE = {
    1: (1, 1), 2: (-1, 1), 3: (-1, -1), 4: (1, -1), 5: (1, 0), 6: (0, 1), 7: (-1, 0), 8: (0, -1),
}  # fmt: skip
LINUXCNC_NOSE = {number: (z, -x) for number, (z, x) in FANUC_NOSE.items()}


def beside_columns(b: Batch, block: np.ndarray) -> dict[str, np.ndarray]:
    """Motions' columns cutter, plane, radius and nose, at the moving blocks. Sets `b.beside` to
    what the next batch needs."""
    n, held = len(block), b.held("cutter")
    named = (
        "cutter" in b.given
        or "D" in b.places
        or b.beside is not b.state.beside
        or b.beside.on
        or b.state.codes.get("cutter", NONE) in b.dialect.beside
    )
    if not b.dialect.beside or not named:
        return {
            "cutter": np.zeros(n, np.int8),
            "plane": np.full((2, n), -1),
            "radius": np.zeros(n),
            "nose": np.zeros((2, n)),
        }
    on = one_of(spread(held, b.n)[block], b.dialect.beside)
    before = np.concatenate([[b.state.beside.on], on[:-1]])
    radius, nose = _tools(b)
    b.beside = replace(b.beside, on=bool(on[-1]) if n else b.state.beside.on)
    #   block     X..    G41 X..  X..     X..     G40 X..  X..    Of the blocks that move the first
    #   on        0      1        1       1       0        0      under G41 and the first behind G40
    #   cutter    FREE   ENTRY    OFFSET  OFFSET  ENTRY    FREE   lead beside the contour and back.
    cutter = np.where(on != before[:n], ENTRY, np.where(on, OFFSET, FREE)).astype(np.int8)
    plane = np.full((2, n), -1)
    if cutter.any():
        plane = np.where(cutter != FREE, _planes(b, block), -1)
    columns = {"cutter": cutter, "plane": plane, "radius": np.zeros(n), "nose": np.zeros((2, n))}
    if on.any():
        columns["radius"] = np.where(on, radius[block], 0.0)
        columns["nose"] = np.where(on, nose[:, block], 0.0)
    return columns


def _planes(b: Batch, block: np.ndarray) -> np.ndarray:
    """(2, N) rows of the plane's axes, -1 where the machine has them not."""
    code = spread(b.held("plane"), b.n)[block]
    plane = np.full((2, len(block)), -1)
    for number, (first, second, *_) in planes(b).items():
        plane[:, code == number] = np.array([[b.rows.get(first, -1)], [b.rows.get(second, -1)]])
    return plane


# -- which tool ------------------------------------------------------------------------------------


def _tools(b: Batch) -> tuple[np.ndarray, np.ndarray]:
    """(B,) mm radius, + where the centre lies left of the path, and (2, B) mm from it to the point
    that is driven."""
    given = b.given.get("cutter")
    begins = np.flatnonzero(one_of(given, b.dialect.beside)).tolist() if given is not None else []
    named = words_of(b, "D")
    offsets = (
        dict(zip(b.words.block[named].tolist(), b.numbers(named).tolist(), strict=True))
        if len(named)
        else {}
    )
    if b.beside is not b.state.beside:  # by the first block (lengths.edge_of)
        offsets[0] = b.beside.offset
    state, edges, seen = b.beside, [0], [b.beside]
    for block in sorted({*begins, *offsets}):
        code = int(given[block]) if given is not None and block in begins else NONE
        state = _from(b, state, block, code, offsets.get(block))
        edges.append(block)
        seen.append(state)
    b.beside = state
    # what holds from one change to the next, spread over the blocks between
    count = np.diff([*edges, b.n])
    radius = np.repeat([s.radius for s in seen], count)
    return radius, np.repeat(np.array([s.nose for s in seen], float).T, count, axis=1)


def _from(b: Batch, state: Beside, block: int, code: int, d: float | None) -> Beside:
    """The state from a block that begins an offset (code) or names another one (D)."""
    if code == NONE and not _by_offset(b):
        return state
    if d is not None and code not in DYNAMIC:
        state = replace(state, offset=int(d))
    side = state.side if code == NONE else 1 if code in LEFT else -1
    size, orientation = _size(b, state, block, code, d)
    nose = (LINUXCNC_NOSE if by_tool(b) else FANUC_NOSE).get(orientation, (0, 0))
    if b.polar or spread(b.held("plane"), b.n)[block] != 180:
        nose = (0, 0)
    # LinuxCNC: a negative radius changes the side.
    along, across = (abs(size) * k if k else 0.0 for k in nose)
    return replace(state, side=side, radius=side * size, nose=(along, across))


def by_tool(b: Batch) -> bool:
    """Whether D names a tool, as in LinuxCNC."""
    return any(
        number in b.dialect.by_number and b.dialect.by_number[number].does == "cutter"
        for number in DYNAMIC
    )


def _by_offset(b: Batch) -> bool:
    """Whether D alone changes the offset in force."""
    return not by_tool(b) and not b.dialect.tool_offsets


def _size(b: Batch, state: Beside, block: int, code: int, d: float | None) -> tuple[float, int]:
    """mm radius, nan if not stated, and the nose's orientation, 0: none."""
    if code in DYNAMIC:
        unit = MM_PER_INCH if spread(b.held("units"), b.n)[block] == 200 else 1.0
        return (np.nan if d is None else d * unit / 2), int(_word(b, "L", block) or 0)
    place = _place(b, state, block, d)
    if place is None:
        return np.nan, 0
    return place.get("R", np.nan), int(place.get("Q", 0))


def _place(b: Batch, state: Beside, block: int, d: float | None) -> dict[str, float] | None:
    """The offset that holds the radius; {"R": 0.0} for none."""
    if b.dialect.tool_offsets:
        return stated(b, _last_name(b, block))
    number = _tool(b, block) if d is None and by_tool(b) else state.offset
    if number == 0:
        return {"R": 0.0}
    if number < 0:
        return None
    if not by_tool(b):
        return stated_tool(b, "D", number)
    found = stated_tool(b, "H", number)  # G10 L1 keeps what it sets under H
    if found is None and d is not None and _states_tools(b):
        b.beside_missing.append((block, number))
    return found if found and "R" in found else stated(b, f"T{number}")


def _states_tools(b: Batch) -> bool:
    """Whether offsets of tools are stated at all."""
    return any(name[:1] == "T" for name in b.setup.offsets)


def _word(b: Batch, letter: str, block: int) -> float | None:
    place = words_of(b, letter)
    place = place[b.words.block[place] == block]
    return float(b.numbers(place[:1])[0]) if len(place) else None


def _tool(b: Batch, block: int) -> int:
    """The tool in the spindle at a block: the last T when the last M6 came."""
    w = b.words
    change = words_of(b, "M")
    change = change[
        (w.mantissa[change] == 6) & (w.decimals[change] == 0) & (w.block[change] <= block)
    ]
    if not len(change):
        return b.state.tool_number
    tool = words_of(b, "T")
    tool = tool[w.block[tool] <= w.block[change[-1]]]
    return int(w.mantissa[tool[-1]]) if len(tool) else b.state.next_tool


def _last_name(b: Batch, block: int) -> str:
    """Of a lathe: the offset that the last T names."""
    tool = words_of(b, "T")
    tool = tool[b.words.block[tool] <= block]
    if not len(tool):
        return b.tool
    return tool_named(b, int(tool[-1]))
