"""From deviations to readings: what each instrument projects out, its set-up, its noise, and how a
test goes wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from proof.generator.machines import XYZ, Machine
from proof.generator.physics import Shift
from proof.generator.tracks import Track

QUANTUM = 0.1  # um


@dataclass
class Faults:
    """How a null is made hard."""

    outliers: float = 0.0  # share of readings
    warming: float = 0.0  # um by which the bar grows while a file lasts
    ringing: float = 0.0  # um that the slide still swings at a capture


def project(machine: Machine, track: Track, shift: Shift | None) -> np.ndarray:
    """(rows, columns) um (urad for angles) that a shift means for the readings of a track, to first
    order."""
    n = len(track.time)
    if track.kind == "features":
        found = np.zeros((len(track.features), 1))
        if shift is not None and shift.tool is not None:
            for k, f in enumerate(track.features):
                found[k, 0] = f["weights"] @ shift.tool[f["rows"], XYZ.index(f["axis"])]
        if shift is not None and shift.reading is not None:
            found[:, 0] += shift.reading
        return found
    columns = len(machine.axes) if track.kind == "trace" else 1
    if shift is None:
        return np.zeros((n, columns))
    if track.kind == "trace":
        seen = shift.scale if track.head["sees"] == "scale" else shift.tool
        return (
            np.zeros((n, columns))
            if seen is None
            else seen[:, [XYZ.index(x) for x in machine.axes]]
        )
    found = np.zeros((n, 1))
    if track.quantity == "angle":
        if shift.turn is not None:
            found[:, 0] = shift.turn @ track.sensitive
    elif shift.tool is not None:
        normal = normals(track) if track.kind == "ballbar" else track.sensitive[None]
        found[:, 0] = (shift.tool * normal).sum(axis=1)
    if shift.reading is not None:
        found[:, 0] += shift.reading
    return found


def normals(track: Track) -> np.ndarray:
    """(N, 3) unit vectors from the centre of a circle to the tool."""
    centre = np.zeros(3)
    arm = track.position.copy()
    for x, value in track.head["centre"].items():
        centre[XYZ.index(x)] = value
    for i, x in enumerate(XYZ):
        arm[:, i] = arm[:, i] - centre[i] if x in track.head["centre"] else 0.0
    return arm / np.linalg.norm(arm, axis=1)[:, None]


def measured(
    machine: Machine, track: Track, shift: Shift, rng: np.random.Generator, faults: Faults
) -> np.ndarray:
    """(rows, columns) um as the file will hold them. Deviations of the machine included where the
    instrument sees them."""
    whole = Shift(tool=machine.deviation(track.position, track.direction))
    if track.quantity == "angle":
        whole.turn = machine.rotation(track.position, track.direction)
    for name in ("tool", "scale", "reading", "turn"):
        added, there = getattr(shift, name), getattr(whole, name)
        if added is not None:
            setattr(whole, name, added if there is None else there + added)
    tool = np.zeros(track.position.shape) if whole.tool is None else whole.tool
    noise = track.noise
    rows = project(machine, track, whole)
    n = len(rows)
    if track.kind == "targets":
        student = rng.standard_t(noise["freedom"], n) * np.sqrt(
            (noise["freedom"] - 2) / noise["freedom"]
        )
        rows[:, 0] += (
            noise["zero"] + noise["sd"] * student + noise["walk"] * np.cumsum(rng.normal(0, 1, n))
        )
        # some slips are in every file
        gross = np.flatnonzero(rng.random(n) < 0.003 + faults.outliers)
        size = (12.0 if faults.outliers else 4.0) * noise["sd"]
        rows[gross, 0] += rng.choice([-1.0, 1.0], len(gross)) * size * rng.uniform(1, 3, len(gross))
        rows[:, 0] += (
            faults.ringing * rng.exponential(0.5, n) * np.cos(rng.uniform(0, 2 * np.pi, n))
        )
    elif track.kind == "ballbar":
        rows[:, 0] = (
            _radial(track, tool, noise) + noise["length"] + _ar(rng, n, noise["sd"], noise["rho"])
        )
        rows[:, 0] += rng.normal(0, noise["white"], n)
        spread = (track.time - track.time[0]) / np.ptp(track.time)
        rows[:, 0] += faults.warming * (1 - np.exp(-2 * spread)) / (1 - np.exp(-2))
        lost = np.flatnonzero(rng.random(n) < 0.2 * faults.outliers)
        rows[lost, 0] += rng.normal(0, 12, len(lost))
    elif track.kind == "trace":
        # um of a zero that an outside instrument has
        outside = 3.0 if track.head["sees"] == "tool" else 0.0
        for k in range(rows.shape[1]):
            rows[:, k] += _ar(rng, n, noise["sd"], noise["rho"]) + rng.normal(0, outside)
    else:
        rows[:, 0] += rng.normal(0, 0.5, n)
        return rows
    return QUANTUM * np.round(rows / QUANTUM)


def _radial(track: Track, tool: np.ndarray, noise: dict) -> np.ndarray:
    """The length of the bar, exactly: its ball stands a little beside the centre that the program
    believes."""
    letters = list(track.head["centre"])
    beside = np.array([noise["u"], noise["v"]]) * 1e-3
    arm = [
        track.position[:, XYZ.index(x)]
        + tool[:, XYZ.index(x)] * 1e-3
        - track.head["centre"][x]
        - beside[k]
        for k, x in enumerate(letters)
    ]
    return (np.hypot(*arm) - track.head["radius_mm"]) * 1e3


def _ar(rng: np.random.Generator, n: int, sd: float, rho: float) -> np.ndarray:
    return lfilter([np.sqrt(1 - rho**2) * sd], [1.0, -rho], rng.standard_normal(n))
