"""What a fitted set says of the readings: what explains them, the noise that is left, and readings
drawn as they would be without any effect."""

from __future__ import annotations

import numpy as np

from postproc.diagnose.evidence import Evidence, Fit
from postproc.diagnose.noise import Unit
from postproc.diagnose.nuisances import FREE
from postproc.diagnose.parts import inverted
from postproc.diagnose.rows import Rows

GROWN = 4.0  # times what is usual


def shares(evidence: Evidence, fit: Fit) -> dict[str, np.ndarray]:
    """(N,) mm of the readings: "effects", "map", and each kind of own group; "noise": the
    standard deviation of a reading by white noise, wander and zeros of runs."""
    n = len(evidence.y)
    z = evidence.shared.shape[1]
    result = {"map": evidence.shared @ fit.mean[:z], "noise": np.zeros(n)}
    result["effects"] = np.zeros(n)
    at = z
    for k in fit.chosen:
        w = evidence.blocks[k].width
        result["effects"] += evidence.blocks[k].columns @ fit.mean[at : at + w]
        at += w
    for k, (part, old) in enumerate(zip(evidence.parts, fit.parts, strict=True)):
        own, use = part.whole.rows, old.use
        part.looked_at(old)
        # of the unit's own coefficients, the shared ones at their mean (as Part.renewed)
        mean = inverted(old.root).T @ (
            old.hy - old.hf @ fit.mean[evidence.shared_at(k, fit.chosen)]
        )
        # Of a reading that is to come: white noise, and what wanders and the zero of a run may be
        # then, not what they were here.
        variance = old.sigma2 * part.whole.r**2
        for g in np.unique(part.of[use]):
            columns, kind = part.groups[g].columns, part.kinds[g]
            result.setdefault(kind, np.zeros(n))[own] += columns @ mean[part.of[use] == g]
            if kind in ("wander", "run"):
                variance = variance + old.sd[g] ** 2 * np.einsum("ij,ij->i", columns, columns)
        result["noise"][own] = np.sqrt(variance)
    return result


def of_others(values: np.ndarray, rows: Rows, evidence: Evidence) -> np.ndarray:
    """(N,) mm: noise, and of units of which no reading took part that of others: of the same signal
    in other recordings, else of what sees the same, else of all (the median)."""
    took_part = np.zeros(len(rows), bool)
    for part in evidence.parts:
        took_part[part.whole.rows] = True
    result, name = values.copy(), np.array([rows.signals[k] for k in rows.signal], object)
    for signal in np.unique(rows.signal[~took_part]):
        own = (rows.signal == signal) & ~took_part
        first = int(np.flatnonzero(own)[0])
        alike = (
            took_part & (name == name[first]),
            took_part & (rows.sees == rows.sees[first]),
            took_part,
        )
        result[own] = np.median(values[next((x for x in alike if x.any()), own)])
    return result


def wandered(evidence: Evidence, fit: Fit) -> bool:
    """Whether what is learned of some unit or of the map has grown far beyond what is usual."""
    own = (
        np.any(old.sd[p.learned] > GROWN * p.usual[p.learned])
        for p, old in zip(evidence.parts, fit.parts, strict=True)
    )
    return any(own) or bool(np.any(fit.shared > 1.5 * evidence.shared_usual))


def white(evidence: Evidence, fit: Fit) -> np.ndarray:
    """(N,) mm: standard deviation of each reading's white noise."""
    result = np.zeros(len(evidence.y))
    for part, old in zip(evidence.parts, fit.parts, strict=True):
        result[part.whole.rows] = part.whole.r * np.sqrt(old.sigma2)
    return result


def scatter(evidence: Evidence, fit: Fit, said: dict[str, np.ndarray]) -> np.ndarray:
    """(N,) mm: the noise of the readings as these have it: white noise, and what wandered and
    what zeros of runs did in each unit, not what they do in others. said: of `shares`."""
    result = white(evidence, fit)
    moved = sum(
        (said[kind] for kind in ("wander", "run") if kind in said), np.zeros(len(evidence.y))
    )
    for part in evidence.parts:
        own = part.whole.rows
        result[own] = np.hypot(result[own], float(np.std(moved[own])))
    return result


def drawn(evidence: Evidence, fit: Fit, rng: np.random.Generator, count: int) -> np.ndarray:
    """(N, count) mm of readings without any effect: white noise, autoregression, wander, runs'
    zeros, the map's error."""
    z = evidence.shared.shape[1]
    y = (
        evidence.shared * np.where(evidence.shared_free, 0.0, fit.shared[evidence.shared_of])
    ) @ rng.normal(size=(z, count))
    for part, old in zip(evidence.parts, fit.parts, strict=True):
        n = len(part.unit)
        # Student's t with 5 degrees of freedom has the variance 5/3.
        e = rng.standard_t(5, size=(n, count)) * np.sqrt(3 / 5 * old.sigma2)
        y[part.unit.rows] += _colored(part.unit, e) * part.unit.r[:, None]
        # not the unknown zeros: they are free in the fit that judges a draw, so nothing of them is
        # left
        use = np.flatnonzero((old.sd[part.of] < FREE / 10) & part.usually)
        y[part.whole.rows] += (part.raw[:, use] * old.sd[part.of[use]]) @ rng.normal(
            size=(len(use), count)
        )
    return y


def _colored(unit: Unit, e: np.ndarray) -> np.ndarray:
    """(n, R): innovations to an autoregression."""
    result = e * np.sqrt(unit.innovation) if len(unit.ar) else e
    backwards = unit.ar[::-1]
    for k in range(1, len(e)) if len(unit.ar) else ():
        lags = min(k, len(backwards))
        result[k] += backwards[-lags:] @ result[k - lags : k]
    return result
