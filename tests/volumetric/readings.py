"""Machines with drawn errors and the readings that a tracker takes of them: what the tests of maps
of the volume share."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc import cli
from postproc.machine.file import read_machine
from postproc.recordings import Recording
from postproc.volumetric import solve, written
from postproc.volumetric.observations import rows_of
from postproc.volumetric.rows import nominal_tip
from postproc.volumetric.unknowns import ANGLE, LENGTH, SQUARE, Unknowns, components

ROOT = Path(__file__).resolve().parents[2]
MILL = read_machine(ROOT / "machines" / "example-mill")
FIVE = read_machine(ROOT / "machines" / "example-five-axis")
TOOLS = (
    (0.0, 0.0, -100.0),
    (60.0, 0.0, -180.0),
    (0.0, 60.0, -140.0),
)  # not on one line: a turn about such a line moves none of them
SIZES = {LENGTH: 0.006, ANGLE: 25e-6, SQUARE: 60e-6}  # mm and rad: what is drawn
NONE = frozenset()


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def unknowns(machine=MILL, nodes=5, zero=NONE, two_way=NONE) -> Unknowns:
    bare = written.without_errors(machine)
    at = {x: np.linspace(*machine.axes[x].travel, nodes) for x in "XYZ" if x in machine.axes}
    return Unknowns(tuple(components(machine, at, zero, two_way)), bare, bare)


def drawn(u: Unknowns, rng) -> np.ndarray:
    return rng.normal(size=u.number) * np.array([SIZES[p] for p in u.prior])


def places(machine, number: int, rng) -> tuple[np.ndarray, np.ndarray]:
    q = np.array([rng.uniform(*axis.travel, number) for axis in machine.axes.values()])
    return q, rng.choice([-1.0, 1.0], q.shape)


def recording(
    u: Unknowns, truth, rng, kind: str, tool, number=100, noise=1e-3, name="a.csv", station=None
) -> Recording:
    """A tracker's cloud in a frame of its own, or lengths from a station, of a machine with these
    errors."""
    q, approach = places(u.bare, number, rng)
    arm = u.bare.tool + np.array(tool)
    tip = nominal_tip(u.bare, q, arm) + np.einsum("p,pin->in", truth, u.columns(q, approach, arm))
    columns = {f"{x}_mm": q[i] for i, x in enumerate(u.bare.letters)}
    columns |= {f"approach_{x}": approach[i] for i, x in enumerate(u.bare.letters)}
    if kind == "points":
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        seen = (
            turn @ tip + rng.uniform(-1000, 1000, 3)[:, None] + noise * rng.normal(size=tip.shape)
        )
        columns |= {f"m{x}_mm": seen[i] for i, x in enumerate("xyz")}
    else:
        away = np.linalg.norm(tip - np.array(station)[:, None], axis=0)
        columns["length_mm"] = away - 77.0 + noise * rng.normal(size=number)
    head = {"tool": dict(zip("XYZ", tool, strict=True)), "u_um": noise / 1e-3}
    return Recording(kind, head, columns, name, np.arange(number) + 2)


def held(fit, u: Unknowns, truth) -> list[bool]:
    """Whether each value lies within 2 u, of errors that are told; values that are zero by
    definition left out."""
    found: list[bool] = []
    hidden = written.open_names(fit)
    for group, where in zip(u.groups, u.slices, strict=True):
        value, s = fit.values(group)
        off = np.abs(value - group.basis @ truth[where])
        if group.name not in hidden:
            found += (off <= 2 * s)[s > 1e-12].tolist()
    return found


def lengths(z, station, number=12, **columns) -> Recording:
    """Lengths without noise, at one height or between two, from a station."""
    t = np.linspace(0, 2 * np.pi, number, endpoint=False)
    q = np.array([150 * np.cos(t), 120 * np.sin(2 * t), np.resize(z, number)])
    tip = nominal_tip(MILL, q, MILL.tool)
    data = {f"{x}_mm": row for x, row in zip("XYZ", q, strict=True)}
    data["length_mm"] = np.linalg.norm(tip - np.array(station)[:, None], axis=0) + 5.0
    data |= {c: np.full(number, v) for c, v in columns.items()}
    return Recording("lengths", {"u_um": 0.5}, data, "l.csv", np.arange(number) + 2)


def fit_of(*read: Recording):
    u = unknowns(nodes=3)
    return solve.fit([r for one in read for r in rows_of(one, u.bare, {})], u)
