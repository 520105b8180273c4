"""What a hidden effect is worth in these very recordings: its largest reading, and how far it
stands out of the noise.

The energy of a truth is its signal over the noise, with everything taken out that an honest tool
must leave open: the set-up of each file, the map's own uncertainty, and the other truths of the
case.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from proof.generator.machines import ABC, XYZ, Machine
from proof.generator.physics import Shift
from proof.generator.readings import normals, project
from proof.generator.tracks import Track

VISIBLE = 40.0  # energy from which on a tool must name it
OPEN = 1e6  # um2, of an unknown set-up
Rows = list[np.ndarray]  # one array (rows, columns) a track


def set_up(track: Track) -> list[np.ndarray]:
    """Columns (rows,) that a file's set-up leaves open, of one column of readings."""
    if track.kind == "features":
        return []
    n = len(track.time)
    if track.kind == "ballbar":
        normal = normals(track)
        return [np.ones(n), *(normal[:, XYZ.index(x)] for x in track.head["centre"])]
    return [np.ones(n)]


def peak(tracks: list[Track], rows: Rows) -> float:
    """um: the largest reading that an effect makes in any file beyond the file's set-up."""
    largest = 0.0
    for track, found in zip(tracks, rows, strict=True):
        open_ = set_up(track)
        for k in range(found.shape[1]):
            left = found[:, k]
            if open_ and np.any(left):
                basis = np.array(open_).T
                left = left - basis @ np.linalg.solve(basis.T @ basis, basis.T @ left)
            largest = max(largest, float(np.abs(left).max(initial=0.0)))
    return largest


@dataclass
class _Column:
    """One column of readings of a file: where its blocks begin, the weight of a reading, what the
    map and the set-up leave open of it (curves, blocks) and the inverse of the set-up's normal
    matrix."""

    track: int
    index: int
    pick: np.ndarray
    block: int
    precision: float
    maps: np.ndarray
    own: np.ndarray
    inner: np.ndarray


class Oracle:
    """What these files can tell; one for a machine and its tracks, asked for many signals."""

    def __init__(self, machine: Machine, tracks: list[Track]):
        self.tracks = tracks
        self.columns: list[_Column] = []
        shared = np.diag(1 / _priors(machine) ** 2)
        for t, track in enumerate(tracks):
            block = 1 if track.kind in ("targets", "features") else 8
            rows, wide = project(machine, track, None).shape
            pick = np.arange(0, rows, block)
            maps_of = _map_columns(machine, track, pick)
            for k in range(wide):
                precision = 1 / _variance(track)
                maps = maps_of[:, :, k]
                open_, walk = set_up(track), _walk(track, pick)
                own = np.array([c[pick] for c in open_] + walk).reshape(-1, len(pick))
                variance = np.r_[np.full(len(open_), OPEN), np.full(len(walk), _wander(track))]
                inner = np.linalg.inv(precision * block * own @ own.T + np.diag(1 / variance))
                cross = precision * block * maps @ own.T
                shared += precision * block * maps @ maps.T - cross @ inner @ cross.T
                self.columns.append(_Column(t, k, pick, block, precision, maps, own, inner))
        self.spread = np.linalg.inv(shared)  # what the map may be after these files, a covariance

    def energies(self, signals: list[Rows]) -> list[float]:
        """For each signal its energy given the others."""
        if not signals:
            return []
        gram = np.zeros((len(signals), len(signals)))
        tied = np.zeros((len(self.spread), len(signals)))
        for c in self.columns:
            s = np.array([rows[c.track][:, c.index] for rows in signals])
            if not s.any():
                continue
            gram += c.precision * (s @ s.T)
            mean = np.add.reduceat(s, c.pick, axis=1) / np.diff(np.r_[c.pick, s.shape[1]])
            weight = c.precision * c.block
            link = weight * (c.own @ mean.T)
            gram -= link.T @ c.inner @ link
            tied += weight * (c.maps @ mean.T) - weight * (c.maps @ (c.own.T @ (c.inner @ link)))
        gram -= tied.T @ self.spread @ tied
        return [_beside(gram, j) for j in range(len(signals))]


def _beside(gram: np.ndarray, j: int) -> float:
    """The energy of signal j that the others together do not explain."""
    rest = np.arange(len(gram)) != j
    if not rest.any():
        return max(0.0, float(gram[j, j]))
    inner = gram[np.ix_(rest, rest)]
    inner = inner + np.diag(1e-9 * np.diag(inner) + 1e-12)
    return max(0.0, float(gram[j, j] - gram[j, rest] @ np.linalg.solve(inner, gram[rest, j])))


def _priors(machine: Machine) -> np.ndarray:
    """Standard deviations of all curves of the map's error, um or urad."""
    one = machine.stated_um / np.sqrt(3)
    found = [one] * 6 * len(machine.components()) + [2 * machine.stated_um] * len(machine.square)
    return np.array(found)


def _map_columns(machine: Machine, track: Track, pick: np.ndarray) -> np.ndarray:
    """(curves, len(pick), columns) readings for one of each curve of the map's error."""
    blind = track.kind == "trace" and track.head["sees"] == "scale"
    found = []
    position = track.position if track.kind == "features" else track.position[pick]
    thin = track if track.kind == "features" else _thinned(track, pick)
    for component in machine.components():
        i = XYZ.index(component[2])
        for wave in machine.waves(component[2], position[:, i]):
            shift = Shift(tool=machine.carry(component, wave, position))
            if component[1] in ABC:
                shift.turn = np.zeros((len(wave), 3))
                shift.turn[:, ABC.index(component[1])] = wave
            found.append(project(machine, thin, None if blind else shift))
    for name in machine.square:
        found.append(
            project(machine, thin, None if blind else Shift(tool=machine.lean(name, position)))
        )
    return np.array(found)


def _thinned(track: Track, pick: np.ndarray) -> Track:
    return Track(
        track.kind,
        track.head,
        track.moving,
        track.run[pick],
        track.time[pick],
        track.position[pick],
        track.direction[pick],
        sensitive=track.sensitive,
    )


def _variance(track: Track) -> float:
    """um2 of a reading as it counts in a sum, correlation included."""
    noise = track.noise
    if track.kind == "features":
        return noise["sd"] ** 2 / 3 + 0.25
    rho = noise.get("rho", 0.0)
    return noise["sd"] ** 2 * (1 + rho) / (1 - rho) + 0.01 / 12


def _walk(track: Track, pick: np.ndarray) -> list[np.ndarray]:
    if track.kind != "targets":
        return []
    x = np.linspace(-1, 1, len(track.time))[pick]
    return [x, x**2 - 1 / 3]


def _wander(track: Track) -> float:
    return max((track.noise.get("walk", 0.0) * 0.4) ** 2 * len(track.time), 1e-6)
