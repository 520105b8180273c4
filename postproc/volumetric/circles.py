"""Circles of a ballbar (ISO 230-4) as lengths from their centre: straightness, positioning, lost
motion and squareness together, as far as the circles at hand part them.

The two balls' distance is the commanded radius and what was read; where the ball on the table
stands, and the bar's own length, belong to the set-up and are found. One circle alone can not part
bows of one axis from bows of the other; circles at several places, or a laser beside them, do. A
motion has what a machine at rest has not: axes that follow unlike turn the ellipse with the sense,
so both senses are asked for, and spikes where an axis turns stay in what is left.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from postproc.errors import Place
from postproc.iso.circles import ways as ways_of
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.recordings import Recording
from postproc.volumetric import VolumetricError
from postproc.volumetric.rows import Rows, nominal_tip

SECTORS = (
    180  # of a turn, each one reading (waves of 2 to a turn lose 0.02 %); axes turn between two
)
BESIDE = 0.1  # mm from the commanded circle: further out it is the run-in
# parts of a turn within which what the model leaves is taken as alike (as calibrate/circles.py
# does): between nodes, and while axes follow their commands, a circle is off in waves
PARTS = 16
HELD = 1.0  # mm, standard deviation of the centre's place: a ball on a table is set by the slides


def _parts(
    run: np.ndarray, sense: np.ndarray, sector: np.ndarray, on: np.ndarray
) -> list[np.ndarray]:
    """(N,) bool for each sector of each run, in one sense, that has samples on the circle."""
    places = itertools.product(np.unique(run), (-1.0, 1.0), range(SECTORS))
    parts = (on & (run == number) & (sense == s) & (sector == k) for number, s, k in places)
    return [part for part in parts if part.any()]


def _two_slides(recording: Recording, machine: Machine) -> list[str]:
    """The axes of the circle. Raises VolumetricError where they are not two slides."""
    axes = [x for x in XYZ if x in recording.head.get("centre", {})]
    if len(axes) != 2 or not set(axes) <= set(machine.letters):
        raise VolumetricError(
            "the centre names no two slides of this machine",
            "centre = { X = .., Y = .. }",
            Place(recording.file, 1),
        )
    return axes


def rows_of(recording: Recording, machine: Machine, base: Rows) -> list[Rows]:
    """All runs of a file, one set-up: its readings averaged in sectors, each run by itself.

    base: slide positions of all samples. Raises VolumetricError for one sense alone, and for a
    circle that is none.
    """
    axes = _two_slides(recording, machine)
    where, centre = list(map(machine.letters.index, axes)), recording.head["centre"]
    radius, columns = float(recording.head["radius_mm"]), recording.columns
    arm = base.q[where] - np.array([[float(centre[x])] for x in axes])
    on = np.abs(np.hypot(*arm) - radius) <= BESIDE
    run, sense = columns.get("run", np.ones(len(on))), np.zeros(len(on))
    angle = np.arctan2(arm[1], arm[0])
    sense[on] = ways_of(angle[on], columns["t_s"][on], run[on], columns["sense"][on])
    if len(np.unique(sense[on])) < 2:
        raise VolumetricError(
            "the circles turn one way only: squareness and axes that follow unlike look the same",
            "record both senses",
            Place(recording.file, 1),
        )
    turn = np.mod(angle, 2 * np.pi)
    sector = np.minimum((turn / (2 * np.pi) * SECTORS).astype(int), SECTORS - 1)
    groups = _parts(run, sense, sector, on)
    q = np.stack([base.q[:, g].mean(axis=1) for g in groups], axis=1)
    # the mean of a sector lies inside of its arc
    middle = np.array([turn[g].mean() for g in groups])
    for i, x, way in zip(where, axes, (np.cos(middle), np.sin(middle)), strict=True):
        q[i] = float(centre[x]) + radius * way
    approach = np.zeros_like(q)
    ways = np.array([sense[g][0] for g in groups])
    # As in iso/causes.py: run from the first axis to the second, the first falls while the second
    # is above zero.
    approach[where[0]] = -ways * np.sign(np.sin(middle))
    approach[where[1]] = ways * np.sign(np.cos(middle))
    # sector by sector: thousands of samples would hide that they tell no more than their waves
    value = np.array([recording.reading[g].mean() for g in groups])
    # the centre's place: where the other axes stood, and both slides at the stated centre
    place = base.q[:, on].mean(axis=1)
    place[where] = [float(centre[x]) for x in axes]
    stands = nominal_tip(machine, place[:, None], base.tool)[:, 0]
    return [
        replace(
            base,
            kind="length",
            q=q,
            approach=approach,
            value=radius + value,
            start=np.append(stands, 0.0),
            loose=np.array([1 / HELD] * 3 + [0.0]),
            alike=max(len(value) / (2 * PARTS), 1.0),  # of both senses; more runs tell no more
        )
    ]
