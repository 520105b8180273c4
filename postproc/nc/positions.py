"""From axis words to places: absolute words set a position, incremental ones add to it, all in
whole ticks."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from postproc.flags import all_of, any_of
from postproc.nc import lengths
from postproc.nc.batch import NO_WORDS, AxisWords, Batch
from postproc.nc.columns import at, hold_index, hold_last
from postproc.nc.grammar import ABSOLUTE, RELATIVE
from postproc.nc.measures import measures
from postproc.nc.references import away as sent_away
from postproc.nc.references import sending
from postproc.nc.state import UNSAID
from postproc.records import mutable, replace

NEXT = np.array(1)  # without axes: postproc.units


@mutable
class Places:
    """(A, N) columns of the moving blocks, as in Motions: start, target, what is known, and how
    each axis' word is (or would be) written; sent: whether G28 has taken the axis elsewhere since
    the motion before; changed: whether a tool change has taken it away and no block has named it
    since, or fed where the change brings it back; end_position, end_known, end_sent, end_changed
    (A,): behind the batch."""

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
    changed: np.ndarray
    end_sent: np.ndarray
    end_changed: np.ndarray
    end_position: np.ndarray
    end_known: np.ndarray


def position(b: Batch, block: np.ndarray, axis_words: AxisWords) -> Places:
    """Work out (A, N) start, target, what is known, and the words' scales, at the moving blocks."""
    axes = _Axes(b)
    p = axes.stand(len(block))
    moves_without_words = axes.forgets or axes.held or b.cycle
    words = itertools.chain(*axis_words.values())
    if not (len(block) or moves_without_words or any(map(len, words))):
        return p
    if b.n == 1:  # of more blocks nothing is planned, and its columns can go
        b.axes = axes
    axes.read(axis_words)
    axes.travel()
    axes.leave(p, block)
    axes.write(p, block)
    return p


class _Axes:
    """All axes of one batch, in the order stand(), read(), travel(), leave(), write(). Columns of
    them are (A, B), or (A, 1) where they hold throughout; words (K,) come axis by axis."""

    def __init__(self, b: Batch):
        self.b, self.n = b, b.n
        self.forget = b.loses | b.foreign
        self.forgets = np.count_nonzero(self.forget) + len(b.gone) + len(b.changed)
        # whether any word says by itself that it is absolute or a distance
        self.spelled = max(b.places, default="") >= chr(RELATIVE)
        self.sends = bool(sending(b)) if b.single else False
        self.sent, self.changed = _before(b, b.state.sent), _before(b, b.state.changed)
        self.held = any_of(self.sent | self.changed)

    def stand(self, n: int) -> Places:
        """The places of `n` blocks in which nothing moves."""
        b, shape = self.b, (len(self.b.rows), n)
        start, target, grid, scale, origin, least = np.zeros((6, *shape), np.int64)
        start_known, target_known, incremental, sent, changed = np.zeros((5, *shape), bool)
        word = np.empty(shape, np.int64)
        word.fill(-1)
        return Places(
            start=start, target=target, start_known=start_known, target_known=target_known,
            word=word, incremental=incremental, grid=grid, scale=scale, origin=origin, least=least,
            sent=sent, changed=changed, end_sent=np.zeros(len(b.rows), bool),
            end_changed=self.changed.copy(), end_position=b.state.position.copy(),
            end_known=b.state.known.copy(),
        )  # fmt: skip

    def read(self, axis_words: AxisWords) -> None:
        """Set `place` (K,), the words that say where axes go, `axis`, `by` (K,), their axes and
        blocks, and `is_inc` (K,), whether they are distances. Raises ProgramError."""
        b, w = self.b, self.b.words
        self.scale, self.grid, self.least = measures(b)
        self.offset = np.where(b.machine, 0, b.offset) if any_of(b.machine) else b.offset
        self.increments = {x for x, (_, more) in axis_words.items() if len(more)}
        each = [self._words(x, *axis_words[x]) for x in b.rows]
        self.place = place = np.concatenate(each)
        self.axis = np.arange(len(each)).repeat([len(one) for one in each])
        self.by = w.block[place]
        keep = None
        if any_of(b.taken):
            keep = ~b.taken[self.by]
        if b.cycle is not None:
            own = (self.axis == b.cycle.row) & b.cycle.mask[self.by]
            keep = ~own if keep is None else keep & ~own
        if keep is not None and np.count_nonzero(keep) < len(keep):
            self.place, self.axis, self.by = self.place[keep], self.axis[keep], self.by[keep]
        self._read_distances()
        self.at = self.axis * self.n + self.by  # of (A, B), flat

    def _words(self, letter: str, absolute: np.ndarray, increment: np.ndarray) -> np.ndarray:
        """(k,) the words of one axis, in order."""
        if not len(increment):
            return absolute
        b, w = self.b, self.b.words
        both = np.intersect1d(w.block[absolute], w.block[increment])
        if len(both):
            raise b.fault(
                increment[w.block[increment] == both[0]][0],
                f"{letter} and its increment in one block", "keep one of them",
            )  # fmt: skip
        return np.sort(np.concatenate([absolute, increment]))

    def _read_distances(self) -> None:
        """Which words are distances, by the modes and by themselves; `relative` (A, B): where a
        word of an axis is one by the modes, None: nowhere; `added`: whether any is."""
        b, w, place = self.b, self.b.words, self.place
        modes = [self._mode(x) for x in b.rows]
        self.relative: np.ndarray | None = None
        if any(mode is not False and np.count_nonzero(mode) for mode in modes):
            self.relative = np.stack([np.broadcast_to(mode, self.n) for mode in modes])
            self.is_inc = self.relative[self.axis, self.by] & ~b.machine[self.by]
        else:
            self.is_inc = np.zeros(len(place), bool)
        self.added = False
        if not (self.relative is not None or self.spelled or self.increments):
            return
        if self.spelled or self.increments:
            letters = np.array([ord(x) for x in b.rows], np.uint8)
            own = w.letter[place] == letters[self.axis]
            self.is_inc = np.where(own, self.is_inc, w.letter[place] < ABSOLUTE)
            if self.spelled or "X" in self.increments:
                self._rescale(self._distances())
        self.added = any_of(self.is_inc)

    def _mode(self, letter: str) -> Any:
        """(B,) or one bool: whether the modes make words of an axis distances."""
        b = self.b
        distance = b.held("carried" if letter in b.dialect.carried else "distance")
        if letter in b.dialect.carried and b.dialect.relative_with_distance:
            return (b.held("distance") == 910) | (distance == 910)
        return distance == 910

    def _distances(self) -> np.ndarray:
        """(A, B) bool: where a word of an axis is a distance, or would be."""
        found = np.zeros((len(self.b.rows), self.n), bool)
        if self.relative is not None:
            found[:] = self.relative
        found[self.axis, self.by] = self.is_inc
        return found

    def _rescale(self, distances: np.ndarray) -> None:
        """Scale and grid of X by what each word is by itself: DIAM90."""
        b = self.b
        if "X" in b.rows and "diameter" in b.dialect.groups:
            half, row = b.halves("X", distances[b.rows["X"]]), b.rows["X"]
            self.scale, self.grid = (
                np.array(np.broadcast_to(c, distances.shape)) for c in (self.scale, self.grid)
            )
            for column, unit in zip((self.scale, self.grid), b.unit_scale("X"), strict=True):
                column[row] = unit // half

    def travel(self) -> None:
        """Set `position` (A, B) behind each block and `named` (A, B), whether the block says it."""
        b, n = self.b, self.n
        shape = (len(b.rows), n)
        self.named = np.zeros(shape, bool)
        self.named.ravel()[self.at] = ~self.is_inc
        self.due = self._due() if b.dialect.increments_travel_shifts else None
        #   block      X10  U5   -  X20  U1     Held is the place less the distances up to its word,
        #   run          0   5   5    5   6     `base` 10 . . 15 .: sums of whole ticks are the same
        #   position    10  15  15   20  21     however the text is cut.
        at, set_to, run = self._read_values()
        if len(at) == self.named.size and b.cycle is None:  # every block says each: nothing is held
            self.position = set_to.reshape(shape)
            return
        base = np.zeros(shape, np.int64)
        base.ravel()[at] = set_to if run is None else set_to - run.ravel()[at]
        if b.cycle is not None:
            row, holes = b.cycle.row, b.cycle.blocks
            base[row, holes] = b.cycle.target - (0 if run is None else run[row, holes])
            self.named[row, holes] = True
        self.position = np.empty(shape, np.int64)
        for row, named in enumerate(self.named):
            last = hold_index(named)
            first = int(last.searchsorted(0))
            self.position[row, :first] = b.state.position[row]
            base[row].take(last[first:], out=self.position[row, first:], mode="clip")
        if run is not None:
            self.position += run

    def _read_values(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """(H,) the cells of (A, B) with an absolute place, (H,) the places in machine coordinates,
        and (A, B) the sum of the distances up to each block, None where there are none."""
        value, at = self._ticks(), self.at
        if self.due is not None and self.added:
            value = value + np.where(self.is_inc, self.due.ravel()[at], 0)
        axis, run = self.axis, None
        if self.added:
            moved, fixed = np.zeros(self.named.shape, np.int64), ~self.is_inc
            moved.ravel()[at[self.is_inc]] = value[self.is_inc]
            at, value, axis = at[fixed], value[fixed], axis[fixed]
            run = moved.cumsum(axis=1)
        whole = self.offset.shape[1] == 1
        return at, value + self.offset.ravel().take(axis if whole else at), run

    def _ticks(self) -> np.ndarray:
        """(K,) the words in ticks."""
        b, scale = self.b, self.scale
        if scale.shape[1] > 1:
            return b.ticks(self.place, scale.ravel()[self.at])
        units = scale.ravel().tolist()
        if len(set(units)) == 1:
            return b.ticks(self.place, scale[0])
        stops = self.axis.searchsorted(np.arange(len(units) + 1)).tolist()
        return np.concatenate([
            b.ticks(self.place[first:stop], scale[row])
            for row, (first, stop) in enumerate(itertools.pairwise(stops))
            if stop > first
        ] or [NO_WORDS])  # fmt: skip

    def _due(self) -> np.ndarray | None:
        """(A, B) of `_due_of`, None where none is."""
        each = [_due_of(self, x, row) for x, row in self.b.rows.items()]
        if all(due is None for due in each):
            return None
        return np.stack([np.zeros(self.n, np.int64) if due is None else due for due in each])

    def leave(self, p: Places, block: np.ndarray) -> None:
        """What G28 and G30 do with axes, and `known` (A, B), None where it is everywhere."""
        b, was = self.b, self.b.state.known
        self.known: np.ndarray | None = None
        unsure = b.cycle if b.cycle is not None and not b.cycle.known else None
        lapses = lengths.may_lapse(b)
        if all_of(was) and not any((self.forgets, self.held, unsure, lapses)):
            return
        known = np.ones(self.named.shape, bool)
        for letter, row in b.rows.items():
            drop, lapsed = self._drop(letter, row, p, block)
            event = np.where(drop, 0, np.where(self.named[row], 1, -1))
            mine = unsure is not None and unsure.row == row
            if unsure is not None and mine:
                event[unsure.blocks[unsure.initial]] = 0
            if any((self.forgets, lapsed, mine, not was[row])):
                known[row] = hold_last(event, int(was[row]))
        self.known = None if all_of(known) else known

    def _drop(self, letter: str, row: int, p: Places, block: np.ndarray) -> tuple[np.ndarray, bool]:
        """(B,) where the place of an axis is lost, and whether its length lapses anywhere."""
        b, carried = self.b, letter in self.b.dialect.carried
        drop = b.foreign if carried else self.forget
        if letter in b.gone:
            drop = drop | b.gone[letter]
        sent, away = bool(self.sent[row]), np.zeros(self.n, bool)
        if self.sends and not carried:  # homing takes the slides away, not the filament
            self.position[row], self.named[row], drop, away = sent_away(
                b, letter, self.position[row], self.named[row], drop
            )
            _since(p, row, away, block, sent)
        elif sent:  # before this batch
            _since(p, row, away, block, True)
        if letter in b.changed or self.changed[row]:
            drop = drop | self._changed(letter, row, p, away, block)
        if not lengths.may_lapse(b):
            return drop, False
        by = self.by[(self.axis == row) & ~self.is_inc]
        if b.cycle is not None and b.cycle.row == row:
            by = np.concatenate([by, b.cycle.blocks])
        lapsed = lengths.lapses(b, letter, away, by)
        return drop | lapsed, bool(np.count_nonzero(lapsed))

    def _changed(
        self, letter: str, row: int, p: Places, away: np.ndarray, block: np.ndarray
    ) -> np.ndarray:
        """Fill in which motions come between a tool change and the first word of the axis. (B,)
        bool: where a tool change takes it to a place that is not known: not where a program
        that measures from there goes on in G91 (it means that the change takes the axis back), but
        for what G28 has sent away."""
        b, named = self.b, self.named[row]
        event = np.full(self.n, -1)
        event[block], event[away] = 0, 1
        is_away = hold_last(event, int(self.sent[row])).astype(bool)
        lost: np.ndarray = b.changed.get(letter, False) & (is_away | ~self._mode(letter))
        event = np.where(named | away, 0, np.where(lost, 1, -1))
        taken = letter in b.dialect.change_takes
        if not taken and len(block):  # a feed that goes anywhere brings it where it was
            goes = (self.position.take(block, axis=1) != self._starts(block))[:row].any(axis=0)
            event[block[goes & (at(b.held("motion"), block) != 0)]] = 0
        since = hold_last(event, int(self.changed[row])).astype(bool)
        p.changed[row] = since[block]
        if self.n:
            p.end_changed[row] = since[-1]
        return lost & taken

    def _starts(self, block: np.ndarray) -> np.ndarray:
        """(A, N) ticks before the moving blocks."""
        starts: np.ndarray = self.position.take(block - NEXT, axis=1)
        if len(block) and block[0] == 0:  # there is no block before the first
            starts[:, 0] = self.b.state.position
        return starts

    def again(self, block: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(A, N) start and target of the moving blocks and (A,) the position behind them, ticks, of
        words that differ from those that were read by their places alone."""
        self.travel()
        return self._starts(block), self.position.take(block, axis=1), self.position[:, -1].copy()

    def write(self, p: Places, block: np.ndarray) -> None:
        """Fill `p` at the moving blocks."""
        state = self.b.state
        p.target, p.start = self.position.take(block, axis=1), self._starts(block)
        if self.known is None:
            p.target_known.fill(True)
            p.start_known.fill(True)
        else:
            p.target_known = self.known.take(block, axis=1)
            p.start_known = self.known.take(block - NEXT, axis=1)
        if len(block) and block[0] == 0:
            p.start_known[:, 0] = state.known
        word = np.empty(self.named.shape, np.int64)
        word.fill(-1)
        word.ravel()[self.at] = self.place
        p.word = word.take(block, axis=1)
        if self.added or self.relative is not None:
            inc = self._distances()
            if self.due is not None:  # a word put in must not travel the shift: X=AC()
                inc &= self.due == 0
                inc[self.axis, self.by] = self.is_inc
                self._rescale(inc)
            p.incremental = inc.take(block, axis=1)
        for column, value in (
            (p.grid, self.grid), (p.least, self.least), (p.scale, self.scale),
            (p.origin, self.offset),
        ):  # fmt: skip
            column[:] = value if value.shape[1] == 1 else value.take(block, axis=1)
        if self.n:
            p.end_position = self.position[:, -1].copy()
            p.end_known.fill(True)
            if self.known is not None:
                p.end_known[:] = self.known[:, -1]


def _before(b: Batch, held: np.ndarray | None) -> np.ndarray:
    """(A,) what holds of each axis before the batch."""
    return np.zeros(len(b.rows), bool) if held is None else held.copy()


def _since(p: Places, row: int, away: np.ndarray, block: np.ndarray, carry: bool) -> None:
    """Fill `sent` and `end_sent` of an axis that G28 takes away in some blocks."""
    count = np.concatenate([[0], np.cumsum(away)]) + carry
    seen = np.concatenate([[0], count[block]])
    p.sent[row] = np.diff(seen) > 0
    p.end_sent[row] = count[-1] > seen[-1]


def _due_of(axes: _Axes, letter: str, row: int) -> np.ndarray | None:
    """(B,) ticks: the change of its zero since an axis was named last, by TRANS, D, another work
    offset or SUPA, which its next increment travels too, as this control does unless it is set
    otherwise (SD42440, SD42442); that setting is not known here, so no correction may depend on it.
    None: no change anywhere."""
    b, own = axes.b, axes.axis == row
    by, is_inc = axes.by[own], axes.is_inc[own]
    frame, zero = b.frame, np.broadcast_to(axes.offset[row], b.n) - b.frame.shift[row]
    said = np.zeros(b.n, bool)
    said[by] = True
    last = np.concatenate([[-1], hold_index(said)])[: b.n]  # none of a batch of no block
    first = last < 0
    carried = zero if frame.zeros[row] == UNSAID else frame.zeros[row]
    zero = zero + frame.trans[row] + frame.length[row]
    due: np.ndarray = zero - np.where(first, carried, zero[last])
    if len(by) and frame.zeros[row] != zero[by[-1]]:
        mine = np.arange(len(frame.zeros)) == row
        b.frame = replace(frame, zeros=np.where(mine, zero[by[-1]], frame.zeros))
    if not np.count_nonzero(due):
        return None
    b.blame(
        by[is_inc & (due[by] != 0)],
        f"an increment of {letter} right after its zero or its tool length was changed:"
        " whether it travels the change is a setting of the control",
        f"write {letter} as an absolute place behind TRANS, D, G54 or SUPA",
    )
    return due
