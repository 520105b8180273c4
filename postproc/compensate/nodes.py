"""Where to cut straight motions: at the nodes of the tables, merged greedily under one tolerance.

A table that is linear between nodes makes the correction along a straight motion linear between the
places where an axis passes a node, up to product terms (angle times arm), which bend it by at most
twist * a * b / 4. So these places, and equal parts where the product terms ask for them, are all
that can matter; most of them do not, and are merged.
"""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.machine.model import Machine


def candidates(
    machine: Machine, start: np.ndarray, target: np.ndarray, slack: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(K,) motion, (K,) t and (K,) axis of every place where motions (A, M), mm, could be cut; t
    between 0 and 1.

    The axis is the one that passes a node there, or -1: equal parts, between which product terms
    bend the correction by `slack` mm at most. In no order.
    """
    way = target - start
    owners: list[np.ndarray] = []
    times: list[np.ndarray] = []
    axes: list[np.ndarray] = []
    for row, letter in enumerate(machine.letters):
        low, high = np.minimum(start[row], target[row]), np.maximum(start[row], target[row])
        for nodes in machine.knots.get(letter, ()):
            first = np.searchsorted(nodes, low, side="right")
            count = np.maximum(np.searchsorted(nodes, high, side="left") - first, 0)
            owner, index = spread(count)
            owners.append(owner)
            times.append((nodes[first[owner] + index] - start[row][owner]) / way[row][owner])
            axes.append(np.full(len(owner), row if row in machine.corrected else -1))
    parts = machine.bounds.parts(start, target, slack)
    owner, index = spread(np.maximum(parts - 1, 0))
    owners.append(owner)
    times.append((index + 1) / np.maximum(parts, 1)[owner])
    axes.append(np.full(len(owner), -1))
    return np.concatenate(owners), np.concatenate(times), np.concatenate(axes)


def passes(machine: Machine, start: np.ndarray, target: np.ndarray, clamped: bool) -> np.ndarray:
    """(M,) whether motions (A, M), mm, pass a node, or the end of a table where it is held beyond
    (`clamped`)."""
    result = np.zeros(start.shape[1], bool)
    # each begins where the last one ends
    onward = start.shape[1] == 1 or not any_of(start[:, 1:] != target[:, :-1])
    for letter, table in machine.every_table:
        row = machine.letters.index(letter)
        if onward:
            interval = table.interval(np.concatenate([start[row, :1], target[row]]))
            result = result | (interval[:-1] != interval[1:])
        else:
            result = result | (table.interval(start[row]) != table.interval(target[row]))
        if clamped:  # held beyond the ends, it bends there
            for end in (table.nodes[0], table.nodes[-1]):
                result |= (start[row] < end) != (target[row] < end)
    for grid in machine.grids:
        for letter, nodes in ((grid.letter, grid.nodes), (grid.other, grid.others)):
            row = machine.letters.index(letter)
            result |= np.searchsorted(nodes, start[row]) != np.searchsorted(nodes, target[row])
    return result


def spread(count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Owner and index within the owner of `count` (M,) things each: [2, 0, 1] gives [0, 0, 2] and
    [0, 1, 0]."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)


def tidy(owner: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Indices that put candidates in order, without those closer than a millionth of the motion;
    both ends stay."""
    order = np.lexsort((t, owner))
    owner, t = owner[order], t[order]
    same = owner[1:] == owner[:-1]
    close = same & (t[1:] - t[:-1] < 1e-6)
    keep = np.ones(len(t), dtype=bool)
    keep[1:] &= ~close | (t[1:] == 1.0)
    keep[:-1] &= ~(close & (t[1:] == 1.0) & (t[:-1] > 0.0))
    return order[keep]


def merge(
    owner: np.ndarray,
    t: np.ndarray,
    correction: np.ndarray,
    written: np.ndarray,
    tolerance: np.ndarray,
) -> np.ndarray:
    """(K,) bool: which candidates to cut at; the ends of each motion are never marked.

    correction (A, K) mm at the candidates, and as it will be written there; tolerance (A, M) mm per
    motion and axis. Greedy: from the last cut a piece grows while its chord, rounded ends and all,
    passes within tolerance of every candidate between; the slopes that do so form an interval per
    axis, which each further candidate narrows. All motions take their k-th step together.

        correction            .-- high     high, low: the steepest and the flattest line from A
              ^         o  .-'             that passes every candidate so far within tolerance
              |      o  .-'    o   o
              |   o  .-'  _.-- low         the chord from A to the next candidate must lie between
              |  A .-'_.-'                 them; where it does not, the candidate before is a cut,
              +--------------------> t     and the next A
    """
    first = np.flatnonzero(np.concatenate([[True], owner[1:] != owner[:-1]]))
    count = np.diff(np.concatenate([first, [len(owner)]]))
    cut = np.zeros(len(owner), dtype=bool)
    anchor = first.copy()
    low = np.full(tolerance.shape, -np.inf)
    high = np.full(tolerance.shape, np.inf)
    active = np.arange(len(first))
    for k in range(1, int(count.max(initial=0))):
        active = active[count[active] > k]
        here = first[active] + k
        tol = tolerance[:, active]
        span = t[here] - t[anchor[active]]
        slope = (written[:, here] - written[:, anchor[active]]) / span
        fails = ((slope < low[:, active]) | (slope > high[:, active])).any(axis=0)
        turned = active[fails]
        cut[here[fails] - 1] = True
        anchor[turned] = here[fails] - 1
        low[:, turned], high[:, turned] = -np.inf, np.inf
        span = t[here] - t[anchor[active]]
        rise = correction[:, here] - written[:, anchor[active]]
        low[:, active] = np.maximum(low[:, active], (rise - tol) / span)
        high[:, active] = np.minimum(high[:, active], (rise + tol) / span)
    return cut
