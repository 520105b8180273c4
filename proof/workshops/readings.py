"""Instruments of workshops, their noise and their digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rng, pick
from .recordings import Recording

if TYPE_CHECKING:
    from .case import Case

LASER = "laser interferometer"
COMPARATOR = "linear comparator (glass scale)"
STEP_GAUGE = "touch probe on step gauge"
BLOCKS = "gauge blocks and electronic probe"
PROBE = "electronic probe"
CAPACITIVE = "capacitive probe"
STRAIGHTEDGE = "lever gauge on straightedge"
DIAL = "dial indicator 1 um"
DIAL_10 = "dial gauge 10 um"
STOP_10 = "caliper stop and dial 10 um"
INSTRUMENTS = {  # step, and least and most noise, um
    LASER: (0.01, (0.1, 0.35)),
    COMPARATOR: (0.1, (0.15, 0.5)),
    DIAL: (1.0, (0.4, 0.9)),
    STEP_GAUGE: (0.1, (0.4, 1.0)),
    BLOCKS: (0.1, (0.2, 0.6)),
    STRAIGHTEDGE: (0.2, (0.25, 0.7)),
    PROBE: (0.1, (0.1, 0.4)),
    DIAL_10: (10.0, (3.0, 5.0)),
    STOP_10: (10.0, (3.0, 6.0)),
    CAPACITIVE: (0.02, (0.05, 0.25)),
}


def choose(c: Case, names: list[str]) -> str:
    """One of the instruments; in a coarse shop a dial gauge."""
    if not c.machine.coarse:
        return pick(c.r, names)
    return pick(c.r, [DIAL_10, STOP_10]) if c.r.random() < 0.6 else DIAL


def add(c: Case, rec: Recording, noise: float, memory: float = 0.0, walk: float = 0.0) -> None:
    """A recording of the case, with the noise of its instrument: noise, um, half of it (where
    memory is not 0) with a correlation from reading to reading; walk: um, a slow wander."""
    r = c.r
    zeros = {
        channel: float(r.normal() * (40 if c.machine.coarse else 5)) for channel in rec.channels
    }
    if r.random() < 0.4 or rec.kind in ("trace", "features"):
        zeros = dict.fromkeys(zeros, 0.0)
    rec.zero, rec.white, rec.memory, rec.walk = zeros, noise, memory, walk
    rec.tails = bool(r.random() < 0.2) and rec.kind in ("targets", "features")
    total = float(np.sqrt(noise**2 + rec.step**2 / 12 + walk**2))
    # of half white noise and half with memory, the long-run variance; and the correlation of noise
    # that has memory alone and the same one
    long_run = 0.5 + 0.5 * (1 + memory) / (1 - memory)
    rec.noise = dict.fromkeys(rec.channels, total)
    rec.rho = dict.fromkeys(rec.channels, (long_run - 1) / (long_run + 1))
    notes = ["student-t noise, 8 degrees of freedom"] if rec.tails else []
    notes += [f"correlated noise rho={memory:.2f}"] if memory else []
    notes += [f"slow wander {walk:.2f} um"] if walk else []
    said = {"sigma_um": round(noise, 3), "resolution_um": rec.step, "notes": notes}
    c.noise.append({"file": rec.name, **said})
    c.recs.append(rec)


def noisy(r: Rng, rec: Recording, channel: str) -> Array:
    """Noise and zero of a channel, um."""
    n = rec.n
    y = r.standard_t(8, n) / np.sqrt(8 / 6) if rec.tails else r.normal(size=n)
    if rec.memory:
        y = np.sqrt(0.5) * y + np.sqrt(0.5) * _with_memory(r, n, rec.memory)
    y = rec.white * y
    if rec.walk and n > 2:
        steps = np.sqrt(np.maximum(np.diff(rec.t, prepend=rec.t[0]), 0))
        walked = np.cumsum(r.normal(size=n) * steps)
        y = y + rec.walk * walked / (np.std(walked) + 1e-9)
    if rec.kind == "ballbar":  # its centre and its length
        for u in rec.unit.values():
            y = y + r.normal() * 8 * u
        y = y + r.normal() * 5
    return y + rec.zero[channel]


def _with_memory(r: Rng, n: int, rho: float) -> Array:
    y = lfilter([1], [1, -rho], r.normal(size=n) * np.sqrt(1 - rho * rho))
    r.normal()  # a start was once drawn here: what is drawn later keeps its place
    return y


def rounded(rec: Recording, channel: str, y: Array) -> Array:
    """As the instrument shows it. A trace's steps are those of the actual place, not of the
    deviation."""
    if rec.kind != "trace":
        return np.round(y / rec.step) * rec.step
    return to_scale(rec.pos[channel[0]], y, rec.step_of_scale)


def to_scale(pos: Array, y: Array, step: float) -> Array:
    """A deviation, um, whose actual place is one of whole steps, um; pos: mm."""
    step = step * 1e-3
    return (np.round((pos + y * 1e-3) / step) * step - pos) * 1e3
