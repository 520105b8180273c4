"""The mains' frequency in the readings of an instrument that is read in motion.

Cables, amplifiers and earth loops pick up 50 or 60 Hz and its harmonics; samples of a lower rate
show it at an alias. A line within 0.1 Hz of it is taken for that: the public grid keeps its
frequency so well in normal operation (EN 50160 allows 1 % at times), induction motors slip by 1 to
5 % below it, and a mode lies there by chance only. Phase and amplitude are those of each run.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.fft import next_fast_len

from postproc.diagnose.averages import MOST_SAMPLES
from postproc.diagnose.noise import Unit
from postproc.diagnose.noise_lines import LINE
from postproc.diagnose.rows import Rows
from postproc.diagnose.spectra import LOWEST_HZ, polished
from postproc.effects import waves_of

GRID, KEPT = (50.0, 60.0), 0.1  # Hz; by how much it differs
HARMONICS = (2, 3)  # rectifiers and magnetising currents
AROUND = 2.5  # Hz, on either side, of the spectrum that a line must stand out of
SLOWEST = 4.0  # Hz: in slower samples a line is so near to an alias by chance, in one of five
MOST_RUNS = 12  # runs with a phase of their own
FEWEST = 32  # rows of a run
CURVE = 8.0  # periods in the longest run: fewer may be a curve


def waves(rows: Rows, units: list[Unit]) -> list[np.ndarray | None]:
    """For each unit (n, 2 R) the cosine and sine of each run at the frequencies that are found;
    None where there are none."""
    result: list[np.ndarray | None] = []
    for unit in units:
        runs = _runs(rows, unit)
        found = [
            wave[unit.rows] * own
            for hz in _lines(rows, unit, runs)
            for wave in waves_of(rows.state, "time", hz)
            for own in runs
        ]
        result.append(np.stack(found, axis=1) if found else None)
    return result


def notices(rows: Rows, units: list[Unit]) -> list[str]:
    """What a person is told of each signal that holds it."""
    return [
        f"{Path(rows.files[rows.file[unit.rows[0]]]).name}:"
        f" {rows.signals[rows.signal[unit.rows[0]]]} holds the mains' frequency, {found[0]:.2f} Hz:"
        " pickup of the instrument, taken out; what swings at exactly that frequency looks the"
        " same: record with the drives switched off"
        for unit in units
        if (found := _lines(rows, unit, _runs(rows, unit)))
    ]


def _runs(rows: Rows, unit: Unit) -> list[np.ndarray]:
    """(n,) bool of each run; of many, of all together."""
    run = rows.run[unit.rows]
    numbers = np.unique(run)
    if len(numbers) > MOST_RUNS:
        return [np.ones(len(run), bool)]
    return [run == number for number in numbers]


def _lines(rows: Rows, unit: Unit, runs: list[np.ndarray]) -> list[float]:
    """Hz: the mains' frequency and its harmonics in the readings of a unit."""
    parts = [unit.rows[own] for own in runs if own.sum() >= FEWEST]
    if not unit.dense or not parts:
        return []
    times = [rows.state.time[own] for own in parts]
    gaps = np.concatenate([np.diff(t) for t in times])
    usual = float(np.median(gaps))
    longest = max(float(np.ptp(t)) for t in times)
    if not 0 < usual <= 1.0 / SLOWEST or longest > usual * MOST_SAMPLES:
        return []
    rate = 1.0 / float(np.mean(gaps[gaps < 1.5 * usual]))
    bins = next_fast_len(int(4 * longest * rate) + 4, real=True)
    power = np.zeros(bins // 2 + 1)
    for t, own in zip(times, parts, strict=True):
        index = np.round((t - t[0]) * rate).astype(int)
        one = np.abs(np.fft.rfft(np.bincount(index, _windowed(rows, own), bins)[:bins])) ** 2
        power += one / max(float(np.median(one)), 1e-30)
    sums = [(t, _windowed(rows, own), 1.0) for t, own in zip(times, parts, strict=True)]
    found = []
    for mains in GRID:
        first = _line(power, rate, mains, KEPT)
        others = [_line(power, rate, k * first, KEPT) for k in HARMONICS if first]
        found += [polished(hz, rate / bins, sums) for hz in (first, *others) if hz]
    return found


def _line(power: np.ndarray, rate: float, middle: float, kept: float) -> float:
    """Hz: where a spectrum (B,) of samples of some rate (Hz) is highest near a frequency, if that
    is within `kept` of it and stands out; 0 where not, or where such samples show it too slow to be
    told from a curve."""
    step = rate / 2 / (len(power) - 1)
    frequency = middle + np.arange(-AROUND, AROUND, step)
    seen = np.abs(frequency - rate * np.round(frequency / rate))
    told = seen > max(CURVE * 4 * step, LOWEST_HZ)
    near = np.abs(frequency - middle) <= kept
    if not told[near].all():
        return 0.0
    around = np.where(told, power[np.round(seen / step).astype(int)], 0.0)
    best = int(np.argmax(around * near))  # two frequencies of the window may share an alias
    clear = around[best] >= max(LINE * float(np.median(around[told])), float(around.max()))
    return float(frequency[best]) if clear else 0.0


def _windowed(rows: Rows, own: np.ndarray) -> np.ndarray:
    """(n,) the readings of a run, about their mean and with soft ends (Hann)."""
    y = rows.residual[own]
    return np.asarray((y - y.mean()) * np.hanning(len(y)))
