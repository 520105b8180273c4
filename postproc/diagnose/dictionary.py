"""The dictionary's columns as one instrument's readings show them, whitened, and their products.

Readings are many (n, thousands) and the columns of a set few, and sets are many: so each set is
judged by products alone, of which a new block D adds a row to what is there, once and for all sets:

              B     Z     D of others    D         y
        D'    bd    zd    crossed        within    dy
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from postproc.diagnose.block import Block
from postproc.diagnose.noise import Unit

ROOM = 1.5  # times what is there: so that few of the columns that come later ask for a copy of all
RECENT = 32  # members beside the dictionary that are kept whitened, and multiplied with all of it


class Pairs(NamedTuple):
    """Of columns of one block that show in a unit: number (P,) of each pair among all, first,
    second (P,) where they stand here, product (P,)."""

    number: np.ndarray
    first: np.ndarray
    second: np.ndarray
    product: np.ndarray


class Products(NamedTuple):
    """Of columns x (n, K), whitened, with what a unit has: own (q, K) with its own columns, shared
    (f, K) with those that it shares, within (K, K), along (K,) with its readings."""

    own: np.ndarray
    shared: np.ndarray
    within: np.ndarray
    along: np.ndarray


class Kept(NamedTuple):
    """Of columns (n, K), whitened: bd (q, K), zd (f, K), dy (K,) products with a unit's own, with
    those that it shares, and with its readings."""

    bd: np.ndarray
    zd: np.ndarray
    dy: np.ndarray


class Growing:
    """Columns (n, K) behind which others are put, each in one piece of the memory."""

    def __init__(self, n: int):
        self._room = np.zeros((n, 0), order="F")
        self._used = 0

    @property
    def now(self) -> np.ndarray:
        """(n, K): what was put in so far."""
        return self._room[:, : self._used]

    def reserve(self, more: int) -> None:
        """Room for so many more columns."""
        wanted = self._used + more
        if wanted > self._room.shape[1]:
            wide = np.empty((len(self._room), int(ROOM * wanted)), order="F")
            wide[:, : self._used] = self.now
            self._room = wide

    def add(self, columns: np.ndarray) -> None:
        self.reserve(columns.shape[1])
        begin, self._used = self._used, self._used + columns.shape[1]
        self._room[:, begin : self._used] = columns


def _last(known: dict[int, np.ndarray], k: int, value: np.ndarray) -> np.ndarray:
    """The value, which is kept as the last one; the first ones of many are forgotten."""
    known.pop(k, None)
    known[k] = value
    if len(known) > RECENT:
        del known[next(iter(known))]
    return value


class Dictionary:
    """Columns of blocks that show in a unit; what is zero in all of its readings is not kept. b (n,
    q), z (n, f), y (n,): its own columns, those that it shares, and its readings, whitened. columns
    (K,): numbers of the columns that show; which (w,): those of all of a block's that show; where:
    of all here; bd (q, K), zd (f, K), dy (K,): products with b, z and y. Blocks beside it may be
    members of a set, and are not looked at for others."""

    def __init__(self, unit: Unit, b: np.ndarray, z: np.ndarray, y: np.ndarray):
        self.unit, self.b, self.z, self.y = unit, b, z, y
        self.columns = np.zeros(0, int)
        self._of: dict[int, np.ndarray] = {}
        self.which: dict[int, np.ndarray] = {}
        self.where: dict[int, slice] = {}
        self.dy = np.zeros(0)
        self.pairs = Pairs(*(np.zeros(0, int),) * 3, np.zeros(0))
        # What stands in _of are views into pieces: one array that grows would be copied, and be
        # there twice meanwhile.
        self._pieces: list[np.ndarray] = []  # (n, any) of some blocks each, never moved
        self._bd, self._zd = Growing(b.shape[1]), Growing(z.shape[1])
        self._aside: dict[int, tuple[Block, Kept]] = {}
        self._white: dict[int, np.ndarray] = {}  # of those the last ones, the last one last
        self._crossed: dict[int, np.ndarray] = {}
        self._crossed_aside: dict[int, np.ndarray] = {}
        self._within: dict[tuple[int, ...], np.ndarray] = {}

    @property
    def bd(self) -> np.ndarray:
        """(q, K) products with the own columns."""
        return self._bd.now

    @property
    def zd(self) -> np.ndarray:
        """(f, K) products with those that are shared."""
        return self._zd.now

    def add(self, blocks: list[tuple[int, int, Block]]) -> None:
        """Those of some blocks that show in this unit: of each its number, and that of its first
        column, -1 beside the dictionary."""
        new, numbers = {}, [self.columns]
        for number, first, block in blocks:
            # A block is as long as all rows, of all instruments; here it is cut to those of this
            # one, and what does not show in it (a cyclic error of X along Z) costs nothing.
            own = np.take(block.columns.T, self.unit.rows, axis=1)
            shows = np.flatnonzero(own.any(axis=1))
            if len(shows):
                self.which[number], new[number] = shows, (own[shows].T, first < 0, block)
                numbers.append(first + shows)
        if not new:
            return
        many = sum(own.shape[1] for own, _, _ in new.values())
        wide = np.empty((len(self.unit), many), order="F")
        np.concatenate([own for own, _, _ in new.values()], axis=1, out=wide)
        # All blocks at once: one pass over the memory for the autoregression, one product each with
        # B, Z, y.
        white, at = self.unit.whitened(wide), 0
        kept = Kept(self.b.T @ white, self.z.T @ white, white.T @ self.y)
        for number, (own, aside, block) in new.items():
            here = slice(at, at := at + own.shape[1])
            # terms of an error of form: of a member, asked for with it, and no candidates (first is
            # -1)
            if aside:
                mine = Kept(kept.bd[:, here], kept.zd[:, here], kept.dy[here])
                self._aside[number] = block, mine
                _last(self._white, number, white[:, here])
            else:
                begin = len(self.dy)
                self._of[number] = white[:, here]
                self.where[number] = slice(begin + here.start, begin + here.stop)
        if not aside:
            self.columns = np.concatenate(numbers)
            self._pieces.append(white)
            self._bd.add(kept.bd)
            self._zd.add(kept.zd)
            self.dy = np.concatenate([self.dy, kept.dy])

    def white(self, k: int) -> np.ndarray:
        """(n, w) columns of a block, whitened; beside the dictionary made again where they were
        forgotten."""
        if k in self._of:
            return self._of[k]
        white = self._white.get(k)
        if white is None:
            own = np.take(self._aside[k][0].columns.T, self.unit.rows, axis=1)
            white = self.unit.whitened(own[self.which[k]].T)
        return _last(self._white, k, white)

    def kept(self, shown: tuple[int, ...]) -> Kept:
        """What is known of the columns of blocks, one behind the other."""
        found = [Kept(self.bd[:, :0], self.zd[:, :0], self.dy[:0])]
        for k in shown:
            at = self.where.get(k)
            found.append(
                self._aside[k][1]
                if at is None
                else Kept(self.bd[:, at], self.zd[:, at], self.dy[at])
            )
        bd, zd, dy = zip(*found, strict=True)
        return Kept(np.concatenate(bd, axis=1), np.concatenate(zd, axis=1), np.concatenate(dy))

    def at(self, shown: tuple[int, ...]) -> np.ndarray:
        """Where the columns of blocks stand."""
        return np.concatenate(
            [np.zeros(0, int), *(np.arange(self.where[k].start, self.where[k].stop) for k in shown)]
        )

    def crossed(self, k: int) -> np.ndarray:
        """(w, K) products of a block's columns with all of the dictionary that show here."""
        crossed = self._crossed_aside if k in self._aside else self._crossed
        known = crossed.get(k, np.zeros((len(self.which[k]), 0)))
        new, at = [known], 0
        for piece in self._pieces:
            if at >= known.shape[1]:  # a piece is known as a whole, or not at all
                new.append(self.white(k).T @ piece)
            at += piece.shape[1]
        known = np.concatenate(new, axis=1) if len(new) > 1 else known
        if k in self._aside:
            return _last(self._crossed_aside, k, known)
        self._crossed[k] = known
        return known

    def _crossed_with(self, k: int, showing: tuple[int, ...], at: np.ndarray) -> np.ndarray:
        """(w, S) products of a block's columns with those of some blocks, which stand at (S,)."""
        known = (self._crossed_aside if k in self._aside else self._crossed).get(k)
        if known is not None and known.shape[1] > at.max():
            return known[:, at]
        return np.concatenate([self.white(k).T @ self.white(c) for c in showing], axis=1)

    def along(self, white: np.ndarray) -> np.ndarray:
        """(K, R) products of all columns with so many (n, R), whitened."""
        none = np.zeros((0, white.shape[1]))
        return np.concatenate([none, *(piece.T @ white for piece in self._pieces)])

    def within(self, shown: tuple[int, ...]) -> np.ndarray:
        """(K, K) products of the columns of blocks with each other."""
        own = np.concatenate([np.zeros((0, len(self.y))), *(self.white(k).T for k in shown)])
        return np.asarray(own @ own.T)

    def products(self, raw: np.ndarray, shown: tuple[int, ...], use: np.ndarray) -> Products | None:
        """Of columns raw (n, K) that are not in the dictionary; None: they do not show here. use:
        numbers of the own columns that are asked for, in order; of the others nothing is said."""
        if not raw.any():
            return None
        x = self.unit.whitened(raw)
        shared = [self.z.T @ x, *(self.white(c).T @ x for c in shown)]
        # Own columns stand in the order of their groups, processes last: most sets ask for none of
        # these, and the product ends at the last one that is asked for.
        own, last = np.zeros((self.b.shape[1], x.shape[1])), int(use.max(initial=-1)) + 1
        own[:last] = self.b[:, :last].T @ x
        return Products(own, np.concatenate(shared), x.T @ x, x.T @ self.y)

    def own_beside(
        self, numbers: tuple[int, ...], width: list[int], shown: tuple[int, ...]
    ) -> Products | None:
        """The same of blocks of the dictionary, `width` columns each."""
        showing = tuple(k for k in numbers if k in self.where)
        if not showing:
            return None
        begin = np.cumsum(width) - width
        here = np.concatenate(
            [b + self.which[k] for b, k in zip(begin, numbers, strict=True) if k in self.which]
        )
        at = self.at(showing)
        if numbers not in self._within:
            self._within[numbers] = self.within(showing)
        crossed = [self._crossed_with(c, showing, at) for c in shown]
        shared = np.concatenate([self.zd[:, at], *crossed])
        own, many = self.b.shape[1], sum(width)
        empty = [np.zeros((n, many)) for n in (own, len(shared), many)]
        result = Products(empty[0], empty[1], empty[2], np.zeros(many))
        result.own[:, here], result.shared[:, here] = self.bd[:, at], shared
        result.within[np.ix_(here, here)] = self._within[numbers]
        result.along[here] = self.dy[at]
        return result

    def index(self, numbers: list[int], pairs: np.ndarray, before: int) -> None:
        """Let in the pairs of columns of each of some blocks, of which pairs (2, P) are the numbers
        of the columns, the upper triangle row by row, and which stand behind so many pairs. The
        blocks are the last ones that there are."""
        at = np.full(int(pairs.max()) + 1, -1)
        # number among all columns -> place here, -1 where it does not show in this unit
        at[self.columns] = np.arange(len(self.columns))
        here = np.flatnonzero((at[pairs] >= 0).all(axis=0))
        own = [self._of[k] for k in numbers if k in self._of]
        products = [
            d[:, i] @ d[:, j]
            for d in own
            for i, j in combinations_with_replacement(range(d.shape[1]), 2)
        ]
        first, second = at[pairs[:, here]]
        self.pairs = Pairs(
            np.append(self.pairs.number, before + here),
            np.append(self.pairs.first, first),
            np.append(self.pairs.second, second),
            np.append(self.pairs.product, products),
        )
