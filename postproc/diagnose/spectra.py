"""What is periodic in what is left: in the place of an axis, or in time, at frequencies as fine as
the readings tell apart.

Readings are put into fine bins and a Fourier transform gives the sums for all frequencies at once;
by what a cosine and a sine of each would make chi squared fall (nuisances left aside), the best few
are worth fitting. Lomb 1976, Scargle 1982.
"""

from __future__ import annotations

import numpy as np

from postproc.diagnose.rows import Rows

TRIED = 600  # frequencies that could have been chosen by chance: what the score pays for
PEAKS = 3
# mm between samples: an axis stands; which share of them tells the finest wave
STILL, SMALL_STEPS = 1e-4, 0.1
MOVES = 1e-3  # mm/s
# mm, of a scale's signal; distances of samples that are looked at
FINEST, MOST_PAIRS = 0.02, 2_000_000
LOWEST_HZ = 0.5  # slower, it is drift: machines on soft mounts swing at 1 to 3 Hz
# mm: linear encoders err by 1 % of their period (Heidenhain, Linear Encoders, "interpolation error
# within one signal period"), which is below a micrometre for finer ones; leads of screws are longer
SHORTEST = 0.1
BY_CHANCE = 1e-4  # that some wave finer than the gaps between targets fits them as well
WAVE = 3  # values of a wave: cosine, sine, period
AT_ONCE = 1 << 20  # sines
NEVER = 1e-4  # of a wave's power beyond the zeros: less can not be told
ENOUGH = 0.02  # of the power of all rows: so much must tell a wave
FEWEST_SWINGS = 3.0  # of a passage: fewer are a curve
LONGEST, FEWEST_ROWS = 2.0, 32  # mm: a slide's way from jump to jump; rows that creep
FINE = 4  # bins per period of the highest frequency
MOST_BINS = 1 << 17
PER_TURN = 1000  # bins: sums over them are right to 1e-5, (pi / PER_TURN)^2 / 6 at the most


def in_place(rows: Rows, axis: str, weighted: np.ndarray, power: np.ndarray) -> list[float]:
    """mm: the likeliest periods along an axis; of rows that are averages also by the places of
    their samples."""
    # samples of an axis that stands tell one place, however many they are
    stands = (rows.state.passage >= 0) & (np.abs(rows.state.velocity[axis]) <= MOVES)
    weighted, power = np.where(stands, 0.0, weighted), np.where(stands, 0.0, power)
    found = _in_place(rows, axis, weighted, power)
    if axis in rows.state.inside:
        sampled = (power > 0) & (rows.state.passage >= 0)
        found += _fine(rows.state.inside[axis][:, sampled], weighted[sampled], power[sampled])
    return found


def _fine(place: np.ndarray, weighted: np.ndarray, power: np.ndarray) -> list[float]:
    """mm: the likeliest periods of rows that are means over samples at places (W, N): a wave shows
    in them as the mean over its samples, however short it is."""
    span = float(np.nanmax(place) - np.nanmin(place)) if place.size else 0.0
    steps = np.abs(np.diff(place, axis=0))
    steps = steps[np.isfinite(steps) & (steps > STILL)]
    if span < 1.0 or not len(steps):
        return []
    finest = min(
        0.5 / float(np.quantile(steps, SMALL_STEPS)), 1 / FINEST, MOST_BINS / (span * FINE * 2)
    )
    bins = int(2 ** np.ceil(np.log2(span * finest * FINE * 4)))
    # a quarter of what the span resolves: between two frequencies nothing is lost
    step = span * 4 / bins
    at, each, own = _samples(place)
    sums = np.fft.rfft(
        np.bincount(((at - at.min()) / step).astype(int), weighted[own] * each, bins)[:bins]
    )
    frequencies = np.fft.rfftfreq(bins, step)
    # What the means leave of a wave's power: from the distances of the samples in a row, of some
    # rows.
    some = slice(None, None, 1 + int(place.shape[1] * len(place) ** 2 / MOST_PAIRS))
    apart = np.abs(place[:, None, some] - place[None, :, some])
    known = np.isfinite(apart)
    share = np.broadcast_to(power[some] / known.sum(axis=(0, 1)), apart.shape)[known]
    left = np.fft.rfft(
        np.bincount(np.minimum(apart[known] / step, bins - 1).astype(int), share, bins)
    ).real
    left *= float(power.sum()) / max(float(power[some].sum()), 1e-30)
    enough = (
        (left > ENOUGH * float(power.sum())) & (frequencies >= 3.0 / span) & (frequencies <= finest)
    )
    total = np.where(enough, np.abs(sums) ** 2 / np.maximum(left / 2, 1e-30), 0.0)
    parts = [(at, weighted[own] * each, max(float(power.sum()) / 2, 1e-30))]
    return [1 / polished(f, 0.7 / span, parts) for f in _best(frequencies, total, 0.7 / span)]


def _samples(place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of (W, N), NaN where there is none: the samples one after the other, each one's share of its
    row, and its row."""
    known = np.isfinite(place)
    own = np.nonzero(known)[1]
    return place[known], (1.0 / known.sum(axis=0))[own], own


def _in_place(rows: Rows, axis: str, weighted: np.ndarray, power: np.ndarray) -> list[float]:
    place = rows.state.position[axis]
    use = power > 0
    span = float(np.ptp(place[use])) if use.any() else 0.0
    if span < 1.0:
        return []
    gaps: list[float] = []
    finest = 0.0
    for signal in np.unique(rows.signal[use]):
        which = use & (rows.signal == signal)
        p = np.unique(np.round(place[which], 4))
        if len(p) > 6:
            rest = rows.state.passage[which][0] < 0
            # a wave needs two readings a period (Nyquist), a little more in practice: 2.2
            gap = float(np.median(np.diff(p))) if rest else float(np.ptp(p)) / len(p) * 2
            finest = max(finest, 1 / max(2.2 * gap, 0.3))
            gaps += [gap] if rest else []
    found = _between_targets(rows, axis, weighted, power, finest, gaps)
    if finest <= 3.0 / span:
        return found
    bins = int(min(MOST_BINS, 2 ** np.ceil(np.log2(span * finest * FINE * 2))))
    step = span * 2 / bins  # twice the span: frequencies half as far apart as the span resolves
    index = ((place[use] - place[use].min()) / step).astype(int)
    spectrum = np.fft.rfft(np.bincount(index, weighted[use], bins)[:bins])
    frequencies = np.fft.rfftfreq(bins, step)
    total = np.abs(spectrum) ** 2 / max(float(power[use].sum()) / 2, 1e-30)
    allowed = (frequencies >= 3.0 / span) & (frequencies <= finest)
    parts = [(place[use], weighted[use], max(float(power[use].sum()) / 2, 1e-30))]
    best = _best(frequencies, np.where(allowed, total, 0.0), 0.7 / span)
    return found + [1 / polished(f, 0.7 / span, parts) for f in best]


def _between_targets(
    rows: Rows, axis: str, weighted: np.ndarray, power: np.ndarray, coarse: float, gaps: list[float]
) -> list[float]:
    """mm, none or one: the period finer than `coarse` (1/mm) that a wave with a zero of each signal
    fits best at rest, where the best of so many frequencies would hardly fit as well by chance
    (Baluev, Monthly Notices of the Royal Astronomical Society 385, 2008, 1279). Not one that is a
    slow curve at the targets of every signal."""
    use = np.flatnonzero((power > 0) & (rows.state.passage < 0))
    signal, place = rows.signal[use], np.round(rows.state.position[axis][use], 4)
    (signal, place), group = np.unique(np.stack([signal, place]), axis=1, return_inverse=True)
    w = np.bincount(group.ravel(), power[use])
    zeros = (signal[:, None] == np.unique(signal)) * np.sqrt(w)[:, None]
    free = len(w) - zeros.shape[1] - WAVE
    if free < 1:
        return []
    y = np.bincount(group.ravel(), weighted[use]) / np.sqrt(w)
    zeros /= np.linalg.norm(zeros, axis=0)
    y -= zeros @ (zeros.T @ y)
    span = float(np.ptp(place))
    frequencies = np.arange(max(coarse, 3.0 / span), 1 / SHORTEST, 0.2 / span)
    frequencies = frequencies[~_smooth(frequencies, gaps, 3.0 / span)]
    if not len(frequencies) or not y.any():
        return []
    fall = np.concatenate(
        [
            _fall(f, place, np.sqrt(w), zeros, y)
            for f in np.array_split(frequencies, 1 + len(frequencies) * len(w) // AT_ONCE)
        ]
    )
    # periods have a scale of any length (Jeffreys' prior): of aliases the longest
    best = int(np.argmax(fall - 2 * np.log(frequencies)))
    left = max(1.0 - fall[best] / float(y @ y), 0.0)
    if span * (frequencies[-1] - frequencies[0]) * left ** (free / 2) > BY_CHANCE:
        return []
    near = frequencies[best] + np.linspace(-0.2, 0.2, 41) / span
    return [1 / float(near[np.argmax(_fall(near, place, np.sqrt(w), zeros, y))])]


def _fall(
    frequencies: np.ndarray, place: np.ndarray, root: np.ndarray, zeros: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """(F,) by how much chi squared falls with a cosine and a sine of each frequency. place, root
    (of the weights), y: (G,), zeros (G, S) orthonormal; y without them."""
    angle = 2 * np.pi * frequencies[:, None] * (place - place.mean())
    c, s = root * np.cos(angle), root * np.sin(angle)
    c, s = c - (c @ zeros) @ zeros.T, s - (s @ zeros) @ zeros.T
    cc, ss, cs = (np.einsum("fg,fg->f", a, b) for a, b in ((c, c), (s, s), (c, s)))
    cy, sy = c @ y, s @ y
    whole = cc * ss - cs**2
    known = whole > NEVER * (cc + ss) ** 2
    fall = (ss * cy**2 - 2 * cs * cy * sy + cc * sy**2) / np.where(known, whole, 1.0)
    return np.where(known, fall, 0.0)


def _smooth(frequencies: np.ndarray, gaps: list[float], low: float) -> np.ndarray:
    """(F,) bool: frequencies that look slower than `low` at the targets of every signal, which
    stand so far apart."""
    slow = np.ones(len(frequencies), bool)
    for gap in gaps:
        slow &= np.abs(frequencies - np.round(frequencies * gap) / gap) < low
    return slow


def since_turn(ways: np.ndarray, weighted: np.ndarray, power: np.ndarray) -> list[float]:
    """mm: the likeliest periods in the way since the last turn. ways (W, N) mm: of the samples of
    rows; weighted, power (N,): as of in_place. All strokes begin a cycle with their turn."""
    if weighted.size < FEWEST_ROWS:
        return []
    middle = ways[0]
    steps = np.abs(np.diff(ways, axis=0)) if len(ways) > 1 else np.abs(np.diff(middle))
    steps = steps[np.isfinite(steps) & (steps > STILL)]
    span = float(np.ptp(middle))
    if not len(steps) or span <= 0:
        return []
    finest = min(1 / (2.2 * float(np.median(steps))), 1 / FINEST, MOST_BINS / (span * FINE * 2))
    low = max(1.0 / span, 1 / LONGEST)
    if finest <= low:
        return []
    lag = weighted - power * (float(weighted.sum()) / max(float(power.sum()), 1e-30))
    at, each, own = _samples(ways)
    bins = int(2 ** np.ceil(np.log2(span * finest * FINE * 2)))
    step = span * 2 / bins
    index = np.clip(((at - middle.min()) / step).astype(int), 0, bins - 1)
    sums = np.fft.rfft(np.bincount(index, lag[own] * each, bins))
    frequencies = np.fft.rfftfreq(bins, step)
    half = max(float(power.sum()) / 2, 1e-30)
    allowed = (frequencies >= low) & (frequencies <= finest)
    best = _best(frequencies, np.where(allowed, np.abs(sums) ** 2 / half, 0.0), 0.7 / span)
    return [1 / polished(f, 0.7 / span, [(at, lag[own] * each, half)]) for f in best]


def in_time(rows: Rows, weighted: np.ndarray, power: np.ndarray) -> list[float]:
    """Hz: the likeliest frequencies of sampled motions; passages add up whatever their phase."""
    dense = (rows.state.passage >= 0) & (power > 0)
    passages = [
        np.flatnonzero(dense & (rows.state.passage == p) & (rows.signal == s))
        for p in np.unique(rows.state.passage[dense])
        for s in np.unique(rows.signal[dense])
    ]
    passages = [w for w in passages if len(w) > 32]
    if not passages:
        return []
    length = max(float(np.ptp(rows.state.time[w])) for w in passages)
    highest = max(0.45 / float(np.median(np.diff(rows.state.time[w]))) for w in passages)
    if highest <= LOWEST_HZ or length <= 0:
        return []
    grid = np.arange(max(LOWEST_HZ, FEWEST_SWINGS / length), highest, 0.4 / length)
    total = np.zeros(len(grid))
    for which in passages:
        t = rows.state.time[which] - rows.state.time[which].min()
        own = 0.45 / float(np.median(np.diff(rows.state.time[which])))
        bins = int(min(MOST_BINS, 2 ** np.ceil(np.log2(max(length, 1.0) * own * FINE * 2 * 2))))
        step = length * 2 / bins
        spectrum = np.fft.rfft(np.bincount((t / step).astype(int), weighted[which], bins)[:bins])
        f = np.fft.rfftfreq(bins, step)
        part = np.abs(spectrum) ** 2 / max(float(power[which].sum()) / 2, 1e-30)
        inside = grid <= own
        total[inside] += np.interp(grid[inside], f, part)
    parts = [
        (rows.state.time[w], weighted[w], max(float(power[w].sum()) / 2, 1e-30)) for w in passages
    ]
    return [polished(f, 0.5 / length, parts) for f in _best(grid, total, 1.0 / length)]


def polished(
    frequency: float, within: float, parts: list[tuple[np.ndarray, np.ndarray, float]]
) -> float:
    """The frequency near this one at which the sums over (time or place, readings, power) of all
    parts are largest."""
    turned = [(*_turned(t, w, frequency, within), p) for t, w, p in parts]
    start = frequency
    for _ in range(3):
        tried = frequency + within * np.linspace(-1.0, 1.0, 9)
        value = np.zeros(len(tried))
        for t, wave, p in turned:
            # from one frequency to the next every reading turns by the same: no new sines
            now = wave * np.exp(-2j * np.pi * (tried[0] - start) * t)
            turn = np.exp(-2j * np.pi * (tried[1] - tried[0]) * t)
            for k in range(len(tried)):
                value[k] += abs(now.sum()) ** 2 / p
                now *= turn
        frequency = float(tried[int(np.argmax(value))])
        within /= 4
    return frequency


def _turned(
    t: np.ndarray, w: np.ndarray, frequency: float, within: float
) -> tuple[np.ndarray, np.ndarray]:
    """(M,) and (M,): readings w at t, turned back by a frequency; of very many their sums over
    bins at their middles, in which no frequency that differs by up to twice `within` turns by more
    than 1 / PER_TURN."""
    wave = w * np.exp(-2j * np.pi * frequency * (t - t[0]))
    bins = int(np.ptp(t) * 2 * within * PER_TURN) + 1
    if len(t) < 2 * bins:
        return t - t[0], wave
    size = np.ptp(t) / bins
    index = np.minimum(((t - t.min()) / max(size, 1e-30)).astype(int), bins - 1)
    sums = np.bincount(index, wave.real, bins) + 1j * np.bincount(index, wave.imag, bins)
    return t.min() - t[0] + (np.arange(bins) + 0.5) * size, sums


def _best(frequencies: np.ndarray, value: np.ndarray, apart: float) -> list[float]:
    """The highest few that are not neighbours."""
    result: list[float] = []
    left = value.copy()
    for _ in range(PEAKS):
        k = int(np.argmax(left))
        if left[k] <= 12.0:
            break
        result.append(float(frequencies[k]))
        # a peak's own flanks are no further peaks
        left[np.abs(frequencies - frequencies[k]) < 2 * apart] = 0.0
    return result
