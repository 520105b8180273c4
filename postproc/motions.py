"""What a batch of blocks makes the machine do, as columns; the one thing that text and physics both
know.

A axes in the machine's order, N motions in program order. Positions are int64 ticks
(postproc.units) of slide position in machine coordinates, radius, whatever the program wrote.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from functools import cache
from typing import Any

import numpy as np

from postproc.records import columns, names, replace
from postproc.spaces import Space

# 0 to 3 are G0 to G3, whatever the language calls them
RAPID, FEED, CLOCKWISE, COUNTER, HOLE, THREAD, SPLINE, FOREIGN = 0, 1, 2, 3, 4, 5, 6, 9
LINES = (RAPID, FEED)
# (10,) bool: whether a code is that of a feed along a line or an arc
CUTS = np.zeros(FOREIGN + 1, bool)
CUTS[[FEED, CLOCKWISE, COUNTER]] = True


@columns
class Arcs:
    """The n arcs among the motions; plane axes are rows of the machine's axes.

    motion (n,): which motion. first, second (n,): axes of the plane (G17 X Y, G18 Z X, G19 Y Z).
    centre (2, n): mm, machine coordinates. angle (n,): rad, of the start seen from the centre.
    sweep (n,): rad, whole way, + is counter-clockwise from `first` to `second`. radius, radius_end
    (n,): mm. grid (2, n): ticks of one least increment of the two centre words. words (3, n): word
    index of the two centre words and of R, -1 where not written.
    absolute (2, n): whether the centre words are absolute; origin (2, n): ticks, their zero if so.
    by_radius (n,): ticks, the R word with its sign, 0 where a centre is written; radius_alone (n,):
    whether the control takes no centre there.
    """

    motion: np.ndarray
    first: np.ndarray
    second: np.ndarray
    centre: np.ndarray
    angle: np.ndarray
    sweep: np.ndarray
    radius: np.ndarray
    radius_end: np.ndarray
    grid: np.ndarray
    words: np.ndarray
    absolute: np.ndarray
    origin: np.ndarray
    by_radius: np.ndarray
    radius_alone: np.ndarray

    def __len__(self) -> int:
        return len(self.motion)


def centre_by_radius(
    start: np.ndarray, end: np.ndarray, radius: np.ndarray, counter: np.ndarray
) -> np.ndarray:
    """(2, n): the centre of arcs with an R word, from start and end (2, n) and R with its sign:
    left of the chord for a short counter-clockwise arc, else right of it; in its middle where R is
    too short."""
    chord = end - start
    length = np.hypot(*chord)
    #            +         R > 0 counter-clockwise, R < 0 clockwise
    #            |         height**2 + (length / 2)**2 = R**2
    #     start  o------> o end, the chord; `normal` is it turned by +90 degrees
    #            |
    #            +         R > 0 clockwise, R < 0 (more than half a turn) counter-clockwise
    height = np.sqrt(np.maximum(radius**2 - (length / 2) ** 2, 0.0))
    side = np.where(counter == (radius > 0), 1.0, -1.0)
    normal = np.stack([-chord[1], chord[0]]) / np.where(length > 0, length, 1.0)
    return (start + end) / 2 + normal * (height * side)


@columns
class Holes:
    """The n holes of canned cycles among the motions: a HOLE goes to its place, down to the bottom
    and back up.

    motion (n,): which motion. axis (n,): row of the axis that drills. bottom, level (n,): ticks,
    machine coordinates, of the bottom and of R. zero (n,): ticks, where the bottom's word counts
    from. word (n,): index of that word, -1 where it is not written; first (n,): whether no hole of
    its cycle comes before it. initial (n,): whether the axis returns to where it was before the
    cycle, else to R; higher (n,): whether R lies there too, and it returns to the higher of both.
    flush (n,): whether R lies there, and may come to lie no higher, since the control is not known
    to go back to R then; level_word (n,): index of its word, -1 elsewhere and where it is not
    written. tap (n,): whether its feed is tied to the spindle, so that it can not be written out;
    place (n,): whether the cycle goes to its place, else the axes stand there already.
    """

    motion: np.ndarray
    axis: np.ndarray
    bottom: np.ndarray
    level: np.ndarray
    zero: np.ndarray
    word: np.ndarray
    first: np.ndarray
    initial: np.ndarray
    higher: np.ndarray
    flush: np.ndarray
    level_word: np.ndarray
    tap: np.ndarray
    place: np.ndarray

    def __len__(self) -> int:
        return len(self.motion)


@columns
class Presets:
    """The n words by which a block gives the place where the machine stands a new coordinate (G92
    X).

    motion (n,): how many motions come before it; axis (n,): row; word (n,): index of the word;
    scale (n,): ticks of one whole unit of it; places (n,): decimals of a least increment; sent
    (n,): whether G28 has taken the axis elsewhere since the motion before.
    """

    motion: np.ndarray
    axis: np.ndarray
    word: np.ndarray
    scale: np.ndarray
    places: np.ndarray
    sent: np.ndarray

    def __len__(self) -> int:
        return len(self.motion)


@columns
class Spells:
    """Parts in time of motions that last so long that heat moves the machine meanwhile.

    motion (n,): which motion, in order; until (n,): t of the motion at which it ends, the last at
    1; heat (D, n): whole steps of the drivers in it.
    """

    motion: np.ndarray
    until: np.ndarray
    heat: np.ndarray

    def __len__(self) -> int:
        return len(self.motion)


@cache
def no_arcs() -> Arcs:
    """None."""
    i, f = np.zeros(0, np.int64), np.zeros(0)
    two, three = np.zeros((2, 0)), np.zeros((3, 0), np.int64)
    ticks = two.astype(np.int64)
    return Arcs(i, i, i, two, f, f, f, f, ticks, three, two.astype(bool), ticks, i, i.astype(bool))


@cache
def no_spells() -> Spells:
    """None."""
    i = np.zeros(0, np.int64)
    return Spells(i, np.zeros(0), np.zeros((0, 0), np.int64))


@cache
def no_holes() -> Holes:
    """None."""
    i = np.zeros(0, np.int64)
    no = i.astype(bool)
    return Holes(i, i, i, i, i, i, no, no, no, no, i, no, no)


@cache
def no_presets() -> Presets:
    """None."""
    i = np.zeros(0, np.int64)
    return Presets(i, i, i, i, i, i.astype(bool))


@columns
class Motions:
    """Columns of motions.

    block (N,); code (N,): RAPID, FEED, CLOCKWISE, COUNTER; HOLE; THREAD for a feed that is tied to
    the spindle; SPLINE: the target is a control point of a B-spline; FOREIGN for what can not be
    followed.
    start, target (A, N): ticks; start_known, target_known (A, N). word (A, N): index of the
    axis' word, or -1; incremental (A, N): whether the axis' word is (or would be) a distance.
    grid (A, N): ticks of one least increment of that word; scale (A, N): ticks of one whole unit of
    it; origin (A, N): ticks, where its zero lies when it is absolute; places (A, N): decimals of a
    least increment. alone (N,): left as written (G53). feed_word (N,): index of the F word, or -1;
    inverse (N,): G93; feed (N,): the F number that holds. code_word (N,): index of its motion G
    word, or -1; renamed (N,): whether a motion code was named in a block since the motion before.
    cutter (N,): FREE, OFFSET (inside cutter radius compensation: nothing may be put in), or ENTRY
    (its start-up or end: not to be cut either); plane (2, N): rows of that plane's axes, -1 where
    there is none; radius (N,): mm, of the tool, + where its centre lies left of the path, nan where
    it is not stated; nose (2, N): mm along the plane's axes from that centre to the point that the
    control drives (lathe tools with an orientation). relative (N,): whether G91 is in force. sent
    (A, N): whether something else (G28) has taken the axis elsewhere since the motion before.
    changed (A, N): whether a tool change has taken the axis away and no block has named it since.
    length (A, N): ticks of the tool's length in force. stop (N,): ten times the code that makes it
    end in an exact stop (G61, G9), 0: none. whole (N,): a thread that must stay one block; lead
    (N,): mm per turn of a thread, 0: not said. spaced (N,): whether the block of a control point
    says its interval of knots. reason (N,): index into `reasons`, 0: none, of why a correction can
    not be trusted here. space (N,): index into `spaces`, 0: slide positions; else X
    Y Z of start and target are places of the tool tip in that frame. heat (D, N): whole steps of
    what drives the machine's growth (machine/growth.py) in the middle of each motion; no rows where
    nobody follows it; spells: of motions that are to be cut in time. alike: what others have worked
    out, under keys of their own, of motions that differ from these by start and target alone; None:
    nothing is kept.
    """

    block: np.ndarray
    code: np.ndarray
    start: np.ndarray
    target: np.ndarray
    start_known: np.ndarray
    target_known: np.ndarray
    word: np.ndarray
    incremental: np.ndarray
    grid: np.ndarray
    scale: np.ndarray
    origin: np.ndarray
    places: np.ndarray
    alone: np.ndarray
    inverse: np.ndarray
    feed: np.ndarray
    feed_word: np.ndarray
    code_word: np.ndarray
    reason: np.ndarray
    renamed: np.ndarray
    arcs: Arcs
    reasons: list[tuple[str, str]] = field(default_factory=lambda: [("", "")])
    holes: Holes = field(default_factory=no_holes)
    presets: Presets = field(default_factory=no_presets)
    cutter: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int8))
    plane: np.ndarray = field(default_factory=lambda: np.zeros((2, 0), np.int64))
    radius: np.ndarray = field(default_factory=lambda: np.zeros(0))
    nose: np.ndarray = field(default_factory=lambda: np.zeros((2, 0)))
    length: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), np.int64))
    relative: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    sent: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), bool))
    changed: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), bool))
    stop: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int16))
    whole: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    lead: np.ndarray = field(default_factory=lambda: np.zeros(0))
    spaced: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    space: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    spaces: list[Space | None] = field(default_factory=lambda: [None])
    heat: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), np.int64))
    spells: Spells = field(default_factory=no_spells)
    alike: dict[object, dict[str, object]] | None = None

    def __len__(self) -> int:
        return len(self.block)

    def recall(self, thing: object, key: object, work_out: Callable[[], None]) -> None:
        """Let `work_out` set what it sets of a thing, which start and target have no say in; where
        that was done of motions like these, under the same key, take over what it has set."""
        if self.alike is None:
            work_out()
        elif key in self.alike:
            thing.__dict__.update(self.alike[key])
        else:
            # what it sets is told by what is there afterwards: `work_out` need not name it
            before = set(thing.__dict__)
            work_out()
            self.alike[key] = {x: v for x, v in thing.__dict__.items() if x not in before}

    def part(self, first: int, stop: int) -> Motions:
        """Motions first to stop - 1 alone; blocks and words keep their numbers. Presets and
        spells are left out."""
        columns = {name: getattr(self, name)[..., first:stop] for name in _COLUMNS[Motions]}
        tables = {}
        for name in ("arcs", "holes"):
            table = getattr(self, name)
            # both tables are in the order of motions: their rows of a part stand together
            low, high = (int(np.searchsorted(table.motion, k)) for k in (first, stop))
            rows = {f: getattr(table, f)[..., low:high] for f in names(type(table))}
            tables[name] = type(table)(**{**rows, "motion": rows["motion"] - first})
        return Motions(**columns, **tables, reasons=self.reasons, spaces=self.spaces)


def no_motions(
    axes: int, reasons: list[tuple[str, str]], presets: Presets, space: Space | None
) -> Motions:
    """None, of a machine with so many axes, with what is said of the batch."""
    return replace(_nothing(axes), reasons=reasons, presets=presets, spaces=[None, space])


@cache
def _nothing(axes: int) -> Motions:
    i, no = np.zeros(0, np.int64), np.zeros(0, bool)
    places, which = np.zeros((axes, 0), np.int64), np.zeros((axes, 0), bool)
    return Motions(
        block=i, code=i.astype(np.int8), start=places, target=places,
        start_known=which, target_known=which, word=places, incremental=which, grid=places,
        scale=places, origin=places, places=places, alone=no, inverse=no, feed=np.zeros(0),
        feed_word=i, code_word=i, reason=i, renamed=no, arcs=no_arcs(), length=places, sent=which,
        changed=which,
    )  # fmt: skip


FREE, OFFSET, ENTRY = 0, 1, 2  # values of Motions.cutter


def join(parts: list[Motions], blocks: list[int], words: list[int]) -> Motions:
    """One table of several, whose blocks and words begin at these numbers."""
    if len(parts) == 1 and not blocks[0] and not words[0]:
        return parts[0]
    begin = 0
    reasons: list[tuple[str, str]] = [("", "")]
    spaces: list[Space | None] = [None]
    columns: dict[tuple[type, str], list[np.ndarray]] = {}
    for part, block, word in zip(parts, blocks, words, strict=True):
        # what counts something, from which number on it does, and what came before this part
        # Columns that number something go on where the part before ended; -1 ("not written") and 0
        # ("no reason", "slide positions") mean nothing and stay, hence the least value from which
        # each counts.
        counts = {"block": (NEVER, block), "motion": (NEVER, begin)}
        counts |= {"reason": (1, len(reasons) - 1), "space": (1, len(spaces) - 1)}
        counts |= dict.fromkeys(
            ("word", "feed_word", "code_word", "words", "level_word"), (0, word)
        )
        for table in (part, part.arcs, part.holes, part.presets):
            for name in _COLUMNS[type(table)]:
                least, by = counts.get(name, (0, 0))
                column = getattr(table, name)
                if by:
                    column = np.where(column >= least, column + by, column)
                columns.setdefault((type(table), name), []).append(column)
        begin += len(part)
        reasons += part.reasons[1:]
        spaces += part.spaces[1:]

    def joined(kind: type) -> dict[str, Any]:
        return {n: np.concatenate(c, axis=-1) for (k, n), c in columns.items() if k is kind}

    return Motions(
        **joined(Motions), reasons=reasons, spaces=spaces, spells=no_spells(),
        arcs=Arcs(**joined(Arcs)), holes=Holes(**joined(Holes)), presets=Presets(**joined(Presets)),
    )  # fmt: skip


NEVER = -(1 << 62)  # a number below all that a column counts
_COLUMNS: dict[type, tuple[str, ...]] = {
    kind: tuple(
        name
        for name in names(kind)
        if name not in ("arcs", "holes", "presets", "reasons", "spaces", "spells", "alike")
    )
    for kind in (Motions, Arcs, Holes, Presets)
}
