"""From axis words to places: absolute words set a position, incremental ones add to it, all in
whole ticks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from postproc.nc.batch import LINEAR, Batch
from postproc.nc.columns import at, hold_index, hold_last
from postproc.nc.lexer import ABSOLUTE, AXES, BARE, RELATIVE
from postproc.nc.zeros import homed, stated
from postproc.units import TICKS_PER_MM


@dataclass(eq=False, repr=False)
class Places:
    """(A, N) columns of the moving blocks, as in Motions: start, target, what is known, and how
    each axis' word is (or would be) written; sent: whether G28 has taken the axis elsewhere since
    the motion before; end_position, end_known, end_sent (A,): behind the batch."""

    start: np.ndarray
    target: np.ndarray
    start_known: np.ndarray
    target_known: np.ndarray
    word: np.ndarray
    incremental: np.ndarray
    grid: np.ndarray
    scale: np.ndarray
    origin: np.ndarray
    least: np.ndarray
    sent: np.ndarray
    end_sent: np.ndarray
    end_position: np.ndarray
    end_known: np.ndarray


def position(
    b: Batch, block: np.ndarray, axis_words: dict[str, tuple[np.ndarray, np.ndarray]]
) -> Places:
    """Work out (A, N) start, target, what is known, and the words' scales, at the moving blocks."""
    w, n = b.words, b.n
    shape = (len(b.rows), len(block))
    whole = [np.zeros(shape, np.int64) for _ in range(6)]
    p = Places(
        start=whole[0],
        target=whole[1],
        start_known=np.zeros(shape, bool),
        target_known=np.zeros(shape, bool),
        word=np.zeros(shape, np.int64) - 1,
        incremental=np.zeros(shape, bool),
        grid=whole[2],
        scale=whole[3],
        origin=whole[4],
        least=whole[5],
        sent=np.zeros(shape, bool),
        end_sent=np.zeros(len(b.rows), bool),
        end_position=b.state.position.copy(),
        end_known=b.state.known.copy(),
    )
    taken, machine = b.taken, b.machine
    forget = b.loses | b.foreign
    any_taken, any_machine, forgets = map(np.count_nonzero, (taken, machine, forget))
    distance_held, carried_held, inch = (
        b.held("distance"),
        b.held("carried"),
        b.held("units") == 200,
    )
    # whether any word says by itself that it is absolute or a distance
    spelled = any(ord(letter) >= RELATIVE for letter in b.places)
    earlier, from_begin = block - 1, len(block) > 0 and block[0] == 0
    sends = 280 in b.single or 300 in b.single
    was_sent = b.state.sent is not None and np.count_nonzero(b.state.sent)
    nothing = not (len(block) or forgets or sends or was_sent or b.cycle)
    for letter, row in b.rows.items():
        if nothing and not any(map(len, axis_words[letter])):
            continue
        carried = letter in b.dialect.carried  # homing takes the slides away, not the filament
        distance = carried_held if carried else distance_held
        if carried and b.dialect.relative_with_distance:
            distance = np.where(distance_held == 910, 910, carried_held)
        scale, grid = b.unit_scale(letter)
        half = b.halves(letter)
        least = places_of(b.setup.least_increment.get(letter, 1e-4)) + (
            inch if letter in LINEAR else 0
        )
        scale, grid = scale // half, grid // half
        offset = b.offset[row] if b.offset.shape[1] > 1 else b.offset[row, 0]
        if any_machine:
            offset = np.where(machine, 0, offset)
        stood, was_known = b.state.position[row], b.state.known[row]
        absolute, increment = axis_words[letter]
        place = absolute
        if len(increment):
            both = np.intersect1d(w.block[absolute], w.block[increment])
            if len(both):
                raise b.fault(
                    increment[w.block[increment] == both[0]][0],
                    f"{letter} and its increment in one block",
                    "keep one of them",
                )
            place = np.sort(np.concatenate([absolute, increment]))
        if any_taken:
            place = place[~taken[w.block[place]]]
        cycle = b.cycle if b.cycle is not None and b.cycle.letter == letter else None
        if cycle:
            place = place[~cycle.mask[w.block[place]]]
        by = w.block[place]
        relative = distance == 910
        some_relative = np.count_nonzero(relative)
        is_inc = at(relative, by) & ~machine[by] if some_relative else np.zeros(len(by), bool)
        if spelled or len(increment):
            is_inc = np.where(w.letter[place] == ord(letter), is_inc, w.letter[place] < ABSOLUTE)
        added, due = np.count_nonzero(is_inc), bool(b.frame.due[row])
        named = np.zeros(n, bool)
        if len(by) or cycle:
            value = b.ticks(place, at(scale, by))
            if b.frame.due[row] and len(by):
                value = _due(b, row, letter, by, value, is_inc)
            run: np.ndarray | int = 0
            here, set_to = by, value
            if added:
                moved = np.zeros(n, np.int64)
                moved[by[is_inc]] = value[is_inc]
                run = moved.cumsum()
                here, set_to = by[~is_inc], value[~is_inc]
            named[here] = True
            set_to = set_to + at(offset, here)
            if len(here) == n and not cycle:  # every block says the place: nothing is held
                position = set_to
            else:
                base = np.zeros(n, np.int64)
                base[here] = set_to - (run[here] if isinstance(run, np.ndarray) else 0)
                if cycle:
                    holes = cycle.blocks
                    base[holes] = cycle.target - (run[holes] if isinstance(run, np.ndarray) else 0)
                    named[holes] = True
                last = hold_index(named)
                position = base[last]
                position[: last.searchsorted(0)] = stood
                position += run
        else:
            position = np.empty(n, np.int64)
            position.fill(stood)
        drop = b.foreign if carried else forget
        if sends and not carried:
            position, named, drop, away = _away(b, letter, position, named, forget)
            _since(p, row, away, block, b.state.sent is not None and bool(b.state.sent[row]))
        elif b.state.sent is not None and b.state.sent[row]:
            _since(p, row, np.zeros(n, bool), block, True)
        known: np.ndarray | None = None
        if not was_known or forgets or (cycle and not cycle.known):
            event = np.where(drop, 0, np.where(named, 1, -1))
            if cycle and not cycle.known:
                event[cycle.blocks[cycle.initial]] = 0
            known = hold_last(event, int(was_known)).astype(bool)
        p.target[row], p.start[row] = position[block], position[earlier]
        if known is None:
            p.start_known[row] = p.target_known[row] = True
        else:
            p.target_known[row], p.start_known[row] = known[block], known[earlier]
        if from_begin:  # there is no block before the first
            p.start[row, 0], p.start_known[row, 0] = stood, was_known
        if len(by):
            word = np.empty(n, np.int64)
            word.fill(-1)
            word[by] = place
            p.word[row] = word[block]
        if added or some_relative:
            inc = np.broadcast_to(relative, n).copy()
            if due:  # a word put in must not be one that may travel the shift: X=AC()
                inc[: by[0] if len(by) else n] = False
            inc[by] = is_inc
            p.incremental[row] = inc[block]
        p.grid[row] = at(grid, block)
        p.least[row] = at(least, block)
        p.scale[row] = at(scale, block)
        p.origin[row] = at(offset, block)
        if n:
            p.end_position[row], p.end_known[row] = (
                position[-1],
                True if known is None else known[-1],
            )
    return p


@lru_cache
def places_of(increment: float) -> int:
    """Decimals of a least increment."""
    return -round(np.log10(increment))


def _away(b: Batch, letter: str, position: np.ndarray, named: np.ndarray, forget: np.ndarray):
    """(B,) positions, events and lost places where G28 and G30 send an axis away, and (B,) bool
    where they do."""
    drop = forget.copy()
    away = np.zeros(b.n, bool)
    for number in (280, 300):
        if number in b.single:
            gone = drop.copy()
            _reference(b, number, letter, gone)
            away[b.single[number]] = gone[b.single[number]]
            reference = homed(b) if number == 280 else stated(b, "G30")
            place = None
            if reference is None or letter not in reference:
                drop = gone
            else:
                block_of = b.single[number]
                drop[block_of] = False
                there = block_of[gone[block_of]]
                place = round(reference[letter] * TICKS_PER_MM)
                position, named = _sent(position, named, there, place)
            if number == 280 and letter in b.dialect.home_z_over:
                drop = _taken_along(b, letter, place, position, drop)
    return position, named, drop, away


def _taken_along(
    b: Batch, letter: str, place: int | None, position: np.ndarray, drop: np.ndarray
) -> np.ndarray:
    """(B,) lost places, with those of an axis that homing Z alone may take along; one that is at
    home stays there."""
    own, z = np.zeros(b.n, bool), np.zeros(b.n, bool)
    _reference(b, 280, letter, own)
    _reference(b, 280, "Z", z)
    for block in np.flatnonzero(z & ~own):
        before = position[block - 1] if block else b.state.position[b.rows[letter]]
        if place is None or before != place:
            drop = drop.copy()
            drop[block] = True
    return drop


def _since(p: Places, row: int, away: np.ndarray, block: np.ndarray, carry: bool) -> None:
    """Fill `sent` and `end_sent` of an axis that G28 takes away in some blocks."""
    count = np.concatenate([[0], np.cumsum(away)]) + carry
    seen = np.concatenate([[0], count[block]])
    p.sent[row] = np.diff(seen) > 0
    p.end_sent[row] = count[-1] > seen[-1]


def _due(
    b: Batch, row: int, letter: str, by: np.ndarray, value: np.ndarray, is_inc: np.ndarray
) -> np.ndarray:
    """Values with the shift that the first increment after TRANS travels too, as this control does
    unless it is set otherwise; what that setting is nobody knows here, so no correction may depend
    on it."""
    due = int(b.frame.due[row])
    b.frame = replace(b.frame, due=np.where(np.arange(len(b.frame.due)) == row, 0, b.frame.due))
    if not is_inc[0]:
        return value
    b.blame(
        by[:1],
        f"an increment of {letter} right after its zero was shifted: whether it travels the shift"
        " is a setting of the control",
        f"write {letter} as an absolute place after TRANS",
    )
    value = value.copy()
    value[0] += due
    return value


def _sent(position: np.ndarray, named: np.ndarray, there: np.ndarray, place: int):
    """(B,) positions and events where blocks `there` send the axis to a place: what follows counts
    from it."""
    position, named = position.copy(), named.copy()
    for block in there:
        later = named[block + 1 :].nonzero()[0]
        stop = len(position)
        absolute = later[:1]
        if len(absolute):
            stop = block + 1 + int(absolute[0])
        position[block:stop] += place - position[block]
        named[block] = True
    return position, named


def _reference(b: Batch, number: int, letter: str, drop: np.ndarray) -> None:
    """G28 with axis words sends those axes away, without any all of them."""
    block = b.single[number]
    named = np.zeros(b.n, bool)
    mine = np.zeros(b.n, bool)
    reverse = {u: b.setup.axes[row] for u, row in b.interpreter.increment_rows.items()}
    for other, place in b.places.items():
        if ord(other) >= BARE:
            other = AXES[ord(other) - BARE]
        if other in b.rows or other in reverse:
            named[b.words.block[place]] = True
            if reverse.get(other, other) == letter:
                mine[b.words.block[place]] = True
    drop[block] = mine[block] | ~named[block]
