"""What others would do with the same recordings: always backlash; a polynomial by direction; a
Gaussian process; STLSQ.

All get what gcomp has: its reader, the map taken off, its white noise, and the same nuisances with
their usual sizes (zeros of set-ups and of runs, centres of ballbars, the map's own error), so that
only the way of explaining differs. Autoregression and wander they do not get: gcomp learns the size
of these beside every set of effects, and with a stated size the baselines predicted held-out runs
worse in five of six cases. All are trained on what gcomp is trained on and judged on what it holds
out: the last run of every recording that has three at least.

STLSQ is the sequential thresholded least squares of Brunton, Proctor and Kutz, PNAS 113 (2016)
3932, as PySINDy has it by default (ridge 0.05, at most 20 rounds), written here anew, on gcomp's
own library. It gets two hints: of every effect and axis only the shape that suits best by itself (a
whole grid of alike columns would share one coefficient among them until each is below the
threshold), and a threshold of 2 um of a column's peak, because no smaller effect is ever hidden.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.polynomial.legendre import legval

ORDER = 5
THRESHOLD, RIDGE, ROUNDS = 2e-3, 0.05, 20  # mm at the peak of a column
MATERIAL = 7e-4  # mm: what counts as a name
POINTS = 300  # of a signal that a Gaussian process learns from
XYZ = "XYZ"


@dataclass
class Problem:
    """The readings (N,) mm as all methods get them. u, prior: nuisances; train: which rows may be
    learnt from."""

    rows: object
    y: np.ndarray
    sigma: np.ndarray
    u: np.ndarray
    prior: np.ndarray
    train: np.ndarray


@dataclass
class Guess:
    """names: effect:axis, the largest first; after: mm rms of what is left of the rows held out."""

    names: list[str]
    after: float


def problem(case: Path) -> Problem:
    """The rows of a case."""
    from postproc import recordings
    from postproc.diagnose import isolated
    from postproc.diagnose.assembly import of
    from postproc.machine.file import read_machine

    options = recordings.ReadingOptions(strict=False)
    files = sorted(case.glob("r*.csv"))
    read = [
        recordings.read(recordings.Source(str(f), f.read_bytes()), options=options) for f in files
    ]
    machine = read_machine(case / "machine")
    rows = of(read, machine)
    rows = rows.pick(isolated.isolated(rows, rows.residual, _sigma(rows))[0] < 6.0)
    return Problem(rows, rows.residual, _sigma(rows), *_nuisances(rows, machine), ~held_out(rows))


def _sigma(rows) -> np.ndarray:
    """(N,) mm: standard deviation of the white noise of each reading."""
    from postproc.diagnose import noise

    sigma = np.empty(len(rows))
    for unit in noise.units(rows):
        sigma[unit.rows] = unit.r
    return sigma


def _nuisances(rows, machine) -> tuple[np.ndarray, np.ndarray]:
    """(N, Q) columns and (Q,) their usual standard deviations: those of each instrument but its
    wander, and the map's own error."""
    from postproc.diagnose import noise, nuisances

    columns, prior = [], []
    for unit in noise.units(rows):
        for group in nuisances.of_unit(rows, unit):
            if group.kind == "wander":
                continue
            wide = np.zeros((len(rows), group.columns.shape[1]))
            wide[unit.rows] = group.columns
            columns.append(wide)
            prior.append(np.full(wide.shape[1], group.sd))
    for group in nuisances.of_map(rows, machine):
        columns.append(group.columns)
        prior.append(np.full(group.columns.shape[1], group.sd))
    return np.concatenate(columns, axis=1), np.concatenate(prior)


def held_out(rows) -> np.ndarray:
    """(N,) the last run of every recording with three at least, parts apart."""
    held = np.zeros(len(rows), bool)
    for file, kind in enumerate(rows.kinds):
        which = rows.file == file
        runs = np.unique(rows.run[which])
        if len(runs) >= 3 and kind != "features":
            held |= which & (rows.run == runs[-1])
    return held


def rms(p: Problem, left: np.ndarray) -> float:
    held = ~p.train if (~p.train).any() else p.train
    return float(np.sqrt(np.mean(left[held] ** 2)))


def fitted(p: Problem, columns: np.ndarray, free: float = 10.0) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (K,) and what is left (N,), nuisances taken out, from the rows of training."""
    peak = np.maximum(np.abs(columns).max(axis=0), 1e-12) if columns.shape[1] else np.zeros(0)
    both = np.concatenate([columns, p.u], axis=1)
    size = np.r_[free / peak, p.prior]
    w = 1 / p.sigma[p.train]
    a = both[p.train] * w[:, None] * size
    solved = np.linalg.solve(a.T @ a + np.eye(len(size)), a.T @ (p.y[p.train] * w)) * size
    return solved[: columns.shape[1]], p.y - both @ solved


def nothing(p: Problem) -> Guess:
    return Guess([], rms(p, fitted(p, np.zeros((len(p.y), 0)))[1]))


def always_backlash(p: Problem) -> Guess:
    """Half the gap against the direction of the axis that it suits best."""
    best: tuple[float, str, np.ndarray] | None = None
    for x, side in _sides(p):
        column = -0.5 * (side * _enters(p, x))[:, None]
        if np.abs(column[p.train]).max() < 1e-9:
            continue
        left = fitted(p, column)[1]
        chi = float(((left / p.sigma)[p.train] ** 2).sum())
        if best is None or chi < best[0]:
            best = chi, f"backlash:{x}", left
    return Guess([best[1]], rms(p, best[2])) if best else nothing(p)


def polynomial(p: Problem) -> Guess:
    """Of order 5 along every axis, one for each direction. Its name is that of the largest part:
    the same in both directions a line or a curve, opposite a constant or a curve."""
    parts: list[tuple[str, np.ndarray]] = []
    for x, side in _sides(p):
        u = _share(p, x)
        enters = _enters(p, x)
        for k in range(ORDER + 1):
            shape = legval(u, [0] * k + [1]) * enters
            if k:
                parts.append((f"{'scale' if k == 1 else 'pitch_shape'}:{x}", shape))
            parts.append((f"{'backlash' if k == 0 else 'backlash_position'}:{x}", shape * side))
    parts = [(n, c) for n, c in parts if np.abs(c[p.train]).max(initial=0.0) > 1e-9]
    if not parts:
        return nothing(p)
    columns = np.array([c for _, c in parts]).T
    value, left = fitted(p, columns, free=0.05)
    sizes: dict[str, np.ndarray] = {}
    for k, (name, _) in enumerate(parts):
        sizes[name] = sizes.get(name, 0.0) + columns[:, k] * value[k]
    return Guess(_ranked(p, sizes), rms(p, left))


def gaussian_process(p: Problem) -> Guess:
    """A squared exponential of the places, the directions and the time of each signal; lengths and
    size by marginal likelihood on a grid, learnt from 300 readings of a signal. It has no names."""
    _, left = fitted(p, np.zeros((len(p.y), 0)))
    left = left.copy()
    rows = p.rows
    for signal in np.unique(rows.signal):
        which = np.flatnonzero(rows.signal == signal)
        learn = which[p.train[which]]
        if len(learn) < 8:
            continue
        learn = learn[np.unique(np.linspace(0, len(learn) - 1, POINTS).astype(int))]
        inputs = _inputs(p, which)
        at = {int(k): i for i, k in enumerate(which)}
        left[which] -= _predicted(
            inputs[[at[int(k)] for k in learn]], left[learn], p.sigma[learn], inputs
        )
    return Guess([], rms(p, left))


def _inputs(p: Problem, which: np.ndarray) -> np.ndarray:
    rows = p.rows
    columns = [_share(p, x)[which] for x in rows.state.position] + [
        rows.state.approach[x][which] * 0.5 for x in rows.state.position
    ]
    t = rows.state.time[which]
    columns.append((t - t.min()) / max(float(np.ptp(t)), 1e-9) * 0.5)
    return np.array(columns).T


def _predicted(x: np.ndarray, y: np.ndarray, sigma: np.ndarray, to: np.ndarray) -> np.ndarray:
    """(M,) posterior mean at `to`; the best of a grid of lengths and sizes."""
    from scipy.linalg import cho_factor, cho_solve

    apart = ((x[:, None] - x[None]) ** 2).sum(axis=2)
    best: tuple[float, float, float, np.ndarray] | None = None
    spread = max(float(np.std(y)), 1e-6)
    for length in (0.1, 0.3, 1.0):
        for size in (0.3 * spread, spread):
            k = size**2 * np.exp(-apart / (2 * length**2)) + np.diag(sigma**2)
            factor = cho_factor(k, lower=True)
            alpha = cho_solve(factor, y)
            worth = -0.5 * y @ alpha - np.log(np.diag(factor[0])).sum()
            if best is None or worth > best[0]:
                best = worth, length, size, alpha
    assert best is not None
    cross = ((to[:, None] - x[None]) ** 2).sum(axis=2)
    return best[2] ** 2 * np.exp(-cross / (2 * best[1] ** 2)) @ best[3]


def stlsq(p: Problem) -> Guess:
    """Least squares on the whole library, small coefficients out, again until none is small."""
    from postproc.diagnose import fit, library

    rows = p.rows
    projector = fit.Projector.of(p.sigma, p.u, p.prior)
    blocks = [*library.blocks(rows), *library.found(rows, projector(p.y), p.sigma)]
    if not blocks:
        return nothing(p)
    part = fit.Projector.of(p.sigma[p.train], p.u[p.train], p.prior)
    best: dict[str, tuple[float, int]] = {}
    left = part(p.y[p.train])
    for k, b in enumerate(blocks):
        seen = b.columns[p.train]
        fall = (
            left
            @ seen
            @ np.linalg.pinv(seen.T @ part(seen), rcond=1e-9, hermitian=True)
            @ (left @ seen)
        )
        if b.key not in best or fall > best[b.key][0]:
            best[b.key] = fall, k
    blocks = [blocks[k] for _, k in best.values()]
    columns = np.concatenate([b.columns for b in blocks], axis=1)
    owner = np.repeat(np.arange(len(blocks)), [b.columns.shape[1] for b in blocks])
    peak = np.maximum(np.abs(columns).max(axis=0), 1e-12)
    columns = columns / peak
    scale = float(np.median(p.sigma)) ** 2
    after = part(columns[p.train])
    gram, right = scale * columns[p.train].T @ after, scale * after.T @ p.y[p.train]
    active = np.arange(len(peak))
    value = np.zeros(0)
    for _ in range(ROUNDS):
        value = np.linalg.solve(
            gram[np.ix_(active, active)] + RIDGE * np.eye(len(active)), right[active]
        )
        keep = np.abs(value) >= THRESHOLD
        if keep.all():
            break
        active, value = active[keep], value[keep]
        if not len(active):
            break
    sizes: dict[str, np.ndarray] = {}
    for k, v in zip(active, value, strict=True):
        key = blocks[owner[k]].key
        sizes[key] = sizes.get(key, 0.0) + columns[:, k] * v
    explained = sum(sizes.values(), np.zeros(len(p.y)))
    rest = Problem(rows, p.y - explained, p.sigma, p.u, p.prior, p.train)
    return Guess(_ranked(p, sizes), nothing(rest).after)


def _ranked(p: Problem, sizes: dict[str, np.ndarray]) -> list[str]:
    """Names whose part is material in some signal, the largest first."""
    worth = {}
    for name, part in sizes.items():
        amplitudes = [np.ptp(part[p.rows.signal == s]) / 2 for s in np.unique(p.rows.signal)]
        if max(amplitudes) > MATERIAL:
            worth[name] = float(np.std(part))
    return sorted(worth, key=lambda n: -worth[n])


def _sides(p: Problem) -> list[tuple[str, np.ndarray]]:
    return [(x, p.rows.state.approach[x]) for x in p.rows.state.position]


def _share(p: Problem, x: str) -> np.ndarray:
    return np.clip(p.rows.state.share(x), -1.2, 1.2)


def _enters(p: Problem, x: str) -> np.ndarray:
    return np.where(p.rows.sees == "angle", 0.0, p.rows.direction[:, XYZ.index(x)])


METHODS: dict[str, Callable[[Problem], Guess]] = {
    "map alone": nothing, "always backlash": always_backlash, "polynomial by direction": polynomial,
    "Gaussian process": gaussian_process, "STLSQ, same library": stlsq,
}  # fmt: skip


def all_of(case: Path) -> dict[str, dict]:
    """Every method on one case; names and um of rms held out, or what went wrong."""
    p = problem(case)
    found: dict[str, dict] = {}
    for name, method in METHODS.items():
        guess = method(p)
        found[name] = {"names": guess.names, "after_um": guess.after * 1e3}
    return found
