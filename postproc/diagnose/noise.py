"""The noise of every instrument: what scatters, what resembles its neighbours, and what wanders.

Readings of one instrument in one recording are a unit. Its noise is the sum of white noise with
long tails, an autoregression between neighbouring samples of a motion (order chosen by the Bayesian
information criterion), and wander: Ornstein-Uhlenbeck processes in time of several correlation
times, drawn by their values at some moments. How large each of them is, is learned beside every set
of effects (see evidence).

Uhlenbeck and Ornstein, On the theory of the Brownian motion, Phys. Rev. 36, 1930, 823. Yule-Walker:
Brockwell and Davis, Time Series: Theory and Methods, 1991, section 8.1.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from postproc.diagnose.noise_lines import without_lines
from postproc.diagnose.rows import Rows

# mm, rad: resolution
FLOOR = {"laser": 1e-4, "angle": 1e-7, "tool": 1e-4, "scale": 5e-5, "part": 3e-4}
# mm, rad: what they scatter by (unverified: workshops, the design of the experiment)
USUAL = {"laser": 3e-4, "angle": 5e-7, "tool": 5e-4, "scale": 3e-4}
# readings from which a unit's noise is told by itself; how many readings what is usual counts as
# (unverified)
FEW, KNOWN = 12, 6.0
MAD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
# what may be set to levels, between which readings do not repeat; readings at a level at least
FORCES, SEVERAL = ("force_", "load_", "spindle_rpm"), 3
AROUND, LOCAL = 31, (0.5, 10.0)  # readings around one; times the usual noise
# of the logarithm: two standard deviations of a median of 31 absolute differences of white noise,
# and of 31 third differences, which resemble their neighbours more
CHANCE, CHANCE_THIRD = 0.46, 0.53
# steps in the smallest gap between readings; of a step, how near a whole number of steps is
MOST_PARTS, WHOLE = 4, 0.05
ORDERS = (0, 1, 2, 4, 8)  # of the autoregression
# standard deviations: beyond, a reading counts as less sure (Student's t with 5 degrees of freedom
# does so too)
TAIL = 4.0
CACHED = 1 << 18  # bytes that are filtered at once: so many stay near the processor


@dataclass
class Unit:
    """Readings of one instrument. rows (n,): their numbers in the order of time; sees, dense: what
    kind; edges: where passages (unbroken motions, runs of targets) begin, and n; time (n,) s; r
    (n,) mm: standard deviation of the white part; ar: coefficients of the autoregression;
    innovation: its share of the variance; usual mm: of few readings, what others scatter by, else
    0; floor mm: no reading is surer than its instrument's resolution."""

    rows: np.ndarray
    sees: str
    dense: bool
    edges: np.ndarray
    time: np.ndarray
    r: np.ndarray
    ar: np.ndarray = field(default_factory=lambda: np.zeros(0))
    innovation: float = 1.0
    usual: float = 0.0
    floor: float = 0.0

    def __len__(self) -> int:
        return len(self.rows)

    def shrunk(self, own: float) -> float:
        """mm: the standard deviation of its own readings, shrunk towards what is usual (geometric
        mean, weighted by their number) where they are few: they may as well show an effect."""
        if not self.usual:
            return own
        return float(own * (self.usual / own) ** (KNOWN / (len(self) + KNOWN)))

    def pick(self, keep: np.ndarray) -> Unit:
        """The rows of which keep (N,) bool is true."""
        use = keep[self.rows]
        passage = np.searchsorted(self.edges, np.arange(len(self)), side="right")[use]
        edges = np.concatenate([[0], np.flatnonzero(np.diff(passage)) + 1, [int(use.sum())]])
        return Unit(
            self.rows[use],
            self.sees,
            self.dense,
            edges,
            self.time[use],
            self.r[use],
            self.ar,
            self.innovation,
            self.usual,
            self.floor,
        )

    def whitened(self, columns: np.ndarray) -> np.ndarray:
        """(n,) or (n, K): divided by the standard deviation and, within passages, less what the
        samples before predict."""
        result: np.ndarray = columns / (self.r if columns.ndim == 1 else self.r[:, None])
        order = len(self.ar)
        if not order:
            return result
        # of the first of a passage nothing is predicted
        free = np.unique(np.add.outer(self.edges[:-1], np.arange(order)))
        free = free[free < len(result)]
        first, step = result[free], max(order, CACHED // (result[:1].nbytes + 1))
        for begin in reversed(range(0, len(result), step)):  # in place: those before are not yet
            before = max(begin - order, 0)
            scaled = result[before : begin + step].copy()  # neighbours as they were
            block = result[begin : begin + step]
            for k, a in enumerate(self.ar, 1):
                late = max(k - begin, 0)
                block[late:] -= a * scaled[begin - before + late - k : max(len(scaled) - k, 0)]
            block /= np.sqrt(self.innovation)
        result[free] = first
        return result


def units(rows: Rows) -> list[Unit]:
    """Every signal of an instrument; all features of a file together."""
    part = rows.sees == "part"
    label = np.where(part, -1 - rows.file, rows.signal)
    found = []
    for number in np.unique(label):
        own = np.flatnonzero(label == number)
        dense = rows.kinds[rows.file[own[0]]] in ("ballbar", "trace")
        order = own[
            np.lexsort(
                (np.arange(len(own)), rows.state.time[own], rows.run[own] * (not part[own[0]]))
            )
        ]
        passage = rows.state.passage[order] if dense else rows.run[order]
        edges = np.concatenate([[0], np.flatnonzero(np.diff(passage)) + 1, [len(order)]])
        t = rows.state.time[order]
        if np.ptp(t) == 0 or (np.any(np.diff(t) < 0) and part[own[0]]):
            t = np.arange(len(order), dtype=float)
        sees = str(rows.sees[order[0]])
        unit = Unit(order, sees, dense, edges, t, np.ones(len(order)))
        unit.floor = max(FLOOR[sees], step(rows.y[order]))
        unit.r = _white(rows, rows.residual, unit)
        found.append(unit)
    for unit in found:
        if len(unit) < FEW and unit.sees != "part":
            alike = [float(np.median(u.r)) for u in found if u.sees == unit.sees and len(u) >= FEW]
            unit.usual = float(np.median(alike)) if alike else USUAL[unit.sees]
            unit.r = unit.r * unit.shrunk(float(np.median(unit.r))) / float(np.median(unit.r))
    return found


def _white(rows: Rows, residual: np.ndarray, unit: Unit) -> np.ndarray:
    """(n,) mm: a first guess of the white part, from differences of neighbours."""
    which = unit.rows
    floor = unit.floor
    if unit.dense:
        y = residual[which]
        second = np.concatenate(
            [np.diff(y[a:b], 2) for a, b in pairwise(unit.edges)] or [np.zeros(1)]
        )
        size = (
            max(spread(second) / np.sqrt(6.0), floor)
            if len(second) > 3
            else max(float(np.std(y)), floor)
        )
    else:
        size = max(
            (
                _repeated(rows, residual, which)
                if unit.sees == "part"
                else _sparse(rows, residual, which)
            ),
            floor,
        )
    size = np.maximum(size, rows.grain[which])
    white: np.ndarray = np.hypot(size, rows.rounding[which]) if unit.dense else size
    return white


def step(y: np.ndarray) -> float:
    """mm: what an instrument's resolution gives, where its readings are whole numbers of a step."""
    values = np.unique(np.round(y, 9))
    if len(values) < 2 or len(values) > 0.5 * len(y):
        return 0.0
    gaps = np.diff(values)
    for parts in range(1, MOST_PARTS + 1):
        counts = gaps * parts / gaps.min()
        if np.all(np.abs(counts - np.round(counts)) < WHOLE):
            return float(gaps.min() / parts / np.sqrt(12.0))
    return 0.0


def spread(values: np.ndarray) -> float:
    """Standard deviation by the median of absolute deviations."""
    values = _ungrouped(values)
    return float(MAD * np.median(np.abs(values - np.median(values)))) if len(values) else 0.0


def _ungrouped(values: np.ndarray) -> np.ndarray:
    """Values, where most are equal to others spread evenly over the gap between two: the median of
    grouped data (a median of whole steps is itself one)."""
    known, of, count = np.unique(np.round(values, 9), return_inverse=True, return_counts=True)
    if len(known) < 2 or len(known) > 0.5 * len(values):
        return values
    order = np.argsort(of, kind="stable")
    rank = np.empty(len(values))
    rank[order] = np.arange(len(values)) - np.repeat(np.cumsum(count) - count, count)
    return known[of] + float(np.diff(known).min()) * ((rank + 0.5) / count[of] - 0.5)


def place_of(rows: Rows, which: np.ndarray) -> np.ndarray:
    """Rows at the same place from the same side, and under the same stated force, have the same
    number."""
    columns = [np.round(p[which], 3) for p in rows.state.position.values()]
    columns += [np.sign(s[which]) for s in rows.state.approach.values()]
    for name, value in rows.state.channels.items():
        if name.startswith(FORCES) and _set(value[which]):
            columns.append(np.nan_to_num(value[which]))
    if rows.other:
        columns += [np.round(np.nan_to_num(v[which]), 3) for v in rows.other.values()]
    return np.unique(np.stack(columns), axis=1, return_inverse=True)[1].ravel()


def _set(values: np.ndarray) -> bool:
    """Whether a quantity was set to a few levels, several readings at each, not just recorded."""
    levels = len(np.unique(values[np.isfinite(values)]))
    return 1 < levels <= len(values) / SEVERAL


def _sparse(rows: Rows, residual: np.ndarray, which: np.ndarray) -> float:
    """Targets: differences between runs at a place, and of those between neighbours of a run."""
    place, run, y = place_of(rows, which), rows.run[which], residual[which]
    differences = []
    for a, b in pairwise(np.unique(run)):
        first = {int(p): float(v) for p, v in zip(place[run == a], y[run == a], strict=True)}
        pairs = [
            float(v) - first[int(p)]
            for p, v in zip(place[run == b], y[run == b], strict=True)
            if int(p) in first
        ]
        if len(pairs) > 1:
            differences.append(np.diff(pairs) / 2.0)  # of four readings
        elif pairs:
            differences.append(np.array(pairs) / np.sqrt(2.0))  # of two
    if differences:
        flat = np.concatenate(differences)
        return spread(flat) if len(flat) > 3 else float(np.std(flat))
    second = np.diff(y, 2) / np.sqrt(6.0)  # of 1 -2 1: 1 + 4 + 1 variances
    return spread(second) if len(second) > 3 else float(np.std(y))


def _repeated(rows: Rows, residual: np.ndarray, own: np.ndarray) -> float:
    """Features that were measured several times on each part: what the readings of one scatter by;
    else from differences of neighbours."""
    group = np.unique(np.stack([rows.signal[own], rows.run[own]]), axis=1, return_inverse=True)[
        1
    ].ravel()
    count = np.bincount(group)
    free = len(own) - len(count)  # a mean of each group is taken out
    if free < 4:
        return _sparse(rows, residual, own)
    mean = np.bincount(group, residual[own]) / count
    return float(np.sqrt(np.sum((residual[own] - mean[group]) ** 2) / free))


# -- wander ----------------------------------------------------------------------------------------


def wander(unit: Unit) -> list[np.ndarray]:
    """Columns (n, M), one array for each correlation time, longest first, of unit standard
    deviation at every moment: a value at each of some moments, correlated as an Ornstein-Uhlenbeck
    process is, lines between them."""
    n, t = len(unit), unit.time - unit.time.min()
    if n < 6:
        return []
    whole, passages = float(np.ptp(t)), len(unit.edges) - 1
    longest = max(float(np.ptp(t[a:b])) for a, b in pairwise(unit.edges))
    if unit.dense:
        # of one passage as fine as of many: 1/f noise has a part faster than ten nodes follow
        scales = [(2.0 * whole, min(3 * passages, 24)), (longest / 3, 64)]
    else:
        step = max(float(np.median(np.diff(t))), whole / 1e4)
        scales = [(2.0 * whole, 24), (whole / 8, 48), (3.0 * step, 64)]
    found = []
    for tau, nodes in scales:
        moments = np.unique(np.quantile(t, np.linspace(0, 1, min(nodes, n))))
        apart = np.abs(moments[:, None] - moments[None])
        root = np.linalg.cholesky(np.exp(-apart / max(tau, 1e-9)) + 1e-9 * np.eye(len(moments)))
        found.append(hats(t, moments) @ root)  # (n, M): times M standard normals, the process
        if nodes >= n:
            break
    return found


def hats(x: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """(n, M) weights of nodes (M,) in lines between them."""
    result = np.zeros((len(x), len(nodes)))
    if len(nodes) == 1:
        result[:, 0] = 1.0
        return result
    k = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    share = np.clip((x - nodes[k]) / (nodes[k + 1] - nodes[k]), 0.0, 1.0)
    result[np.arange(len(x)), k] = 1.0 - share
    result[np.arange(len(x)), k + 1] = share
    return result


# -- autoregression --------------------------------------------------------------------------------


def learned(
    unit: Unit,
    left: np.ndarray,
    rounding: np.ndarray,
    train: np.ndarray,
    most: float = np.inf,
    posterior: np.ndarray | None = None,
) -> None:
    """Set a unit's white noise, tails and autoregression from what everything else leaves of it,
    (n,) mm; rounding (n,) mm; train (n,) bool: rows that may be looked at; most mm: of the white
    noise, what is left beyond it may as well be an effect that has no name yet; posterior (n, q)
    mm: see autoregression."""
    relative = np.clip(unit.r / np.median(unit.r), 0.2, 20.0)
    scaled = np.where(train, left, 0.0) / relative
    if train.sum() > 2 * AROUND:  # noise comes and goes: a burst, a compressor that runs
        local = _locally(scaled[train], (rounding / relative)[train], unit.dense)
        relative[train] *= local
        scaled[train] /= local
    base = max(spread(scaled[train]), unit.floor)
    far = np.abs(scaled) / base
    if unit.dense:  # of neighbours that lie off together each is real
        near = (
            np.maximum(
                np.abs(np.concatenate([scaled[1:], [0]])),
                np.abs(np.concatenate([[0], scaled[:-1]])),
            )
            / base
        )
        far = np.where(near > TAIL / 2, 0.0, far)
        if len(left) > 64:
            own = [(a, b) for a, b in pairwise(unit.edges) if b - a > 32 and train[a:b].all()]
            known = np.zeros((len(left), 0)) if posterior is None else posterior / relative[:, None]
            unit.ar, unit.innovation, total = autoregression(
                [without_lines(np.clip(scaled[a:b], -4 * base, 4 * base)) for a, b in own],
                [known[a:b] for a, b in own],
            )
            base = max(total, unit.floor)
    base = min(unit.shrunk(base), most)
    unit.r = np.maximum(base * relative * np.where(far > TAIL, far / 2, 1.0), rounding)


def _locally(values: np.ndarray, rounding: np.ndarray, dense: bool) -> np.ndarray:
    """(n,) by how much the readings around each scatter more or less than all of them, by medians;
    1 where that is chance. Samples of a motion by their third differences: neither a stretch that
    lies off nor a wave of many samples scatters, and less than the rounding (n,) says nothing."""
    size = np.hypot(_third(values), rounding) if dense else np.abs(values)
    usual = max(float(np.median(size)), 1e-12)
    around = median_filter(size, AROUND, mode="nearest") / usual
    chance = CHANCE_THIRD if dense else CHANCE
    return np.where(np.abs(np.log(np.maximum(around, 1e-3))) > chance, np.clip(around, *LOCAL), 1.0)


def _third(values: np.ndarray) -> np.ndarray:
    """(n,) third differences, of white noise as large as its first ones are."""
    differences = np.diff(values, 3, prepend=values[:1].repeat(2), append=values[-1:])
    return np.asarray(differences * np.sqrt(2.0 / 20.0))


def autoregression(
    parts: list[np.ndarray], posterior: list[np.ndarray] | None = None
) -> tuple[np.ndarray, float, float]:
    """Coefficients, the innovation's share of the variance, and the standard deviation, of
    stretches of one process. posterior (n, q): of each a root of the covariance with which what was
    taken out of it is known: as much may have gone with it (the expectation step of Dempster,
    Laird, Rubin, J. Royal Stat. Soc. B 39, 1977, 1). Lengths in one unit."""
    if not parts:
        return np.zeros(0), 1.0, 0.0
    n = sum(len(p) for p in parts)
    most = max(ORDERS)
    sums = np.zeros(most + 1)
    for p in parts:
        for k in range(most + 1):
            sums[k] += float(p[k:] @ p[: len(p) - k])
    for q in posterior or []:
        for k in range(most + 1):
            sums[k] += float(np.einsum("ij,ij->", q[k:], q[: len(q) - k]))
    covariance = sums / n  # not n - k: such a sequence is never indefinite, so no process grows
    best = (np.zeros(0), 1.0)
    least = np.inf
    if covariance[0] <= 0:
        return *best, 0.0
    for order in ORDERS:
        if order:
            toeplitz = covariance[np.abs(np.subtract.outer(np.arange(order), np.arange(order)))]
            a = np.linalg.solve(
                toeplitz + 1e-9 * covariance[0] * np.eye(order), covariance[1 : order + 1]
            )
        else:
            a = np.zeros(0)
        share = max(1.0 - float(a @ covariance[1 : order + 1]) / covariance[0], 1e-4)
        cost = n * np.log(share) + order * np.log(n)  # the criterion, but for a constant
        if cost < least - 1e-9:
            least, best = cost, (a, share)
    return *best, float(np.sqrt(covariance[0]))
