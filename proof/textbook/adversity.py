"""What goes wrong although the machine is as its tables say: readings that jump, instruments that
warm up or lose their zero, clocks that drift, thermometers that hang elsewhere, heavy tails."""

from __future__ import annotations

import numpy as np

from .base import Array, Fields, Rng
from .case import Case
from .noise import Noise, draw_noise, wander
from .recordings import Recording

HARMS = ("outliers", "warm", "zero", "clock", "thermo", "heavy")
# what was done, in words -> names that are no mistake then
NAMES = {
    "outliers": {"outlier"},
    "warming instrument": {"sensor_drift"},
    "steps of the instrument's zero": {"sensor_drift", "step_loss"},
    "clock drifts": {"clock_skew"},
    "wrong thermometers": set(),
}


def harm(c: Case, r: Rng) -> tuple[list[Fields], set[str]]:
    """What is added to every recording, um; what was done, in words (the keys of NAMES)."""
    chosen = _choice(r)
    extra: list[Fields] = []
    words: set[str] = set()
    for rec, noise in zip(c.recs, c.noises, strict=True):
        if "heavy" in chosen:
            noise.update(draw_noise(r, rec, True))
            noise["tails"] = 2.5
            noise["kinds"] = [*noise["kinds"], "heavy tails nu=2.5"]
        extra.append({ch: _readings(r, rec, noise, chosen, words) for ch in rec.channels})
        if "clock" in chosen and rec.kind != "features":
            _clock(r, rec)
            words.add("clock drifts")
        if "thermo" in chosen and rec.kind == "targets":
            _thermometers(r, c, rec)
            words.add("wrong thermometers")
    return extra, words


def _choice(r: Rng) -> set[str]:
    """Some harms, one at least."""
    chosen: set[str] = set()
    while not chosen:
        chosen = {k for k in HARMS if r.random() < 0.4}
    return chosen


def _readings(r: Rng, rec: Recording, noise: Noise, chosen: set[str], words: set[str]) -> Array:
    """um, of one channel."""
    y, white = np.zeros(rec.n), noise["white"]
    if "outliers" in chosen:
        n = max(1, int(rec.n * r.uniform(0.005, 0.03)))
        rows = r.choice(rec.n, min(n, rec.n - 1), replace=False)
        y[rows] += r.choice([-1, 1], len(rows)) * white * r.uniform(6, 30, len(rows))
        words.add("outliers")
    if rec.kind not in ("targets", "ballbar"):
        return y
    if "warm" in chosen:
        end, size = max(rec.t[-1], 1), r.normal() * white * 5
        y = y + size * (1 - np.exp(-rec.t / (r.uniform(0.2, 0.8) * end)))
        words.add("warming instrument")
    if "zero" in chosen:
        for _ in range(int(r.integers(1, 4))):
            y = y + r.normal() * white * 4 * (rec.t > rec.t[int(r.integers(1, rec.n))])
        words.add("steps of the instrument's zero")
    return y


def _clock(r: Rng, rec: Recording) -> None:
    e = r.normal() * 4e-4
    late = abs(r.normal()) * 1e-3 * np.sqrt(rec.t / max(rec.t[-1], 1))
    rec.t_written = rec.t * (1 + e) + late
    if rec.kind == "targets":
        rec.t_written = rec.t * (1 + e * 20)


def _thermometers(r: Rng, c: Case, rec: Recording) -> None:
    for name in ("T_air_C", f"T_screw_{c.axis}_C", "T_bed_C"):
        if name in rec.more or r.random() < 0.4:
            end = max(rec.t[-1], 1)
            slow = 20 + r.normal() * 2 + r.normal() * 2.5 * rec.t / end
            rec.more[name] = slow + 0.4 * wander(r, rec.t, 1, rec.t[-1] / 4 + 1)
