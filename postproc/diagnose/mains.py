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
AROUND = 1.0  # Hz, on either side, of the spectrum that a line must stand out of
BIN = 0.02  # s: sums over it hold what is so near, turned back by the mains' frequency
ALIKE = 0.05  # of a power
SLOWEST = 4.0  # Hz: in slower samples a line is so near to an alias by chance, in one of five
MOST_RUNS = 12  # runs with a phase of their own
FEWEST = 32  # rows of a run
CURVE = 8.0  # periods in the longest run: fewer may be a curve


Signal = tuple[np.ndarray, np.ndarray, float]


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
        " pickup of the instrument, taken out; a vibration of exactly that frequency looks"
        " the same: record with the drives switched off"
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
    gap = float(np.median(np.diff(rows.state.time[parts[0]])))
    signals = [(rows.state.time[own], _windowed(rows, own), 1.0) for own in parts]
    longest = max(float(np.ptp(t)) for t, _, _ in signals)
    if not 0 < gap <= 1.0 / SLOWEST or longest > BIN * MOST_SAMPLES:
        return []
    found = []
    for mains in GRID:
        first = _line(signals, longest, 1.0 / gap, mains, KEPT)
        others = [_line(signals, longest, 1.0 / gap, k * first, KEPT) for k in HARMONICS if first]
        found += [polished(hz, 0.25 / longest, signals) for hz in (first, *others) if hz]
    return found


def _line(signals: list[Signal], longest: float, rate: float, middle: float, kept: float) -> float:
    """Hz: where the powers of all signals (time, readings, 1) together, each over what is usual
    around, are largest near a frequency, if that is within `kept` of it and stands out; 0 where
    not, or where samples of such a rate (Hz) show it too slow to be told from a curve."""
    size = next_fast_len(int(4 * longest / BIN) + 1)
    off = np.fft.fftfreq(size, BIN)
    around, near = np.abs(off) <= AROUND, np.abs(off) <= kept
    frequency = middle + off
    # as samples of that rate show it: 50 Hz at 40 Hz is 10 Hz
    seen = np.abs(frequency - rate * np.round(frequency / rate))
    usable = around & (seen > max(CURVE / longest, LOWEST_HZ))
    if not usable[near].all():
        return 0.0
    power = np.zeros(size)
    for t, y, _ in signals:
        # Turned back by the mains' frequency, what is left turns by `off` alone: coarse bins of 20
        # ms hold it.
        wave, index = y * np.exp(-2j * np.pi * middle * t), ((t - t[0]) / BIN).astype(int)
        sums = np.bincount(index, wave.real, size) + 1j * np.bincount(index, wave.imag, size)
        one = np.abs(np.fft.fft(sums[:size])) ** 2
        power += one / max(float(np.median(one[usable])), 1e-30)
    best = int(np.argmax(power * near))  # two frequencies around may share an alias
    least = max(LINE * float(np.median(power[usable])), (1 - ALIKE) * float(power[usable].max()))
    return float(frequency[best]) if power[best] >= least else 0.0


def _windowed(rows: Rows, own: np.ndarray) -> np.ndarray:
    """(n,) the readings of a run, about their mean and with soft ends (Hann)."""
    y = rows.residual[own]
    return np.asarray((y - y.mean()) * np.hanning(len(y)))
