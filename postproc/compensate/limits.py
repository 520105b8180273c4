"""What is refused: motions that can not be trusted, places outside the tables or the travel,
corrections too large."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from postproc.compensate.batch import Batch
from postproc.compensate.settings import EDGE
from postproc.errors import MotionFault, Notice
from postproc.expressions import expression
from postproc.flags import any_of
from postproc.machine.chain import ROTARY
from postproc.machine.model import Machine
from postproc.machine.polar import NEAREST, PolarMachine
from postproc.machine.tip import TipMachine
from postproc.motions import COUNTER, FEED, RAPID
from postproc.units import TICKS_PER_MM, UM, in_mm

# by number, of Haas and Fanuc with P, of Siemens, of Okuma, of Heidenhain
WORK_OFFSET = expression(
    r"G5[4-9](?:\.\d)?(?: ?P\d+)?|G1[125]\d(?: ?P\d+)?|G5\d\d|G15 ?H\d+|G247 ?P\d+"
)
LOOKS = 9  # places on a motion at which the slides that hold the tip are looked at
UNKNOWN = (
    "motions left as they are: {0} (feeds: {1}); feeds corrected at their ends alone: {2}; where"
    " the axes stand there is not known (--start, or home in machine.toml, says where a program"
    " begins and where G28 goes)"
)
BEYOND_TABLE = "stay inside it, measure further out, or hold the end value with --outside clamp"
BEYOND_TRAVEL = "the slide can not go there: move the part or the work offset"
AT_STOP = (
    "motions left as they are, since an axis stands at the end of its travel and its correction"
    " leads beyond: {0}"
)


def refuse(b: Batch) -> None:
    bad = b.m.reason.nonzero()[0]
    if len(bad):
        raise MotionFault(int(bad[0]), *b.m.reasons[int(b.m.reason[bad[0]])])


def refuse_turning_arcs(b: Batch) -> None:
    """An arc while a rotary axis turns is no arc of the tool's path on the part; its correction
    bends all along."""
    arcs = b.m.arcs.motion
    rows = list(b.machine.turning) if len(arcs) else []
    if not rows:
        return
    turns = ((b.m.target - b.m.start)[rows][:, arcs] != 0).any(axis=0) & b.free[arcs]
    for i in turns.nonzero()[0][:1]:
        raise MotionFault(
            int(arcs[i]),
            f"an arc while {' '.join(b.machine.letters[row] for row in rows)} turns",
            "let the CAM program write such motions as short lines",
        )


def check_unknown(b: Batch) -> None:
    """What can not be corrected since a place is not known: a rapid is left as it is, and a feed
    where a program begins like that (printers, routers) or where it leads the new tool over the
    part before its length holds (CAM programs without rapids write G1 there); elsewhere it is
    refused. All that is left is counted, and said."""
    if b.every or not np.count_nonzero(~(b.known & b.start_known)):
        return
    lost = ~b.known & ~b.m.alone
    feeds = lost & (b.m.code != RAPID)
    fault = None
    barred = np.zeros(len(b.m), bool)
    if not b.options.passes_unknown:
        barred = (b.places.wanting & ~b.m.changed).any(axis=0)
    refused = feeds & (barred | (b.m.code != FEED))
    for i in (refused if refused.any() else feeds).nonzero()[0][:1]:
        axes = " ".join(x for k, x in enumerate(b.machine.letters) if b.places.wanting[k, i])
        fault = MotionFault(
            int(i),
            f"where {axes} stands is not known here, and the correction depends on it",
            f"move {axes} to an absolute position first; or, if no homing, levelling, macro, tool"
            f" change or change of its length comes before, say where it is: --start"
            f" {','.join(f'{x}100' for x in axes.split())}",
        )
        if refused.any():  # an arc from a corrected place to one that is not would miss its end
            raise fault
    half = b.free & ~b.start_known & (b.m.code == FEED)
    left = lost | half
    for i in left.nonzero()[0][:1]:
        counts = (int(lost.sum()), int(feeds.sum()), int(half.sum()))
        never = (fault.message, fault.advice) if fault else ("", "")
        i = fault.motion if fault else i
        b.notices.append(Notice("unknown", UNKNOWN, int(i), refusal=never, counts=counts))


def check_inside(b: Batch) -> None:
    """Nominal points must lie in the tables, unless they may be held at the ends."""
    _check_arcs(b)
    if b.c.outside == "clamp":
        return
    lowest, highest = b.c.covered
    outside = (b.end_nominal < lowest) | (b.end_nominal > highest)
    if not (any_of(outside) or len(b.m.arcs)):
        return
    free = b.free[b.motion]
    for row, letter in enumerate(b.machine.letters):
        ranges = b.machine.ranges.get(letter)
        if ranges is None:
            continue
        first, last = ranges
        low, high = first - EDGE, last + EDGE
        value, bad = b.end_nominal[row], outside[row]
        bad &= b.m.target_known[row, b.motion] & free
        if len(b.m.arcs):
            extent = _arc_extent(b, row, first)
            bad |= (extent[0] < low) | (extent[1] > high)
        for i in bad.nonzero()[0][:1]:
            worst = value[i]
            if low <= worst <= high:
                worst = extent[0, i] if extent[0, i] < low else extent[1, i]
            raise MotionFault(
                int(b.motion[i]),
                f"{letter} = {worst:.4f} {unit_of(letter)} lies outside the error table of {letter}"
                f" ({first:g} to {last:g} {unit_of(letter)})",
                BEYOND_TABLE,
            )


def check_poses(b: Batch) -> None:
    """The slides that hold the tip must stay within their travels and tables all along; rapids
    count by their ends."""
    if not isinstance(b.machine, TipMachine):
        return
    which = (b.free[b.motion] & (b.m.code[b.motion] <= COUNTER)).nonzero()[0]
    if not len(which):
        return
    way = b.known_before[which] & (b.m.code[b.motion[which]] != RAPID)
    for t in np.linspace(0.0, 1.0, LOOKS):
        stroke = which if t == 1.0 else which[way]
        if not len(stroke):
            continue
        there = b.t0[stroke] + (b.t1 - b.t0)[stroke] * t
        slides = b.machine.slides(b.nominal(b.motion[stroke], there))
        _check_slides(b, b.machine.base, stroke, slides)


def check_ended_poses(b: Batch) -> None:
    """Where the slides that hold the corrected tip end, too."""
    if isinstance(b.machine, TipMachine):
        known = b.m.target_known.all(axis=0) & b.free & (b.m.code <= COUNTER)
        stroke = known[b.motion].nonzero()[0]
        slides = b.machine.slides(in_mm(b.end.take(stroke, axis=1)))
        _check_slides(b, b.machine.base, stroke, slides, " (nominal and correction)")


def _check_slides(
    b: Batch, base: Machine, stroke: np.ndarray, slides: np.ndarray, of: str = ""
) -> None:
    """slides (A, n): where they stand at these strokes (n,); of: what that place is made of."""
    for row, letter in enumerate(b.machine.letters):
        if letter not in base.chain.axes:
            continue
        (low, high), what = base.axes[letter].travel, "travel"
        if not of and b.c.outside == "error" and letter in base.ranges:
            first, last = base.ranges[letter]
            (low, high), what = (max(low, first), min(high, last)), "travel or the error table"
        for i in ((slides[row] < low - EDGE) | (slides[row] > high + EDGE)).nonzero()[0][:1]:
            raise MotionFault(
                int(b.motion[stroke[i]]),
                f"to hold the tip there {letter} goes to {slides[row, i]:.4f}"
                f" {unit_of(letter)}{of}, beyond the {what} of {letter} ({low:g} to {high:g}"
                f" {unit_of(letter)})",
                "check the work offset, the tool's length, and the centres of the rotary axes"
                " in machine.toml",
            )


def check_pole(b: Batch) -> None:
    """On a face nothing is corrected next to C's line, where C turns half around at once; rapids
    count by their ends."""
    if not isinstance(b.machine, PolarMachine):
        return
    which = (b.free & (b.m.code <= COUNTER)).nonzero()[0]
    for i in which[_nearest(b, b.machine, which) < NEAREST][:1]:
        raise MotionFault(
            int(i),
            f"the tool comes nearer than {NEAREST:g} mm to the line of C, where C turns half around"
            " within the width of a correction",
            "keep away from the middle in polar interpolation: bore it with C at rest",
        )


def _nearest(b: Batch, machine: PolarMachine, motion: np.ndarray) -> np.ndarray:
    """(K,) mm from C's line to the nearest place of motions."""
    x, c = (machine.letters.index(letter) for letter in "XC")
    # The face as the complex plane, X + i C, with C's line at 0:
    #
    #   start ----+------> end      the foot of the perpendicular from 0 lies at t = Re(-start *
    #             |                 conj(way)) / |way|^2 of the way, its dot product; before 0 and
    #             0                 beyond 1 an end is nearest
    start, end = (
        (p[x].take(motion) + 1j * p[c].take(motion)) / TICKS_PER_MM for p in (b.m.start, b.m.target)
    )
    way = np.where((b.m.code[motion] != RAPID) & b.start_known[motion], end - start, 0.0)
    along = np.where(way != 0, np.real(-start * np.conj(way)), 1.0)
    t = np.clip(along / np.where(way != 0, np.abs(way) ** 2, 1.0), 0.0, 1.0)
    near: np.ndarray = np.abs(np.where(way != 0, start + way * t, end))
    arcs = b.m.arcs
    order = np.argsort(arcs.motion)
    on = np.isin(motion, arcs.motion).nonzero()[0]
    arc = order[np.searchsorted(arcs.motion[order], motion[on])]
    centre = arcs.centre[0, arc] + 1j * arcs.centre[1, arc]
    # Of a circle the place on the ray from its centre through 0 is nearest, if the arc passes it.
    towards = np.angle(-centre) - arcs.angle[arc]
    passed = (np.sign(arcs.sweep[arc]) * towards) % (2 * np.pi) <= np.abs(arcs.sweep[arc])
    ends = np.minimum(np.abs(start[on]), np.abs(end[on]))
    near[on] = np.where(passed, np.abs(np.abs(centre) - arcs.radius[arc]), ends)
    return near


def tell_play(b: Batch) -> None:
    """Say that no lost motion is taken up in blocks of the tip where the mean of both directions is
    asked for by --reversal off: nothing is spread there."""
    if (
        not isinstance(b.machine, TipMachine)
        or not b.machine.base.two_way.any()
        or b.c.follows
        or b.options.reversal != "off"
    ):
        return
    # The mean of both tables leaves half of forward - reverse, one way or the other.
    half: dict[str, float] = {}
    for letter, table in b.machine.base.every_table:
        half[letter] = half.get(letter, 0.0) + float(
            np.linalg.norm(np.abs(table.half[:3]).max(axis=1))
        )
    for grid in b.machine.base.grids:
        half[grid.letter] = (
            half.get(grid.letter, 0.0) + float(np.abs(grid.forward - grid.reverse)[:3].max()) / 2
        )
    axes = " ".join(x for x, row in half.items() if row)
    left = float(np.linalg.norm(list(half.values())))
    for i in b.free.nonzero()[0][:1]:
        said = (
            f"lost motion of {axes} is corrected by the mean of both directions where X Y Z are"
            f" places of the tool tip or of a tilted plane: up to {left / UM:.1f} um of it stay"
        )
        b.notices.append(Notice("lost motion of the tip", said, int(i)))


def tell_orientation(b: Batch) -> None:
    """Say once that feeds between places of the slides keep their lean, where orientation was asked
    for."""
    if b.options.orientation and not (isinstance(b.machine, TipMachine) and b.machine.oriented):
        for i in (b.free & (b.m.code == FEED)).nonzero()[0][:1]:
            said = (
                "--orientation holds where the control holds the tool tip; elsewhere the tip is"
                " corrected, and the tool leans as it did"
            )
            b.notices.append(Notice("orientation", said, int(i)))


def unit_of(letter: str) -> str:
    return "degrees" if letter in ROTARY else "mm"


def _check_arcs(b: Batch) -> None:
    """No arc may lead beyond the travel on its way: no slide goes there, and a circle of a
    kilometre would be cut for hours."""
    for row in b.rows if len(b.m.arcs) else ():
        letter = b.machine.letters[row]
        if letter not in b.machine.tables:
            continue
        low, high = b.machine.axes[letter].travel
        place = b.extremes[1][row]
        if not any_of((place < low - EDGE) | (place > high + EDGE)):
            continue
        extent = _arc_extent(b, row, low)
        for i in ((extent[0] < low - EDGE) | (extent[1] > high + EDGE)).nonzero()[0][:1]:
            worst = extent[0, i] if extent[0, i] < low - EDGE else extent[1, i]
            raise MotionFault(
                int(b.motion[i]),
                f"the arc leads to {letter} = {worst:.4f} mm, beyond the travel of {letter}"
                f" ({low:g} to {high:g} mm)",
                "check its centre, and the work offset",
            )


def _arc_extent(b: Batch, row: int, neutral: float) -> np.ndarray:
    """(2, S) lowest and highest place on each stroke that is part of an arc; `neutral`
    elsewhere."""
    result = np.full((2, len(b.motion)), neutral)
    first, place = b.extremes
    np.minimum.at(result[0], first, place[row])
    np.maximum.at(result[1], first, place[row])
    return result


def at_stop(b: Batch) -> np.ndarray:
    """(N,) bool: motions that begin or end with an axis at the very end of its travel, where homing
    leaves it, and would lead it beyond."""
    result = np.zeros(len(b.m), bool)
    free = (b.free & (b.m.code <= FEED))[b.motion]
    for row in b.rows:
        edges = b.machine.axes[b.machine.letters[row]].travel
        for nominal, place, correctable in (
            (b.begin_nominal[row], b.begin[row], b.m.start_known[row, b.motion] & b.known_before),
            (b.end_nominal[row], b.end[row], b.m.target_known[row, b.motion]),
        ):
            low, high = (np.abs(nominal - edge) <= EDGE for edge in edges)
            at = place / TICKS_PER_MM
            out = (low & (at < edges[0] - EDGE)) | (high & (at > edges[1] + EDGE))
            result[b.motion[free & correctable & out]] = True
    return result


def check_limits(b: Batch) -> float:
    """Corrections and corrected ends must stay within their limits. Returns the largest correction,
    mm."""
    free = b.moved
    correction = np.abs(b.exact - b.end_nominal)
    if b.fixed:
        correction = correction.take(b.c.at, axis=0)
    if not b.every:
        correction = np.where(b.correctable.take(b.c.at, axis=0), correction, 0.0)
    largest = b.machine.limits.max_correction
    most = float(correction.max(initial=0.0))
    low, high = b.c.travel
    value = in_mm(b.end.take(b.c.at, axis=0))
    beyond = (value < low) | (value > high)
    if not b.every:
        beyond &= free
    if most <= largest and not any_of(beyond):
        return most
    over = np.flatnonzero((correction > largest).any(axis=0))
    faults = [(int(i), "over") for i in over[:1]]
    beyond &= b.m.target_known[b.rows][:, b.motion]
    faults += [
        (int(i), b.machine.letters[axis])
        for axis, row in zip(b.rows, beyond, strict=True)
        for i in row.nonzero()[0][:1]
    ]
    if not faults:
        return most
    i, what = min(faults)
    if what == "over":
        row = int(np.argmax(correction[:, i]))
        letter = b.machine.letters[b.rows[row]]
        raise MotionFault(
            int(b.motion[i]),
            f"the correction of {letter} is {correction[row, i]:.4f} {unit_of(letter)} (limit"
            f" max_correction = {largest:g} mm)",
            "is the map in the right unit, and the work offset right? else raise max_correction in"
            " machine.toml",
        )
    axis = b.machine.axes[what]
    value = b.end[b.machine.letters.index(what), i] / TICKS_PER_MM
    raise MotionFault(
        int(b.motion[i]),
        f"{what} = {value:.4f} mm (nominal and correction) is beyond the travel of {what}"
        f" ({axis.travel[0]:g} to {axis.travel[1]:g} mm)",
        BEYOND_TRAVEL,
    )


def with_zeros(advice: str, offsets: Mapping[str, Mapping[str, float]], axes: str) -> str:
    """The way out of a place that is out of reach, with where zeros were said to lie. offsets: mm,
    by name and axis; axes: letters that the machine has."""
    if advice not in (BEYOND_TABLE, BEYOND_TRAVEL):
        return advice
    work = {name: place for name, place in offsets.items() if WORK_OFFSET.fullmatch(name)}
    if not work:
        place = ",".join(f"{x}0" for x in "XYZ" if x in axes)
        return (
            f"{advice}; no work offset is stated: --offset G54={place} says where the part's zero"
            " lies on the machine"
        )
    said = [
        f"{name} = {' '.join(f'{x}{value:g}' for x, value in place.items())}"
        for name, place in list(work.items())[:3]
    ]
    return f"{advice}; stated: {', '.join(said)}"
