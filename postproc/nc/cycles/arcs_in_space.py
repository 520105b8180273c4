"""Arcs whose plane a turn has tilted, as straight lines within the tolerance.

The arc is the one of the programmed plane, carried along by the turn, as a circle in space that no
plane of the control holds. LinuxCNC, src/emc/task/emccanon.cc, ARC_FEED: the end, the centre, and
the axis of the arc are turned alike (`to_rotated(normal_cart)`); Siemens, Programming Manual
Fundamentals, "Frames": the working plane turns with the frame.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from postproc.nc.cycles.affine import AXES, Point
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.moves import END_OF_PROGRAM_OR_STOP, own_words
from postproc.nc.cycles.pole_arc import Arc, by_radius, ends
from postproc.nc.cycles.scene import CENTRES, COUNTER, Scene
from postproc.nc.expand.tracker import number

KEPT = (*"NGFSTDHMXYZIJKR", "CR")  # letters of a block that is written out
# The frame behind turns these places and rounds once more; four digits keep the first rounding out
# of the result.
MORE_DECIMALS = 4  # of the lines before they are turned


def check(scene: Scene, block: Block, why: str) -> None:
    """Raises ProgramError for an arc that is not written out here."""
    what = next((w.letter for w in block.words if w.letter not in KEPT), "")
    if scene.compensated:
        what = "cutter radius compensation on"
    elif scene.code("feed mode") == 930:
        what = "inverse time feed (G93)"
    if what:
        raise scene.fault(
            f"an arc that {why} leads out of its plane, with {what}",
            "let the CAM program write it out as short straight lines",
        )


def lines(
    scene: Scene, block: Block, motion: int, centre: Point | None, mixed: Collection[str]
) -> Iterator[bytes]:
    """The straight lines of an arc in programmed coordinates; centre: where its centre words put it
    (X Y Z), None where R says it; mixed: the axes that the turn mixes, written finer than the
    output. Raises ProgramError."""
    first, second, _ = scene.plane
    words = {w.letter: w for w in block.words}
    start = {x: scene.at(x) for x in AXES}
    to = {x: _place(scene, words.get(x), x, start[x]) for x in AXES}
    turn = 1.0 if motion == COUNTER else -1.0
    at, end = (start[first], start[second]), (to[first], to[second])
    if centre is None:
        radius = _radius(scene, words)
        name = radius.letter + "=" * (len(radius.letter) > 1)
        arc = by_radius(scene, at, end, scene.length(radius, first), turn, name)
    else:
        arc = Arc(at, end, (centre[AXES.index(first)], centre[AXES.index(second)]), turn)
    yield from _written(scene, block, motion, (start, to), ends(scene, arc), mixed)


def _written(
    scene: Scene,
    block: Block,
    motion: int,
    between: tuple[dict[str, float], dict[str, float]],
    points: Sequence[tuple[float, float]],
    mixed: Collection[str],
) -> Iterator[bytes]:
    """The block with the words of the first line, and a block for each other line. between: start
    and end; points: the ends of the lines in the plane."""
    (first, second, third), (start, to) = scene.plane, between
    code, written = b"G1", dict(start)
    decimals = {x: scene.decimals(x) + (MORE_DECIMALS if x in mixed else 0) for x in AXES}
    own = own_words(block, (*AXES, *CENTRES.values(), "R", "CR"), (motion,))
    place = min(own)
    after_motion = [w for w in block.words if w.letter == "M" and w.value in END_OF_PROGRAM_OR_STOP]
    own |= {block.words.index(w) for w in after_motion}
    sep = b" " if block.spaced else b""
    for k, (a, b) in enumerate(points, 1):
        # As a helix: the way across the plane goes in proportion to the angle, and all lines of one
        # arc have the same angle.
        along = start[third] + (to[third] - start[third]) * k / len(points)
        text = sep.join(
            _words({first: a, second: b, third: along}, written, decimals, scene.incremental)
        )
        if k == len(points):
            text = sep.join([text, *(block.text[w.start : w.stop] for w in after_motion)])
        if k == 1:
            yield block.written(own, code + sep + text, place)
        else:
            yield (b"/" if block.skip else b"") + text


def _place(scene: Scene, word: Word | None, axis: str, start: float) -> float:
    """Where an axis word leads."""
    if word is None:
        return start
    incremental = word.mode == "IC" or (word.mode == "" and scene.incremental)
    return scene.length(word, axis) + (start if incremental else 0.0)


def _radius(scene: Scene, words: Mapping[str, Word]) -> Word:
    word = words.get("R") or words.get("CR")
    if word is None:
        raise scene.fault("an arc without its centre words", "write I J K or R")
    return word


def _words(
    to: Mapping[str, float], written: dict[str, float], decimals: Mapping[str, int], by: bool
) -> Iterator[bytes]:
    """The words of a place; by: as distances from what is written already."""
    for axis in AXES:
        base = written[axis] if by else 0.0
        value = round(to[axis] - base, decimals[axis])
        # From what was written, not from the arc: of increments the roundings would add up over its
        # lines.
        written[axis] = base + value
        yield f"{axis}{number(value, decimals[axis])}".encode()
