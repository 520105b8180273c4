"""From axis words to places: absolute words set a position, incremental ones add to it, all in whole ticks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from postproc.nc.batch import LINEAR, Batch
from postproc.nc.columns import at, hold_index, hold_last
from postproc.nc.lexer import ABSOLUTE
from postproc.nc.zeros import stated
from postproc.units import TICKS_PER_MM


@dataclass
class Places:
    """(A, N) columns of the moving blocks, as in Motions: start, target, what is known, and how each axis' word is (or
    would be) written; sent: whether G28 has taken the axis elsewhere since the
    motion before; end_position, end_known, end_sent (A,): behind the batch."""

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


def position(b: Batch, block: np.ndarray, axis_words: dict[str, tuple[np.ndarray, np.ndarray]]) -> Places:
    """Work out (A, N) start, target, what is known, and the words' scales, at the moving blocks."""
    w, n = b.words, b.n
    shape = (len(b.rows), len(block))
    whole = [np.zeros(shape, np.int64) for _ in range(6)]
    p = Places(
        start=whole[0], target=whole[1], start_known=np.zeros(shape, bool), target_known=np.zeros(shape, bool),
        word=np.full(shape, -1, np.int64), incremental=np.zeros(shape, bool), grid=whole[2], scale=whole[3], origin=whole[4],
        least=whole[5], sent=np.zeros(shape, bool), end_sent=np.zeros(len(b.rows), bool), end_position=b.state.position.copy(), end_known=b.state.known.copy(),
    )  # fmt: skip
    taken, machine = b.taken, b.machine
    forget = b.loses | b.foreign
    for letter, row in b.rows.items():
        distance = b.held("carried") if letter in b.dialect.carried else b.held("distance")
        scale, grid = b.unit_scale(letter)
        half = b.halves(letter)
        least = -round(np.log10(b.setup.least_increment.get(letter, 1e-4)))
        least = least + ((b.held("units") == 200) if letter in LINEAR else 0)
        scale, grid = scale // half, grid // half
        offset = b.offset[row]
        offset = offset if len(offset) == 1 else np.where(machine, 0, offset)
        if len(offset) == 1 and machine.any():
            offset = np.where(machine, 0, offset)
        position, known = np.full(n, b.state.position[row]), np.full(n, b.state.known[row])
        absolute, increment = axis_words[letter]
        both = np.intersect1d(w.block[absolute], w.block[increment]) if len(increment) else increment
        if len(both):
            raise b.fault(
                increment[w.block[increment] == both[0]][0],
                f"{letter} and its increment in one block",
                "keep one of them",
            )
        place = absolute if not len(increment) else np.sort(np.concatenate([absolute, increment]))
        if taken.any():
            place = place[~taken[w.block[place]]]
        cycle = b.cycle if b.cycle is not None and b.cycle.letter == letter else None
        if cycle:
            place = place[~cycle.mask[w.block[place]]]
        by = w.block[place]
        is_inc = at(distance == 910, by) & ~machine[by]
        own = w.letter[place] == ord(letter)
        if not own.all():
            is_inc = np.where(own, is_inc, w.letter[place] < ABSOLUTE)
        value = b.ticks(place, at(scale, by))
        if b.frame.due[row] and len(by):
            value = _due(b, row, letter, by, value, is_inc)
        named = np.zeros(n, bool)
        if len(by) or cycle:
            run: np.ndarray | int = 0
            here, set_to = by, value
            if is_inc.any():
                moved = np.zeros(n, np.int64)
                moved[by[is_inc]] = value[is_inc]
                run = np.cumsum(moved)
                here, set_to = by[~is_inc], value[~is_inc]
            base = np.zeros(n, np.int64)
            base[here] = set_to + at(offset, here) - (run[here] if isinstance(run, np.ndarray) else 0)
            named[here] = True
            if cycle:
                holes = cycle.blocks
                base[holes] = cycle.target - (run[holes] if isinstance(run, np.ndarray) else 0)
                named[holes] = True
            last = hold_index(named)
            position = base[last]
            position[: np.searchsorted(last, 0)] = b.state.position[row]
            position += run
        drop = forget.copy()
        away = np.zeros(n, bool)
        for number in (280, 300):
            if number in b.single:
                gone = drop.copy()
                _reference(b, number, letter, gone)
                away[b.single[number]] = gone[b.single[number]]
                reference = stated(b, f"G{number // 10}")
                if reference is None or letter not in reference:
                    drop = gone
                    continue
                block_of = b.single[number]
                drop[block_of] = False
                there = block_of[gone[block_of]]
                position, named = _sent(position, named, there, round(reference[letter] * TICKS_PER_MM))
        if named.any() or drop.any():
            event = np.where(drop, 0, np.where(named, 1, -1))
            if cycle and not cycle.known:
                event[cycle.blocks[cycle.initial]] = 0
            known = hold_last(event, int(b.state.known[row])).astype(bool)
        _since(p, row, away, block, b.state.sent is not None and bool(b.state.sent[row]))
        before = np.concatenate([[b.state.position[row]], position[:-1]])
        before_known = np.concatenate([[b.state.known[row]], known[:-1]])
        p.start[row], p.target[row] = before[block], position[block]
        p.start_known[row], p.target_known[row] = before_known[block], known[block]
        word = np.full(n, -1, np.int64)
        word[by] = place
        p.word[row] = word[block]
        if is_inc.any() or np.any(distance == 910):
            inc = np.broadcast_to(distance == 910, n).copy()
            inc[by] = is_inc
            p.incremental[row] = inc[block]
        p.grid[row] = at(grid, block)
        p.least[row] = at(least, block)
        p.scale[row] = at(scale, block)
        p.origin[row] = at(offset, block)
        if n:
            p.end_position[row], p.end_known[row] = position[-1], known[-1]
    return p


def _since(p: Places, row: int, away: np.ndarray, block: np.ndarray, carry: bool) -> None:
    """Fill `sent` and `end_sent` of an axis that G28 takes away in some blocks."""
    count = np.concatenate([[0], np.cumsum(away)]) + carry
    seen = np.concatenate([[0], count[block]])
    p.sent[row] = np.diff(seen) > 0
    p.end_sent[row] = count[-1] > seen[-1]


def _due(b: Batch, row: int, letter: str, by: np.ndarray, value: np.ndarray, is_inc: np.ndarray) -> np.ndarray:
    """Values with the shift that the first increment after TRANS travels too, as this control does unless it is set
    otherwise; what that setting is nobody knows here, so no correction may depend on it."""
    due = int(b.frame.due[row])
    b.frame = replace(b.frame, due=np.where(np.arange(len(b.frame.due)) == row, 0, b.frame.due))
    if not is_inc[0]:
        return value
    b.blame(
        by[:1],
        f"an increment of {letter} right after its zero was shifted: whether it travels the shift is a setting of the control",
        f"write {letter} as an absolute place after TRANS",
    )
    value = value.copy()
    value[0] += due
    return value


def _sent(position: np.ndarray, named: np.ndarray, there: np.ndarray, place: int):
    """(B,) positions and events where blocks `there` send the axis to a place: what follows counts from it."""
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
        if other in b.rows or other in reverse:
            named[b.words.block[place]] = True
            if reverse.get(other, other) == letter:
                mine[b.words.block[place]] = True
    drop[block] = mine[block] | ~named[block]
