r"""From arc words to circles: centre, radii and sweep, as the control sees them.

Plane axes are ordered as RS274/NGC 3.5.3 has them: G17 X Y, G18 Z X, G19 Y Z; counter-clockwise
turns the first towards the second. I J K are radii whatever the diameter mode. R gives the shorter
way round, -R the longer.

       end o.                     G3 in G17. I J lead from the start to the centre, or are the
            \ `.  sweep           centre's place (G90.1). `arm`, from the centre to the start,
     arm_end \  `.                stands at `angle` and turns by `sweep`, counter-clockwise above
              \   :               0. That arm_end is as long as arm the control checks: both
        centre o---o start        follow from words that were rounded on their own.
                arm
"""

from __future__ import annotations

import numpy as np

from postproc.motions import CLOCKWISE, COUNTER, Arcs, centre_by_radius, no_arcs
from postproc.nc.batch import Batch
from postproc.nc.columns import spread
from postproc.nc.face import planes
from postproc.nc.grammar import ABSOLUTE, RELATIVE
from postproc.nc.positions import Places
from postproc.nc.queries import word_column
from postproc.records import columns
from postproc.units import TICKS_PER_MM

MOST_TURNS = 1000


@columns
class Circle:
    """The modal columns that arcs need, at the N moving blocks: plane code, whether centres are
    absolute, G53."""

    block: np.ndarray
    code: np.ndarray
    plane: np.ndarray
    absolute: np.ndarray
    alone: np.ndarray


def arcs_of(
    batch: Batch, places: Places, circle: Circle, centre_words: dict[str, np.ndarray]
) -> Arcs:
    """The arcs of a batch. What is wrong with one becomes its motion's reason: it matters only
    where it is corrected."""
    arc = ((circle.code == CLOCKWISE) | (circle.code == COUNTER)).nonzero()[0]
    if not len(arc):
        return no_arcs()
    n, words = len(arc), batch.words
    word = {}
    for letter in "IJKR":
        word[letter] = word_column(batch, centre_words.get(letter))[circle.block[arc]]
    # rows of the plane's axes, -1 where the machine lacks one; centre_word: indices of words of the
    # first, the second, and of R; grid (2, n): ticks of a least increment
    first, second = np.full(n, -1), np.full(n, -1)
    # unit (n,): ticks of one unit, 1 mm or 1 inch, for I J K R are never diameters
    centre_word, grid, unit = np.full((3, n), -1), np.ones((2, n), np.int64), np.ones(n, np.int64)
    for plane, (a, b, i, j) in planes(batch).items():
        of = (circle.plane[arc] == plane).nonzero()[0]
        if not len(of):
            continue
        blocks = circle.block[arc[of]]
        if a in batch.rows and b in batch.rows:
            first[of], second[of] = batch.rows[a], batch.rows[b]
        else:
            batch.blame(
                blocks,
                f"an arc in the {a}{b} plane, and the machine has no such axes",
                "choose the plane with G17, G18 or G19",
            )
        centre_word[0, of], centre_word[1, of] = word[i][of], word[j][of]
        other = word["IJK".replace(i, "").replace(j, "")][of]
        strange = other >= 0
        if batch.dialect.skips_centre:
            strange &= (words.mantissa[np.maximum(other, 0)] != 0) | (word["R"][of] >= 0)
        batch.blame(
            blocks[strange],
            f"a centre word that does not belong to the {a}{b} plane",
            f"use {i} and {j}, or change the plane",
        )
        for k, letter in enumerate((a, b)):
            scale, least = batch.unit_scale(letter)
            grid[k, of] = np.broadcast_to(least, batch.n)[blocks]
            unit[of] = np.broadcast_to(scale, batch.n)[blocks]
    centre_word[2] = word["R"]
    both = (centre_word[2] >= 0) & (np.maximum(centre_word[0], centre_word[1]) >= 0)
    batch.blame(
        circle.block[arc][both],
        "an arc with a centre and with R",
        "controls disagree on which one holds: keep one",
    )
    # from here on all arcs are worked out, those with a reason too, so that columns stay columns
    good = first >= 0
    row_a, row_b = np.maximum(first, 0), np.maximum(second, 0)
    start = np.stack([places.start[row_a, arc], places.start[row_b, arc]])
    end = np.stack([places.target[row_a, arc], places.target[row_b, arc]])
    known = (
        places.start_known[row_a, arc]
        & places.start_known[row_b, arc]
        & places.target_known[row_a, arc]
        & places.target_known[row_b, arc]
    )
    blocks = circle.block[arc]
    batch.blame(
        blocks[~known & good],
        "an arc that begins at an unknown place",
        "move every axis to an absolute position first, or say --start",
    )
    counter = circle.code[arc] == COUNTER
    value = np.zeros((3, n), np.int64)
    for k, own in enumerate(centre_word):
        written = (own >= 0).nonzero()[0]
        if len(written):
            value[k, written] = batch.ticks(own.take(written), unit.take(written))
    by_radius = centre_word[2] >= 0
    written = (
        words.letter[np.maximum(centre_word[:2], 0)]
        if len(words.letter)
        else np.zeros((2, n), np.uint8)
    )
    # Siemens says it in the word, I=AC(5) or I=IC(5); others by the mode that holds.
    by_letter = (centre_word[:2] >= 0) & (written >= RELATIVE)
    stated = np.where(by_letter, written >= ABSOLUTE, circle.absolute[arc])
    absolute = stated & ~by_radius
    origin = np.stack([places.origin[row_a, arc], places.origin[row_b, arc]])
    # A distance that is not written is 0; of a place both words are needed.
    one = np.where(circle.absolute[arc], centre_word[:2].min(axis=0), centre_word[:2].max(axis=0))
    missing = ~by_radius & (one < 0)
    batch.blame(
        blocks[missing & good],
        "an arc without its centre words",
        "write both of I J K of the plane, or R",
    )
    centre = np.where(absolute, value[:2] + origin, start + value[:2]) / TICKS_PER_MM
    start_mm, end_mm = start / TICKS_PER_MM, end / TICKS_PER_MM
    if by_radius.any():
        centre = np.where(
            by_radius,
            _centre_by_radius(
                batch, blocks, by_radius, start_mm, end_mm, value[2] / TICKS_PER_MM, counter
            ),
            centre,
        )
    arm, arm_end = start_mm - centre, end_mm - centre
    radius, radius_end = np.hypot(*arm), np.hypot(*arm_end)
    angle = np.arctan2(arm[1], arm[0])
    sweep = np.arctan2(arm_end[1], arm_end[0]) - angle
    # By ticks, not by the angle: an end that equals the start to the last digit makes a full
    # circle, one that is a rounding away from it an arc of next to nothing, or of nearly a turn.
    same = (start == end).all(axis=0)
    # arctan2 leaves it within a turn either way: a whole turn is added where the sign is not that
    # of the code, so that it is above 0 and up to 2 pi counter-clockwise, likewise below 0
    # clockwise.
    sweep = np.where(
        counter,
        np.where(sweep <= 0, sweep + 2 * np.pi, sweep),
        np.where(sweep >= 0, sweep - 2 * np.pi, sweep),
    )
    sweep = np.where(same, np.where(counter, 2 * np.pi, -2 * np.pi), sweep)
    sweep = _turns(batch, circle, arc, sweep)
    _check(batch, blocks, good & known & ~missing, radius, radius_end)
    return Arcs(
        motion=arc,
        first=first,
        second=second,
        centre=centre,
        angle=angle,
        sweep=sweep,
        radius=radius,
        radius_end=radius_end,
        grid=grid,
        words=centre_word,
        absolute=stated,
        origin=origin,
        by_radius=np.where(by_radius, value[2], 0),
        radius_alone=by_radius & bool(batch.polar and batch.dialect.contour),
    )


def _whole(batch: Batch) -> str:
    """What else may be meant where a number without a point counts least increments."""
    if batch.integers != "least increments":
        return ""
    return (
        "; numbers without a point count least increments here, --integers units takes them whole"
    )


def _centre_by_radius(
    batch: Batch,
    blocks: np.ndarray,
    by_radius: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
    radius: np.ndarray,
    counter: np.ndarray,
) -> np.ndarray:
    """(2, n) mm: the centre; what can not be one is blamed.

    It lies on the line that halves the chord, h beside it: h^2 = R^2 - (length / 2)^2. Where the
    chord is longer than 2 R by a rounding alone, half a circle is meant and h is 0."""
    length = np.hypot(*(end - start))
    tolerance = batch.dialect.radius_tolerance_mm
    short = by_radius & (length / 2 > np.abs(radius) + tolerance)
    for i in short.nonzero()[0][:1]:
        batch.blame(
            blocks[short],
            f"R {abs(radius[i]):.4f} is too short: the end lies {length[i]:.4f} mm away (diameter"
            f" {2 * abs(radius[i]):.4f})",
            f"check R and the end point{_whole(batch)}",
        )
    batch.blame(
        blocks[by_radius & (length == 0)],
        "an R arc that ends where it begins has no centre",
        "write full circles with I J K",
    )
    return centre_by_radius(start, end, radius, counter)


def _turns(batch: Batch, circle: Circle, arc: np.ndarray, sweep: np.ndarray) -> np.ndarray:
    """P counts full turns where the dialect says so; elsewhere it has no business in an arc."""
    place = batch.places.get("P")
    if place is None:
        return sweep
    of = word_column(batch, place)[circle.block[arc]]
    has = of >= 0
    if not batch.dialect.turns:
        batch.blame(circle.block[arc][has], "P in an arc", "this control has no turns in arcs")
        return sweep
    least = batch.dialect.first_turn
    turns = np.where(has, batch.numbers(np.maximum(of, 0)), float(least))
    wrong = (turns < least) | (turns != np.floor(turns))
    batch.blame(
        circle.block[arc][wrong],
        "the turns of an arc are not a whole number",
        f"write {least}, {least + 1}, ...",
    )
    many = (turns > MOST_TURNS).nonzero()[0]
    if len(many):
        raise batch.fault(
            int(of[many[0]]),
            f"an arc of {turns[many[0]]:g} turns (limit {MOST_TURNS})",
            "write the turns in several blocks",
        )
    # P2 of a control that counts from 1 is one turn more than the way to the end
    result: np.ndarray = sweep + np.sign(sweep) * np.maximum(turns - least, 0.0) * 2 * np.pi
    return result


def _check(
    batch: Batch, blocks: np.ndarray, good: np.ndarray, radius: np.ndarray, radius_end: np.ndarray
) -> None:
    """The control's radius check: both arms may differ by a length, and on large arcs by a share of
    the radius, up to a length that is too much on any (the dialect says all three)."""
    d = batch.dialect
    miss = np.abs(radius - radius_end)
    largest = np.maximum(radius, radius_end)
    inch = spread(batch.held("units"), batch.n)[blocks] == 200
    more = np.where(inch, d.arc_tolerance_inch, 1.0)
    limit = d.arc_tolerance_mm * more
    wrong = (miss > d.arc_tolerance_most_mm * more) | (
        (miss > limit) & (miss > d.arc_tolerance_relative * largest)
    )
    # from the centre to itself there is no direction
    zero = (np.minimum(radius, radius_end) < d.radius_tolerance_mm) & good
    batch.blame(blocks[zero], "an arc of radius 0", "check I J K")
    bad = (wrong & good & ~zero).nonzero()[0]
    for i in bad:
        arc_tolerance_mm = limit[i]
        batch.blame(
            blocks[i : i + 1],
            f"the arc misses its own end point by {miss[i]:.4f} mm (limit"
            f" {arc_tolerance_mm:.4g} mm)",
            "I J K were read as "
            + ("absolute" if batch.held_absolute(blocks[i]) else "incremental")
            + f": if the program means it the other way, say so with --arc-centre{_whole(batch)}",
        )
