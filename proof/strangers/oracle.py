"""What a perfect observer could know: signal energy mu^T C^-1 mu with the true covariance.

C = fast noise (whitened) + slow kinds (FITC on knots in time, Snelson and Ghahramani 2006) + map
error (Gaussian process over place, exact on its knots); zeros, set-ups, ballbar centres are free
columns.  Everything is reduced to one Gram matrix of [effects, map knots].
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.signal import lfilter

from .base import AX, Array, Part, Rec, observe
from .machines import Machine, hat, map_prior, place
from .noise import Noise

FREE = 1e8  # um^2, variance of a free column


def free_columns(rec: Rec) -> list[Array]:
    """Constant zero (or one per run), ballbar centre; parts on a CMM have none."""
    if rec.kind == "features":
        return []
    runs = np.unique(rec.run) if rec.meta.get("zero_by_run") else [None]
    cols = [np.ones(rec.n_obs) if k is None else (rec.run == k) * 1.0 for k in runs]
    if rec.kind == "ballbar":
        cols += [rec.meta["unit"][:, a] for a in rec.meta["plane"]]
    return cols


def slow_columns(noise: Noise, t: Array, var: Array) -> tuple[list[Array], Array]:
    """Low-rank columns of the slow kinds; what the knots miss is added to the diagonal."""
    cols, var = [c[:, None] for c in noise.columns], var.copy()
    knots = t[np.unique(np.linspace(0, len(t) - 1, min(len(t), 90)).astype(int))]
    knots = np.unique(knots)
    for k, _ in noise.kernels:
        kmm = k(knots, knots)
        kmm = kmm + 1e-6 * (np.trace(kmm) / len(knots) + 1e-12) * np.eye(len(knots))
        low = np.linalg.cholesky(kmm)
        phi = solve_triangular(low, k(knots, t), lower=True).T
        diag = full_diag(k, t)
        rest = np.maximum(diag - (phi**2).sum(1), 0)
        trig = getattr(k, "trig", None)
        if trig is not None:
            phi, rest = phi * trig[:, None], rest * trig**2
        # between knots the rest is a bridge: its interval mean has half its variance
        cols.append(phi)
        var += rest * max(1.0, len(t) / len(knots) / 2)
    return cols, var


def full_diag(k: object, t: Array) -> Array:
    """Diagonal of a kernel without forming the matrix (evaluated in blocks of 50)."""
    out = np.empty(len(t))
    grid = np.unique(np.linspace(0, len(t) - 1, 60).astype(int))
    val = np.array([float(k(t[i : i + 1], t[i : i + 1])[0, 0]) for i in grid])  # type: ignore
    out[:] = np.interp(t, t[grid], val)
    return out


def map_columns(m: Machine, rec: Rec, factor: float) -> dict[tuple[int, str], Array]:
    """Readings (channels, n, 12) per unit normal of each component's map error."""
    if not rec.outside:
        return {}
    root, out = np.linalg.cholesky(map_prior(m)), {}
    for key in m.map_true:
        ax, comp = key
        if ax not in rec.moving and comp[1] in AX and rec.kind != "features":
            continue
        probe, rot = place(comp, ax, np.ones(len(rec.t)), m.arm(ax, rec.pos))
        gain = observe(rec, Part(tool=probe, rot=rot))
        if rec.kind == "features":
            two = np.zeros((len(rec.t), 12))
            h = hat(m, ax, rec.pos[:, ax])
            two = np.stack(
                [observe(rec, Part(tool=probe * h[:, j : j + 1]))[0] for j in range(12)], 1
            )[None]
            out[key] = two @ root * m.u * factor
        elif np.abs(gain).max() > 1e-12:
            h = hat(m, ax, rec.pos[:, ax])
            out[key] = gain[:, :, None] * (h @ root)[None] * m.u * factor
    return {k: v for k, v in out.items() if np.abs(v).max() > 1e-9}


class Oracle:
    """Noise model of an experiment; `gram` of effects is exact up to the knots."""

    def __init__(self, m: Machine, recs: list[Rec], noises: list[list[Noise]], factor: float):
        self.recs, self.parts = recs, []
        keys: list[tuple[int, str]] = []
        cols = [map_columns(m, q, factor) for q in recs]
        for c in cols:
            keys += [k for k in c if k not in keys]
        self.g = 12 * len(keys)
        for q, c, ns in zip(recs, cols, noises, strict=False):
            t = q.t_obs - q.t_obs[0]
            for ch, n in enumerate(ns):
                slow, var = slow_columns(n, t, n.var)
                free = [np.sqrt(FREE) * x[:, None] for x in free_columns(q)]
                use = {k: v[ch] for k, v in c.items() if np.abs(v[ch]).max() > 1e-9}
                self.parts.append(
                    (
                        q,
                        ch,
                        n,
                        np.hstack(slow + free) if slow + free else np.zeros((len(t), 0)),
                        var,
                        np.hstack(list(use.values())) if use else np.zeros((len(t), 0)),
                        [12 * keys.index(k) + j for k in use for j in range(12)],
                    )
                )
        self.ready = [self.prepare(*p) for p in self.parts]

    def prepare(
        self, q: Rec, ch: int, n: Noise, low: Array, var: Array, mp: Array, idx: list[int]
    ) -> tuple:
        """Whitened map columns with the local low-rank part factored."""
        sd = np.sqrt(var)[:, None]
        if len(n.white_a) > 1:  # the filter's start is not stationary: drop it
            sd[:60] = 1e6
        wl = self.whiten(n, low) / sd
        wm = self.whiten(n, mp) / sd
        fac = cho_factor(np.eye(wl.shape[1]) + wl.T @ wl) if wl.shape[1] else None
        wlm = wl.T @ wm
        mm = wm.T @ wm - (wlm.T @ cho_solve(fac, wlm) if fac is not None else 0)
        return q, ch, n, sd, wl, wm, fac, wlm, mm, idx

    @staticmethod
    def whiten(n: Noise, x: Array) -> Array:
        """Inverse filter of the fast noise (columns)."""
        if x.shape[1] == 0 or (len(n.white_a) == 1 and len(n.white_b) == 1):
            return x
        return lfilter(n.white_a, n.white_b, x, axis=0)

    def gram(self, mus: list[list[Array]]) -> Array:
        """E[i,j] = mu_i^T C^-1 mu_j; mus[effect][file] is channels x readings."""
        k = len(mus)
        mm, me = np.eye(self.g), np.zeros((self.g, k))
        ee = np.zeros((k, k))
        where = {id(q): i for i, q in enumerate(self.recs)}
        for q, ch, n, sd, wl, wm, fac, wlm, mloc, idx in self.ready:
            e = np.stack([mu[where[id(q)]][ch] for mu in mus], 1)
            we = self.whiten(n, e) / sd
            wle = wl.T @ we
            z = cho_solve(fac, wle) if fac is not None else np.zeros_like(wle)
            ee += we.T @ we - wle.T @ z
            if idx:
                mm[np.ix_(idx, idx)] += mloc
                me[idx] += wm.T @ we - wlm.T @ z
        if self.g:
            ee = ee - me.T @ np.linalg.solve(mm, me)
        return (ee + ee.T) / 2


def alone(e: Array, i: int) -> float:
    """Energy of effect i with all other effects' amplitudes free."""
    others = [j for j in range(len(e)) if j != i]
    if not others:
        return max(float(e[i, i]), 0.0)
    b = e[np.ix_(others, others)]
    b = b + np.diag(1e-9 * np.diag(b) + 1e-12)
    return max(float(e[i, i] - e[i, others] @ np.linalg.solve(b, e[others, i])), 0.0)
