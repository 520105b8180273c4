"""From axis words to places: absolute words set a position, incremental ones add to it, all in
whole ticks."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from postproc.nc import lengths
from postproc.nc.batch import LINEAR, AxisWords, Batch
from postproc.nc.columns import at, hold_index, hold_last
from postproc.nc.grammar import ABSOLUTE, RELATIVE
from postproc.nc.references import away as sent_away
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
    p, shared = _nowhere(b, len(block)), _Shared(b)
    earlier = block - NEXT
    idle = not (len(block) or shared.moves_without_words)
    for letter, row in b.rows.items():
        if idle and not any(map(len, axis_words[letter])):
            continue
        axis = _Axis(shared, letter, row)
        axis.read(*axis_words[letter])
        axis.travel()
        axis.leave(p, block)
        axis.write(p, block, earlier)
    return p


def _nowhere(b: Batch, n: int) -> Places:
    shape = (len(b.rows), n)
    whole = [np.zeros(shape, np.int64) for _ in range(6)]
    word = np.empty(shape, np.int64)
    word.fill(-1)
    return Places(
        start=whole[0], target=whole[1], start_known=np.zeros(shape, bool),
        target_known=np.zeros(shape, bool), word=word, incremental=np.zeros(shape, bool),
        grid=whole[2], scale=whole[3], origin=whole[4], least=whole[5], sent=np.zeros(shape, bool),
        changed=np.zeros(shape, bool), end_sent=np.zeros(len(b.rows), bool),
        end_changed=_before(b, b.state.changed), end_position=b.state.position.copy(),
        end_known=b.state.known.copy(),
    )  # fmt: skip


class _Shared:
    """What all axes of a batch share: blocks whose words are no places or are places of the
    machine, blocks that forget places, and the modal states by which a word is read."""

    def __init__(self, b: Batch):
        self.b = b
        self.forget = b.loses | b.foreign
        self.any_taken, self.any_machine, self.forgets = map(
            np.count_nonzero, (b.taken, b.machine, self.forget)
        )
        self.forgets += len(b.gone) + len(b.changed)
        self.distance, self.carried = b.held("distance"), b.held("carried")
        self.inch = b.held("units") == 200
        # whether any word says by itself that it is absolute or a distance
        self.spelled = max(b.places, default="") >= chr(RELATIVE)
        self.sends = 280 in b.single or 300 in b.single
        self.sent, self.changed = _before(b, b.state.sent), _before(b, b.state.changed)
        held = np.count_nonzero(self.sent | self.changed)
        self.moves_without_words = self.forgets or self.sends or held or b.cycle


class _Axis:
    """One axis of a batch, in the order read(), travel(), leave(), write()."""

    def __init__(self, shared: _Shared, letter: str, row: int):
        b = shared.b
        self.shared, self.b, self.letter, self.row = shared, b, letter, row
        self.carried = letter in b.dialect.carried
        self.distance = shared.carried if self.carried else shared.distance
        if self.carried and b.dialect.relative_with_distance:
            self.distance = np.where(shared.distance == 910, 910, shared.carried)
        scale, grid = b.unit_scale(letter)
        half = b.halves(letter)
        self.scale, self.grid = scale // half, grid // half
        measured = b.measured(letter)
        self.least = places_of(b.setup.least_increment.get(measured, 1e-4)) + (
            shared.inch if measured in LINEAR else 0
        )
        offset = b.offset[row] if b.offset.shape[1] > 1 else b.offset[row, 0]
        self.offset = np.where(b.machine, 0, offset) if shared.any_machine else offset
        self.stood, self.was_known = b.state.position[row], b.state.known[row]
        self.cycle = b.cycle if b.cycle is not None and b.cycle.letter == letter else None

    def read(self, absolute: np.ndarray, increment: np.ndarray) -> None:
        """Set `place` (K,), the words that say where the axis goes, `by` (K,), their blocks, and
        `is_inc` (K,), whether they are distances. Raises ProgramError."""
        b, w = self.b, self.b.words
        place = absolute
        if len(increment):
            both = np.intersect1d(w.block[absolute], w.block[increment])
            if len(both):
                raise b.fault(
                    increment[w.block[increment] == both[0]][0],
                    f"{self.letter} and its increment in one block",
                    "keep one of them",
                )
            place = np.sort(np.concatenate([absolute, increment]))
        if self.shared.any_taken:
            place = place[~b.taken[w.block[place]]]
        if self.cycle:
            place = place[~self.cycle.mask[w.block[place]]]
        self.place, self.by = place, w.block[place]
        self.relative = self.distance == 910
        self.some_relative = self.relative is not False and np.count_nonzero(self.relative) > 0
        if self.some_relative:
            self.is_inc = at(self.relative, self.by) & ~b.machine[self.by]
        else:
            self.is_inc = np.zeros(len(self.by), bool)
        self.added = 0
        if not (self.some_relative or self.shared.spelled or len(increment)):
            return
        if self.shared.spelled or len(increment):
            own = w.letter[place] == ord(self.letter)
            self.is_inc = np.where(own, self.is_inc, w.letter[place] < ABSOLUTE)
            self._rescale(self._distances())
        self.added = int(np.count_nonzero(self.is_inc))

    def _distances(self) -> np.ndarray:
        """(B,) bool: where its word is a distance, or would be."""
        found = np.broadcast_to(self.relative, self.b.n).copy()
        found[self.by] = self.is_inc
        return found

    def _rescale(self, distances: np.ndarray) -> None:
        """Scale and grid by what each word is by itself: DIAM90."""
        if self.letter == "X" and "diameter" in self.b.dialect.groups:
            half = self.b.halves("X", distances)
            self.scale, self.grid = (x // half for x in self.b.unit_scale("X"))

    def travel(self) -> None:
        """Set `position` (B,) behind each block and `named` (B,), whether the block says it."""
        n = self.b.n
        self.named = np.zeros(n, bool)
        self.named[self.by] = ~self.is_inc
        self.due = _due(self) if self.b.dialect.increments_travel_shifts else None
        if not (len(self.by) or self.cycle):
            self.position = np.empty(n, np.int64)
            self.position.fill(self.stood)
            return
        here, set_to, run = self._read_values()
        if len(here) == n and not self.cycle:  # every block says the place: nothing is held
            self.position = set_to
            return
        base = np.zeros(n, np.int64)
        base[here] = set_to - at(run, here)
        if self.cycle:
            holes = self.cycle.blocks
            base[holes] = self.cycle.target - at(run, holes)
            self.named[holes] = True
        last = hold_index(self.named)
        self.position = base[last]
        self.position[: last.searchsorted(0)] = self.stood
        self.position += run

    def _read_values(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | int]:
        """(H,) blocks with an absolute place, (H,) the places in machine coordinates, and (B,) the
        sum of the distances up to each block, 0 where there are none."""
        value = self.b.ticks(self.place, at(self.scale, self.by))
        if self.due is not None and self.added:
            value = value + np.where(self.is_inc, self.due[self.by], 0)
        here = self.by
        run: np.ndarray | int = 0
        if self.added:
            moved = np.zeros(self.b.n, np.int64)
            moved[here[self.is_inc]] = value[self.is_inc]
            here, value, run = here[~self.is_inc], value[~self.is_inc], moved.cumsum()
        return here, value + at(self.offset, here), run

    def leave(self, p: Places, block: np.ndarray) -> None:
        """What G28 and G30 do with it, and `known` (B,), None where it is everywhere."""
        b, shared = self.b, self.shared
        drop = b.foreign if self.carried else shared.forget
        if self.letter in b.gone:
            drop = drop | b.gone[self.letter]
        sent, away = bool(shared.sent[self.row]), np.zeros(b.n, bool)
        if shared.sends and not self.carried:  # homing takes the slides away, not the filament
            self.position, self.named, drop, away = sent_away(
                b, self.letter, self.position, self.named, drop
            )
            _since(p, self.row, away, block, sent)
        elif sent:
            _since(p, self.row, away, block, True)
        if self.letter in b.changed or shared.changed[self.row]:
            drop = drop | self._changed(p, away, block, sent)
        drop, lapses = self._lapsed(drop, away)
        self.known: np.ndarray | None = None
        unsure = self.cycle is not None and not self.cycle.known
        if not self.was_known or shared.forgets or unsure or lapses:
            event = np.where(drop, 0, np.where(self.named, 1, -1))
            if self.cycle is not None and unsure:
                event[self.cycle.blocks[self.cycle.initial]] = 0
            self.known = hold_last(event, int(self.was_known)).astype(bool)

    def _lapsed(self, drop: np.ndarray, away: np.ndarray) -> tuple[np.ndarray, bool]:
        """`drop` (B,) with the blocks that take its length back, and whether there are any."""
        if not self.b.dialect.length_lapses:
            return drop, False
        by = self.by[~self.is_inc]
        if self.cycle:
            by = np.concatenate([by, self.cycle.blocks])
        lapsed = lengths.lapses(self.b, self.letter, away, by)
        return drop | lapsed, bool(np.count_nonzero(lapsed))

    def _changed(self, p: Places, away: np.ndarray, block: np.ndarray, sent: bool) -> np.ndarray:
        """Fill in which motions come between a tool change and the first word of the axis. (B,)
        bool: where a tool change takes it to a place that is not known: not where a program
        that measures from there goes on in G91 (it means that the change takes the axis back), but
        for what G28 has sent away."""
        event = np.full(self.b.n, -1)
        event[block], event[away] = 0, 1
        is_away = hold_last(event, int(sent)).astype(bool)
        lost: np.ndarray = self.b.changed.get(self.letter, False) & (
            is_away | (self.distance != 910)
        )
        event = np.where(self.named | away, 0, np.where(lost, 1, -1))
        taken = self.letter in self.b.dialect.change_takes
        if not taken and len(block):  # a feed that goes anywhere brings it where it was
            goes = (p.target[: self.row] != p.start[: self.row]).any(axis=0)
            event[block[goes & (at(self.b.held("motion"), block) != 0)]] = 0
        since = hold_last(event, int(self.shared.changed[self.row])).astype(bool)
        p.changed[self.row] = since[block]
        if self.b.n:
            p.end_changed[self.row] = since[-1]
        return lost & taken

    def write(self, p: Places, block: np.ndarray, earlier: np.ndarray) -> None:
        """Fill the axis' row of `p` at the moving blocks, behind which stand the blocks
        `earlier`."""
        row, n = self.row, self.b.n
        p.target[row], p.start[row] = self.position[block], self.position[earlier]
        if self.known is None:
            p.start_known[row] = p.target_known[row] = True
        else:
            p.target_known[row], p.start_known[row] = self.known[block], self.known[earlier]
        if len(block) and block[0] == 0:  # there is no block before the first
            p.start[row, 0], p.start_known[row, 0] = self.stood, self.was_known
        if len(self.by):
            word = self.place
            if len(self.by) < n:
                word = np.empty(n, np.int64)
                word.fill(-1)
                word[self.by] = self.place
            p.word[row] = word[block]
        if self.added or self.some_relative:
            inc = self._distances()
            if self.due is not None:  # a word put in must not travel the shift: X=AC()
                inc &= self.due == 0
                inc[self.by] = self.is_inc
                self._rescale(inc)
            p.incremental[row] = inc[block]
        p.grid[row], p.least[row] = at(self.grid, block), at(self.least, block)
        p.scale[row], p.origin[row] = at(self.scale, block), at(self.offset, block)
        if n:
            p.end_position[row] = self.position[-1]
            p.end_known[row] = True if self.known is None else self.known[-1]


def _before(b: Batch, held: np.ndarray | None) -> np.ndarray:
    """(A,) what holds of each axis before the batch."""
    return np.zeros(len(b.rows), bool) if held is None else held.copy()


@lru_cache
def places_of(increment: float) -> int:
    """Decimals of a least increment."""
    return int(-round(np.log10(increment)))


def _since(p: Places, row: int, away: np.ndarray, block: np.ndarray, carry: bool) -> None:
    """Fill `sent` and `end_sent` of an axis that G28 takes away in some blocks."""
    count = np.concatenate([[0], np.cumsum(away)]) + carry
    seen = np.concatenate([[0], count[block]])
    p.sent[row] = np.diff(seen) > 0
    p.end_sent[row] = count[-1] > seen[-1]


def _due(axis: _Axis) -> np.ndarray | None:
    """(B,) ticks: the change of its zero since an axis was named last, by TRANS, D, another work
    offset or SUPA, which its next increment travels too, as this control does unless it is set
    otherwise (SD42440, SD42442); that setting is not known here, so no correction may depend on it.
    None: no change anywhere."""
    b, row, by = axis.b, axis.row, axis.by
    frame, zero = b.frame, np.broadcast_to(axis.offset, b.n) - b.frame.shift[row]
    said = np.zeros(b.n, bool)
    said[by] = True
    last = np.concatenate([[-1], hold_index(said)[:-1]])
    first = last < 0
    carried = zero if frame.zeros[row] == UNSAID else frame.zeros[row]
    zero = zero + frame.trans[row] + frame.length[row]
    due: np.ndarray = zero - np.where(first, carried, zero[last])
    if len(by):
        mine = np.arange(len(frame.zeros)) == row
        b.frame = replace(frame, zeros=np.where(mine, zero[by[-1]], frame.zeros))
    if not np.count_nonzero(due):
        return None
    b.blame(
        by[axis.is_inc & (due[by] != 0)],
        f"an increment of {axis.letter} right after its zero or its tool length was changed:"
        " whether it travels the change is a setting of the control",
        f"write {axis.letter} as an absolute place behind TRANS, D, G54 or SUPA",
    )
    return due
