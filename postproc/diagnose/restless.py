"""Stick-slip that nobody can foretell sample by sample: where an axis creeps, what is left is rougher than elsewhere.

Jumps too short for the samples leave no mean, only a spread. Two variances are compared by their likelihoods, before the turn of an
axis and after it: a spike of the reversal is rough on one side only.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

import numpy as np

from postproc import effects
from postproc.diagnose.rows import XYZ, Rows
from postproc.effects import grid

LEAST = 24.0  # fall of -2 ln(likelihood) of each half
LEAST_MM = 3e-4  # rms beyond the noise
FEWEST = 12  # rows of each half
SLOWEST, FASTEST = 0.4, 6.0  # mm/s
LIKE = (  # rough in the turn too
    "reversal_spike", "friction_asymmetry", "windup", "backlash", "backlash_position", "coulomb_friction", "stick_slip",
)  # fmt: skip


@dataclass(frozen=True)
class Creep:
    """An axis that is restless while it creeps. fastest mm/s; rms mm beyond the noise; fall of -2 ln(likelihood)."""

    axis: str
    fastest: float
    rms: float
    fall: float


def creeping(rows: Rows, left: np.ndarray, sigma: np.ndarray, alike: np.ndarray) -> Creep | None:
    """The axis and speed below which the readings of sampled motions are rough, None where none is. left, sigma (N,) mm;
    alike (N,) by how much sigma was inflated for neighbours that are alike."""
    able = (rows.state.passage >= 0) & np.isin(rows.sees, ("tool", "scale"))
    if not able.any():
        return None
    rough, scale = np.zeros(len(rows)), np.zeros(len(rows))
    for passage in np.unique(rows.state.passage[able]):  # what changes slowly is no roughness
        for signal in np.unique(rows.signal[able & (rows.state.passage == passage)]):
            own = np.flatnonzero(able & (rows.state.passage == passage) & (rows.signal == signal))
            if len(own) > 4:
                bent = left[own]
                # over the spread of this signal's own differences: signals are not equally quiet
                second = (bent[1:-1] - (bent[2:] + bent[:-2]) / 2) / np.sqrt(1.5)
                quiet = np.median(np.abs(second)) * 1.4826
                rough[own[1:-1]] = second / max(quiet, 1e-9)
                scale[own] = quiet
    best: Creep | None = None
    for axis in rows.state.position:
        share = rows.direction[:, XYZ.index(axis)] ** 2
        speed = np.abs(rows.state.velocity[axis])
        towards = rows.state.velocity[axis] * rows.state.acceleration[axis] < 0
        base = able & (share > 0.3) & (speed > 0)
        if not base.any():
            continue
        for fastest in grid(SLOWEST, FASTEST, 10):
            slow = base & (speed < fastest)
            quick = base & (speed > 1.5 * fastest)
            if np.count_nonzero(quick) < 4 * FEWEST:
                continue
            falls, sizes = [], []
            for half in (slow & towards, slow & ~towards):
                if np.count_nonzero(half) < FEWEST:
                    break
                level = float(np.mean(_tame(rough[quick]) ** 2))
                now = float(np.mean(_tame(rough[half]) ** 2))
                ratio = now / max(level, 1e-30)
                n = np.count_nonzero(half) / float(np.median(alike[half])) ** 2
                falls.append(n * (ratio - 1 - np.log(ratio)) if ratio > 1 else 0.0)
                sizes.append((now - level) * float(np.median(scale[half])) ** 2)
            if len(falls) == 2 and min(falls) > LEAST and min(sizes) > LEAST_MM**2:
                found = Creep(axis, fastest, float(np.sqrt(np.mean(sizes))), float(2 * min(falls)))
                best = found if best is None or found.fall > best.fall else best
    # Rough at all speeds is no creeping; rough in the very turn alone is a spike.
    return best if best is not None and SLOWEST < best.fastest < FASTEST else None


def misfit(left: np.ndarray, sigma: np.ndarray, alike: np.ndarray) -> float:
    """-2 ln(likelihood) of what a choice leaves, (N,) mm, at its own noise: a spread that nobody can foretell is paid for, too."""
    return float(np.sum((left / sigma) ** 2 + 2.0 * np.log(sigma / alike) / alike**2))


def rows_of(rows: Rows, creep: Creep) -> np.ndarray:
    """(N,) how much of the roughness enters a row, 0 to 1."""
    slow = (rows.state.passage >= 0) & (np.abs(rows.state.velocity[creep.axis]) < creep.fastest)
    return np.where(slow & np.isin(rows.sees, ("tool", "scale")), np.abs(rows.direction[:, XYZ.index(creep.axis)]), 0.0)


def _tame(values: np.ndarray) -> np.ndarray:
    """Without the few that alone would decide."""
    limit = np.quantile(np.abs(values), 0.97) if len(values) else 0.0
    return np.clip(values, -limit, limit)


def named(creep: Creep) -> tuple[ModuleType, dict[str, float], dict[str, float]]:
    """The effect's module, its shape and its parameters."""
    module = effects.load("stick_slip")
    shape = {"period_mm": 0.0, "fastest_mm_s": creep.fastest}
    return module, shape, {"size_um": float(creep.rms * 1e3 * np.sqrt(12.0))} | shape
