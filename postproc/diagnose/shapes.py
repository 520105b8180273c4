"""Shapes as well as the readings tell them: between the values of the grid, and of a wave that was
found in a spectrum its period, a second wave of half the period, an amplitude that grows along the
travel."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from postproc.diagnose import library
from postproc.diagnose.block import Block
from postproc.diagnose.evidence import SLAB, Fit
from postproc.diagnose.factors import TRIED as TRIED_SIZES
from postproc.diagnose.library import FOUND
from postproc.diagnose.parts import surprise
from postproc.diagnose.prior import plausible
from postproc.diagnose.sets import Sets
from postproc.diagnose.spectra import SHORTEST
from postproc.effects import UM
from postproc.effects.step_loss import MOMENTS

WORTH = 6.0  # that what comes with a wave must add
ROUNDING = 1e-6  # of a worth: by less no shape is likelier, readings do not tell the two apart
# factor between values that are tried, how often its root is taken; beyond the range: another
# meaning
FIRST, HALVINGS, FAR = 1.4, 4, 1.5
FEWEST_MOMENTS = 4  # between which jumps are looked for
KEPT = 64  # shapes whose columns are kept: beside the next set most are tried again
WITHIN, TRIED, ROUNDS = 0.6, 5, 4  # of what the span resolves; periods tried each time


def polished(sets: Sets, fit: Fit, k: int) -> int:
    """The number of the block, or of one at a likelier shape, or with what comes with such a
    wave."""
    block = sets.blocks[k]
    if "t_s" in dict(block.shape):
        return _numbered(sets, k, _moments(sets, fit, block))
    periodic = block.name in FOUND and dict(block.shape).get("period_mm") != 0
    if dict(block.shape).get("scatter"):  # its cycles are as they were seen
        return k
    k = _numbered(sets, k, (_nearby if periodic else _between)(sets, fit, block))
    plain = sets.blocks[k]
    more = getattr(plain.module, "fuller", None) if periodic or block.name not in FOUND else None
    likeliest = plain
    for shape in more(dict(plain.shape), sets.rows.state, plain.axis) if more else ():
        fuller = at(sets, plain, shape)
        if fuller is None:
            continue
        now, then = worths(sets, fit, [likeliest, fuller])
        likeliest = fuller if then > now + (WORTH if likeliest is plain else 0.0) else likeliest
    if likeliest is plain:
        return k
    return sets.let_in(likeliest if periodic else _between(sets, fit, likeliest))


def _numbered(sets: Sets, k: int, other: Block) -> int:
    return k if other is sets.blocks[k] else sets.let_in(other)


def worths(sets: Sets, fit: Fit, blocks: list[Block]) -> list[float]:
    """Twice the logarithm of the Bayes factor of each of some blocks beside a fit; -inf for an
    implausible one."""
    a, b = sets.evidence.beside(fit, np.concatenate([x.columns for x in blocks], axis=1))
    result, end = [], 0
    for block in blocks:
        own = slice(end, end := end + block.width)
        result.append(_worth(block, a[own, own], b[own]))
    return result


def _worth(block: Block, a: np.ndarray, b: np.ndarray) -> float:
    """Of a block whose columns, all else taken out, have the products a (K, K) and b (K,) with the
    readings."""
    scales = np.array(TRIED_SIZES)
    # The same closed form as in factors.py, of one block at all TRIED sizes; there without this
    # loop's test of the sizes that come out, which costs a solve each.
    slab = scales[:, None] * SLAB / block.largest
    scaled = a * slab[:, :, None] * slab[:, None, :] + np.eye(len(b))
    value = np.linalg.solve(scaled, (b * slab)[:, :, None])[:, :, 0]
    worth = (b * slab * value).sum(axis=1) - np.linalg.slogdet(scaled)[1] - surprise(scales, 1.0)
    return max(
        (float(w) for w, v in zip(worth, value * slab, strict=True) if plausible(block, v)),
        default=-np.inf,
    )


def _likeliest(
    sets: Sets, fit: Fit, best: Block, most: float, shapes: list[dict[str, float]]
) -> tuple[Block, float]:
    """A block in the likeliest of these shapes, and what it is worth; as it is where none of them
    is worth more."""
    found = [at(sets, best, shape) for shape in shapes if library.named(shape) != best.shape]
    tried = [b for b in found if b is not None and b.width == best.width]
    for block, now in zip(tried, worths(sets, fit, tried) if tried else [], strict=True):
        if now > most + ROUNDING:
            best, most = block, now
    return best, most


def at(sets: Sets, block: Block, shape: dict[str, float]) -> Block | None:
    """The block in another shape; None where these readings do not show all of it, or a wave only
    as a curve."""
    key = block.key, library.named(shape)
    found = sets.tried.pop(key) if key in sets.tried else _at(sets, block, shape)
    sets.tried[key] = found
    if len(sets.tried) > KEPT:
        del sets.tried[next(iter(sets.tried))]
    return found and replace(block, shape=key[1], make=found.make).having(found.columns)


def _at(sets: Sets, block: Block, shape: dict[str, float]) -> Block | None:
    make = partial(library.read, sets.rows, block.module, block.axis, shape)
    columns = make()
    if not (np.abs(columns).max(axis=0) > 1e-9).all():
        return None
    if "period_mm" in shape and library.looks_smooth(sets.rows, block.axis, columns[:, :2]):
        return None
    return replace(block, shape=library.named(shape), make=make).having(columns)


def _nearby(sets: Sets, fit: Fit, block: Block) -> Block:
    """The block at the likeliest period or frequency near its own."""
    name = "period_mm" if "period_mm" in dict(block.shape) else "frequency_hz"
    shown = np.any(block.columns != 0, axis=1)
    if name == "period_mm":
        span = float(np.ptp(sets.rows.state.position[block.axis][shown]))
    else:
        passages = sets.rows.state.passage[shown]
        span = max(
            float(np.ptp(sets.rows.state.time[shown][passages == p])) for p in np.unique(passages)
        )
    within = WITHIN / max(span, 1e-9)
    best, (most,) = block, worths(sets, fit, [block])
    #     middle - within   .   middle   .   middle + within        TRIED = 5 in a round
    #                       |<- half of it in the next ->|
    # Frequencies: from 0.6 of what the span resolves (1 / span) on either side down to steps of a
    # sixteenth of that.
    for _ in range(ROUNDS):
        value = dict(best.shape)[name]
        middle = 1 / value if name == "period_mm" else value
        # the one in the middle is known
        around = [
            f for f in middle + within * np.linspace(-1.0, 1.0, TRIED) if f > 0 and f != middle
        ]
        shapes = [
            {**dict(block.shape), name: float(1 / f if name == "period_mm" else f)} for f in around
        ]
        best, most = _likeliest(sets, fit, best, most, shapes)
        within /= (TRIED - 1) / 2
    return best


def aliases(sets: Sets, fit: Fit, block: Block, enough: float) -> list[float]:
    """mm: other periods of a wave that explain the readings as well, shortest first: targets at
    even distances show a wave of the frequency f and one of k / distance +- f alike (aliasing).
    fit: without the wave; enough: by how much less probable they may be, as twice a logarithm; a
    period may have any scale (Jeffreys' prior)."""
    period = dict(block.shape).get("period_mm", 0.0)
    folded = _folded(sets, block, 1 / period) if period else []
    if not folded:
        return []
    made = [at(sets, block, {**dict(block.shape), "period_mm": 1 / f}) for f in folded]
    same = [b for b in made if b is not None and b.width == block.width]
    own, *others = worths(sets, fit, [block, *same])
    periods = [dict(b.shape)["period_mm"] for b in same]
    return sorted(
        p
        for p, worth in zip(periods, others, strict=True)
        if worth + 2 * np.log(p / period) > own - enough
    )


def _folded(sets: Sets, block: Block, frequency: float) -> list[float]:
    """1/mm: frequencies of which targets at the usual distance of a signal show no other wave than
    at this one. None of samples in motion."""
    rows = sets.rows
    shown = np.any(block.columns != 0, axis=1)
    if not shown.any() or np.any(rows.state.passage[shown] >= 0):
        return []
    place = rows.state.position[block.axis]
    tried: set[float] = set()
    for signal in np.unique(rows.signal[shown]):
        stand = np.unique(np.round(place[shown & (rows.signal == signal)], 2))
        gap = float(np.median(np.diff(stand))) if len(stand) > 1 else np.inf
        # Targets every `gap`: f and k / gap +- f have the same values there.
        #
        #     0 ----- f ------|------ 1/gap - f --- 1/gap --- 1/gap + f ------ ...
        #                1/(2 gap)
        fold = np.arange(int(gap / SHORTEST) + 2 if gap < np.inf else 0) / gap
        tried |= set(np.abs(np.concatenate([fold + frequency, fold - frequency])).tolist())
    apart = WITHIN / max(float(np.ptp(place[shown])), 1e-9)
    return [
        f for f in sorted(tried) if 3 * apart < f <= 1 / SHORTEST and abs(f - frequency) > apart
    ]


def _moments(sets: Sets, fit: Fit, block: Block) -> Block:
    """The block at the likeliest moments between two readings near its own, one after the other: a
    long recording has more of them than the grid."""
    times = np.unique(sets.rows.state.time)
    middle = (times[1:] + times[:-1]) / 2
    best, (most,) = block, worths(sets, fit, [block])
    for name in (name for name in MOMENTS if name in dict(block.shape)):
        # 17 moments a coarse step apart, then 17 neighbours of the best of them
        for stride in (8, 1):
            near = int(np.searchsorted(middle, dict(best.shape)[name]))
            last = min(len(middle), near + 8 * stride + 1)
            moments = [float(middle[k]) for k in range(max(0, near - 8 * stride), last, stride)]
            shapes = [
                {**dict(best.shape), name: t}
                for t in moments
                if library.between_readings(sets.rows, t)
            ]
            best, most = _likeliest(sets, fit, best, most, shapes)
    return best


def jumps(sets: Sets, fit: Fit) -> list[int]:
    """Blocks of two or three jumps of an axis, the likeliest of all that the dictionary's moments
    make: steps that are lost several times show in no single jump."""
    result: list[int] = []
    single = [k for k, b in enumerate(sets.blocks) if tuple(n for n, _ in b.shape) == ("t_s",)]
    for axis in sorted({sets.blocks[k].axis for k in single}):
        own = [k for k in single if sets.blocks[k].axis == axis]
        if len(own) < FEWEST_MOMENTS:
            continue
        first = sets.blocks[own[0]]
        chosen = _jumps(sets, fit, tuple(own), first.siblings)
        moments = sorted(dict(sets.blocks[own[k]].shape)["t_s"] for k in chosen)
        block = at(sets, first, dict(zip(MOMENTS, moments, strict=False))) if moments else None
        if block is not None:
            result.append(sets.let_in(replace(block, siblings=first.siblings ** len(moments))))
    return result


def _jumps(sets: Sets, fit: Fit, own: tuple[int, ...], tried: int) -> list[int]:
    """Which two or three of the blocks `own`, a column each, are likeliest, that stand so far apart
    that no few readings are off; tried: moments that there are."""
    a, b = sets.evidence.among(fit, own)
    sensible = sets.blocks[own[0]].module.sensible
    later = np.array([sets.blocks[k].shown for k in own])
    # All pairs, then all third ones beside the best pair: all triples of 200 moments would be 1.3
    # million.
    picks = np.stack(np.triu_indices(len(later), 1), axis=1)
    chosen: list[int] = []
    now = -np.inf
    while len(picks) and len(chosen) < len(MOMENTS):
        # `later`: how many readings lie behind each moment, so differences are readings between two
        apart = np.diff(np.sort(later[picks], axis=1), axis=1).min(axis=1) >= library.FEWEST_BETWEEN
        if not apart.any():
            break
        picks = picks[apart]
        worth, size = _values(a, b, picks)
        value = worth - 2 * np.log(tried) * (picks.shape[1] - 1)
        fits = np.flatnonzero((value > now + WORTH) & sensible(*size.T))
        if not len(fits):
            break
        best = int(fits[np.argmax(value[fits])])
        chosen, now = picks[best].tolist(), float(value[best])
        rest = np.setdiff1d(np.arange(len(later)), chosen)
        picks = np.column_stack([np.repeat([chosen], len(rest), axis=0), rest])
    return chosen


def _values(a: np.ndarray, b: np.ndarray, picks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(S,) twice the logarithm of the Bayes factor of picks (S, K) of columns of 1 um, of their
    products a (M, M) and b (M,); (S, K) um, the likeliest sizes."""
    slab = SLAB / UM
    scaled = a[picks[:, :, None], picks[:, None, :]] * slab**2 + np.eye(picks.shape[1])
    along = b[picks] * slab
    estimate = np.linalg.solve(scaled, along[:, :, None])[:, :, 0]
    worth = np.einsum("sk,sk->s", along, estimate) - np.linalg.slogdet(scaled)[1]
    return worth, estimate * slab


def continuous(block: Block) -> dict[str, tuple[float, float]]:
    """What of its shape has a value between those of the grid, with the range."""
    named = getattr(block.module, "CONTINUOUS", {})
    shape = dict(block.shape)
    return {name: ends for name, ends in named.items() if 0 < shape.get(name, 0.0) < ends[1] * FAR}


def _between(sets: Sets, fit: Fit, block: Block) -> Block:
    """The block at the likeliest values of its shape near those of the grid."""
    if not continuous(block):
        return block
    best, (most,) = block, worths(sets, fit, [block])
    for name, (low, high) in continuous(block).items():
        factor = FIRST
        for _ in range(HALVINGS):
            middle = dict(best.shape)[name]
            shapes = [
                {**dict(best.shape), name: float(np.clip(value, low, high))}
                for value in (middle / factor, middle * factor)
            ]
            best, most = _likeliest(sets, fit, best, most, shapes)
            factor = float(np.sqrt(factor))
    return best
