"""The figures of a diagnosis that the document for programs and the words for a person share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from postproc.diagnose.answer import Diagnosis, Finding, floor
from postproc.diagnose.experiments import separating

UM = 1e3


def fit_of(d: Diagnosis) -> dict[str, Any]:
    """Before, after and the noise floor, of runs that took no part; None where every run was
    needed."""
    if not d.held.any():
        return {
            "held_out": None,
            "rms_before_um": None,
            "rms_after_um": None,
            "noise_floor_um": None,
            "coverage95": None,
        }
    which = d.held
    return {
        "held_out": d.held_name,
        "rms_before_um": rounded(rms(shown(d, d.before)[which])),
        "rms_after_um": rounded(rms(shown(d, d.after)[which])),
        "noise_floor_um": rounded(rms(shown(d, floor(d))[which])),
        # d.sigma holds the noise and what the form of the names may be wrong by; noise_floor_um the
        # noise alone, as these readings have it.
        "coverage95": rounded(float(np.mean(np.abs(d.after[which]) <= 1.96 * d.sigma[which]))),
    }


def rms(values: np.ndarray) -> float:
    """Root of the mean square of values (N,), in their unit; 0 of none."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def scaled(d: Diagnosis, signal: int) -> tuple[float, str]:
    """What a signal is multiplied by to be read, and in which unit: um, of angles urad."""
    seen = d.rows.sees[d.rows.signal == signal]
    return (1e6, "urad") if len(seen) and seen[0] == "angle" else (UM, "um")


def shown(d: Diagnosis, values: np.ndarray) -> np.ndarray:
    """(N,) um of readings in mm; of angles in rad urad, which are um at a metre's distance."""
    shown: np.ndarray = np.where(d.rows.sees == "angle", 1e6, UM) * values
    return shown


def next_test(d: Diagnosis, f: Finding) -> str | None:
    """What tells a finding from what explains as well; None where nothing does."""
    return (
        (f.next_test or separating(f.block.key, f.equivalent, d.machine)) if f.equivalent else None
    )


def middle(d: Diagnosis, values: np.ndarray) -> np.ndarray:
    """(N,) each signal's mean: a set-up zero that explains nothing. A feature of a part has
    none."""
    result = np.zeros(len(values))
    for signal in np.unique(d.rows.signal):
        which = (d.rows.signal == signal) & (d.rows.sees != "part")
        if not which.any():
            continue
        result[which] = values[which].mean()
    return result


def rounded(value: float, digits: int = 4) -> float:
    """So many significant digits; a number that JSON knows."""
    if not math.isfinite(value):
        # JSON has no inf and no nan: python writes them as Infinity and NaN, which other readers
        # refuse
        return 0.0 if math.isnan(value) else math.copysign(1e300, value)
    return float(f"{value:.{digits}g}")
