"""Vibration: an oscillation at a fixed frequency in time.

What swings by itself does so in another phase at every passage: with `passages` 1 each has its own.
A mode that noise excites is no pure wave: with `band` 1 amplitude and phase wander within a
passage, by a Fourier series of two terms over its time T (f, f +- 1/T, f +- 2/T). A mode that the
motion itself excites rings down behind every jump of the commanded acceleration, and with a
`damping` the phase is that of its jumps, the same in every passage (Meirovitch, Fundamentals of
Vibrations, 2001: the free response to a step).
"""

import numpy as np

from postproc.effects import State, along, amplitude_and_phase, harmonic_coefficients, waves_of

PARAMETERS = {
    "frequency_hz": "Hz, its frequency",
    "amplitude_um": (
        "um, zero to peak; of what rings down, just behind a jump of the acceleration by 1 m/s2"
    ),
    "phase_deg": "degrees, of a cosine at t = 0, or at the jump; of the first passage",
    "passages": "1, every passage has a phase of its own; 0, one for all",
    "band": "1, amplitude and phase wander within a passage; 0, they do not",
    "damping": (
        "1, share of the critical damping (0.01, 0.03 or 0.1) with which it rings down after jumps"
        " of the acceleration; 0, it goes on"
    ),
}
OPTIONAL = {"passages": 0.0, "phase_deg": 0.0, "band": 0.0, "damping": 0.0}
# What swings by more than 1 mm is no machine that cuts (unverified).
PLAUSIBLE = {"amplitude_um": (0.0, 1000.0)}
CONTINUOUS = {"frequency_hz": (0.0, 1e5)}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("time", "velocity"), ("tool", "scale")
TEXT = (
    "The tool vibrates at a fixed frequency. Find what turns at that frequency (spindle, fan, pump)"
    " or which mode it is; a program can not correct it."
)
SIDES = (-2, -1, 0, 1, 2)  # over the time of a passage
MOST = 12  # passages that may wander: each costs ten columns
USUAL = 1000.0  # mm/s2
# s: within so much on either side an acceleration that was told from places has changed
HALF = 0.02
JUMP, LEAST = 0.3, 10.0  # of the largest acceleration; mm/s2: what is a jump


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # found from the spectrum of what is left, see diagnose


def columns(
    state: State,
    axis: str,
    frequency_hz: float,
    passages: float = 0.0,
    band: float = 0.0,
    damping: float = 0.0,
) -> np.ndarray:
    if damping > 0:
        rung = _rung(state, axis, 2 * np.pi * frequency_hz, damping)
        return along(axis, rung.real, rung.imag)
    steady = waves_of(state, "time", frequency_hz)
    if not passages:
        return along(axis, *steady)
    moves = state.since[axis] < 1e9 if axis in state.since else np.ones(len(state), bool)
    number = np.where(moves, state.passage, -1)
    parts = [number == p for p in np.unique(number[number >= 0])]
    if not band or len(parts) > MOST:
        return along(axis, *(wave * part for part in parts for wave in steady))
    waves = []
    for part in parts:
        lasts = max(float(np.ptp(state.time[part])), 1e-9)
        for side in SIDES:
            waves += [wave * part for wave in waves_of(state, "time", frequency_hz + side / lasts)]
    return along(axis, *waves)


def jumps(time: np.ndarray, acceleration: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) s and (K,) mm/s2: when the acceleration (N,) of a passage jumps at times (N,) in order,
    and by how much."""
    if len(time) < 3:
        return np.zeros(0), np.zeros(0)
    half = max(HALF, 1.01 * float(np.median(np.diff(time))))
    change = np.interp(time + half, time, acceleration) - np.interp(time - half, time, acceleration)
    least = max(JUMP * float(np.abs(acceleration).max()), LEAST)
    # An acceleration told from places rises over some samples: neighbours that rise together, by
    # the same sign, are one jump, at their mean weighted by what each contributes.
    kind = np.sign(change) * (np.abs(change) > least)
    edges = np.flatnonzero(np.diff(kind)) + 1
    groups = [g for g in np.split(np.arange(len(time)), edges) if kind[g[0]]]
    when = [float(time[g] @ np.abs(change[g]) / np.abs(change[g]).sum()) for g in groups]
    size = [float(change[g][np.argmax(np.abs(change[g]))]) for g in groups]
    return np.array(when), np.array(size)


def _rung(state: State, axis: str, w: float, damping: float) -> np.ndarray:
    """(N,) complex: exp(-z w t) (cos w t + i sin w t) behind every jump, times the jump over 1
    m/s2; means over the samples of a row."""
    result = np.zeros(len(state), complex)
    acceleration = state.acceleration.get(axis)
    if acceleration is None or len(state.passage) != len(state):
        return result
    samples = state.inside.get("time")
    samples = state.time[None] if samples is None else samples
    rate = w * complex(-damping, 1.0)
    for p in np.unique(state.passage[state.passage >= 0]):
        own = np.flatnonzero(state.passage == p)
        time, first = np.unique(state.time[own], return_index=True)
        when, size = jumps(time, acceleration[own][first])
        level, levels = 0j, [0j]
        for k, (t, jump) in enumerate(zip(when.tolist(), size.tolist(), strict=True)):
            # Each jump starts a wave that decays; the complex level carries amplitude and phase of
            # all waves so far on to the next jump, since waves of one frequency add up to one.
            level = level * np.exp(rate * (t - when[k - 1]) if k else 0.0) + jump / USUAL
            levels.append(level)
        if not len(when):
            continue
        at = samples[:, own]
        last = np.searchsorted(when, np.nan_to_num(at, nan=-np.inf), side="right")
        gone = np.where(last > 0, at - when[np.maximum(last - 1, 0)], 0.0)
        with np.errstate(invalid="ignore"):
            result[own] = np.nanmean(np.array(levels)[last] * np.exp(rate * gone), axis=0)
    return result


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    pairs = np.asarray(coefficients).reshape(-1, 2)
    named = {"frequency_hz": shape["frequency_hz"]} | {
        k: shape.get(k, 0.0) for k in ("passages", "band", "damping")
    }
    first = amplitude_and_phase(pairs[0])
    size = float(np.sqrt(np.mean((pairs**2).sum(axis=1))))
    # The phase is that of the middle one, which has the frequency itself (SIDES 0).
    # the power of a passage's waves is that of all five
    if named["band"] and len(pairs) % len(SIDES) == 0:
        first, size = amplitude_and_phase(pairs[len(SIDES) // 2]), size * float(np.sqrt(len(SIDES)))
    return named | first | {"amplitude_um": size}


def coefficients(
    frequency_hz: float,
    amplitude_um: float,
    phase_deg: float = 0.0,
    passages: float = 0.0,
    band: float = 0.0,
    damping: float = 0.0,
) -> tuple[np.ndarray, dict[str, float]]:
    """One phase for all: which phases other passages have, and how they wander, nobody can
    predict; only what the motion rings."""
    shape = {"frequency_hz": frequency_hz, "passages": 0.0} | (
        {"damping": damping} if damping > 0 else {}
    )
    return harmonic_coefficients(amplitude_um, phase_deg), shape
