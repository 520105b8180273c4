"""Samples of a motion averaged to as many rows as a fit can bear."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from postproc.diagnose.noise_lines import LINE, SPECTRUM, around

Columns = dict[str, Any]  # (N,) arrays of a signal by name, (K, N) paths; "sees" is a word

MOST_ROWS = 5000  # per signal: traces are averaged down to it
# samples of a row whose places are kept: a wave with less than two of them a period leaves no more
# than 2 / (pi 32), 2 % of its size, in the mean over the row
MOST_INSIDE = 32
MOST_SAMPLES = 1 << 20  # of a spectrum
MOST_LINES = 3  # of a signal
RESOLVED = 0.45  # of the rate of the rows: faster oscillations show in their samples alone
LONG, MOST_OF_LONG = 50_000, 10_000  # samples from which on a trace is long, and its rows


def together(columns: Columns, same: np.ndarray) -> Columns:
    """Rows of samples that a log can not tell apart averaged to one."""
    return _means(columns, np.flatnonzero(~same | _cuts(columns, columns["run"])))


def averaged(columns: Columns) -> Columns:
    """Neighbouring samples of a run averaged until few enough are left. After a turn the first rows
    are short and grow with the time since: what a turn sets off fades, and an average over it would
    hide it."""
    run = columns.pop("cut", columns["run"])
    n = len(columns["y"])
    width = int(np.ceil(n / (MOST_ROWS if n <= LONG else MOST_OF_LONG)))
    if width == 1:
        return columns
    first = _cuts(columns, run)
    start = np.append(np.flatnonzero(first), n)
    turned = _cuts(columns, np.zeros(n))[start[:-1]]
    turned[0] = False
    steps = _growing(width)
    edges = [
        (
            np.concatenate(
                [a + steps[steps < min(b - a, steps[-1])], np.arange(a + steps[-1], b, width)]
            )
            if new and n > LONG
            else np.arange(a, b, width)
        )
        for (a, b), new in zip(pairwise(start), turned, strict=True)
    ]
    return _means(columns, np.concatenate(edges))


def _cuts(columns: Columns, run: np.ndarray) -> np.ndarray:
    """(N,) bool: the first sample, and those before which a run ends or an axis turns, starts or
    stops."""
    cut: np.ndarray = np.diff(run, prepend=run[:1]) != 0
    for name, value in columns.items():
        if name.endswith("approach"):
            cut = cut | (np.diff(value, prepend=value[:1]) != 0)
        if name.endswith(" velocity"):
            moves = value != 0
            cut = cut | (moves != np.concatenate([moves[:1], moves[:-1]]))
    cut[:1] = True
    return cut


def _means(columns: Columns, edges: np.ndarray) -> Columns:
    """Columns averaged from edge to edge; what is a number of something, of its middle row."""
    n = len(columns["y"])
    size = np.diff(np.append(edges, n))
    step = np.median(np.diff(columns["time"])) if n > 1 else 0.0
    result: Columns = {"width": size * float(step), "grain": _grain(columns["y"]) / np.sqrt(size)}
    for name, value in columns.items():
        if not isinstance(value, np.ndarray):
            result[name] = value
        elif name in ("run", "line") or name.endswith("approach"):
            result[name] = value[np.minimum(edges + size // 2, n - 1)]
        elif (
            name.startswith("channel ")
            and value.ndim == 1
            and len(value)
            and value[0] == value[-1]
            and np.all(value == value[0])
        ):
            result[name] = np.full(len(edges), value[0])
        elif name != "width":
            result[name] = _mean(name, value, edges, size)
    result["inside"] = _inside(columns, edges, size)
    if step > 0:
        resolved = RESOLVED / (float(step) * float(np.median(size)))
        result["fast_hz"] = fast_lines(columns["time"], columns["y"], float(step), resolved)
    return result


def _mean(name: str, value: np.ndarray, edges: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(M,) or (M, K) means from edge to edge; of a slow sensor, which is read once in many samples,
    of those in which it was."""
    mean: np.ndarray = np.add.reduceat(value, edges, axis=0)
    mean = mean / (size if value.ndim == 1 else size[:, None])
    if not name.startswith("channel ") or np.isfinite(mean).all():
        return mean
    known = np.isfinite(value)
    number = np.add.reduceat(known.astype(float), edges)
    whole = np.add.reduceat(np.where(known, value, 0.0), edges)
    return np.where(number > 0, whole / np.maximum(number, 1.0), np.nan)


def fast_lines(time: np.ndarray, y: np.ndarray, step_s: float, above_hz: float) -> list[float]:
    """Hz: the strongest oscillations above a frequency, in samples y (n,) at times (n,) s."""
    # onto an even grid: pauses between runs are zeros in it
    index = np.round((time - time.min()) / step_s).astype(int)
    if index.max() > MOST_SAMPLES or len(y) < 4 * SPECTRUM:
        return []
    wide = 2 * int(1.0 / (above_hz * step_s)) + 1
    rest = np.zeros(int(index.max()) + 1)
    rest[index] = y - uniform_filter1d(y, wide, mode="nearest")
    power = np.abs(np.fft.rfft(rest)) ** 2
    frequency = np.fft.rfftfreq(len(rest), step_s)
    line = (power > LINE * np.maximum(around(power), 1e-30)) & (frequency > above_hz)
    line[1:-1] &= (power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:])
    line[[0, -1]] = False
    found = np.flatnonzero(line)
    best = found[np.argsort(-power[found])][:MOST_LINES]
    low, peak, high = (np.sqrt(power[best + k]) for k in (-1, 0, 1))
    beyond = (high - low) / (2 * (2 * peak - low - high))  # the top of a parabola
    return [float(f) for f in (best + beyond) * frequency[1]]


def _inside(columns: Columns, edges: np.ndarray, size: np.ndarray) -> dict[str, np.ndarray]:
    """Where and when the samples of each row were taken, (W, N); of very many, so many at equal
    distances."""
    stride = np.maximum(1, -(-size // MOST_INSIDE))
    number = np.arange(int(np.max(-(-size // stride), initial=1)))[:, None] * stride
    # in the middle of those that each stands for
    index = np.minimum(edges + number + (stride - 1) // 2, len(columns["y"]) - 1)
    names = {"time": "time"} | {
        n.removesuffix(" position"): n for n in columns if n.endswith(" position")
    }
    return {
        short: np.where(number + (stride - 1) // 2 < size, columns[name][index], np.nan)
        for short, name in names.items()
    }


def _growing(width: int) -> np.ndarray:
    """Offsets from a turn at which rows begin: each a quarter longer than the time before it, until
    they are of the usual width."""
    steps = [0]
    while len(steps) < 2 or steps[-1] - steps[-2] < width:
        steps.append(steps[-1] + max(1, steps[-1] // 4))
    return np.array(steps)


def _grain(y: np.ndarray) -> float:
    """mm: noise of a single sample, from third differences."""
    return float(1.4826 * np.median(np.abs(np.diff(y, 3)))) / np.sqrt(20.0) if len(y) > 8 else 0.0
