"""BSPLINE of Sinumerik: what the control makes of the corrected control points, whatever its knots
and weights are, stays within the tolerance of the curve that was programmed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.motions import SPLINE
from postproc.nc import dialects
from postproc.units import TICKS_PER_MM, UM
from postproc.verify import Verifier
from tests.small_machines import write_mill

HEAD = "G17 G90 G0 X20 Y5 Z3\nG1 X21 Y6 Z3 F500\n"
TAIL = "\nG1 X60\nM30\n"
SAMPLES = np.linspace(0.0, 1.0, 401)


@pytest.fixture(scope="module", params=[False, True], ids=["one way", "two ways"])
def mill(request, tmp_path_factory) -> Machine:
    return read_machine(write_mill(tmp_path_factory.mktemp("mills") / "mill", request.param))


def corrected(machine: Machine, text: str, tolerance: float = 1.0, cut: int = 0, **options):
    """Text, the motions of both programs that are control points with the place before them, and
    the verifier. cut: bytes that are handed over at once."""
    filter_ = Filter(
        machine, dialects.load("siemens"), setup_of(machine, {"G54": dict.fromkeys("XYZ", 0.0)}),
        Options(tolerance * UM, **options), "part.mpf",
    )  # fmt: skip
    seen = []
    filter_.watchers.append(lambda words, motions, pieces, *_: seen.append((motions, pieces)))
    verifier = Verifier(filter_)
    data = text.encode()
    size = cut or len(data)
    out = b"".join(filter_.feed(data[i : i + size]) for i in range(0, len(data), size))
    return (out + filter_.finish()).decode(), seen, verifier


def polygons(seen) -> tuple[np.ndarray, np.ndarray]:
    """Two (3, n) mm: the control points of the one spline, as programmed and as written."""
    ((motions, pieces),) = seen
    points = np.flatnonzero(pieces.code == SPLINE)
    assert (np.diff(points) == 1).all()
    motion = pieces.motion[points]
    wanted = np.concatenate([motions.start[:, motion[:1]], motions.target[:, motion]], axis=1)
    written = np.concatenate([pieces.start[:, points[:1]], pieces.end[:, points]], axis=1)
    return wanted / TICKS_PER_MM, written / TICKS_PER_MM


def curve(points: np.ndarray, weights: np.ndarray, knots: np.ndarray, degree: int) -> np.ndarray:
    """(3, K) of a NURBS."""
    both = np.vstack([points * weights, weights]).T
    found = BSpline(knots, both, degree)(SAMPLES * (1 - 1e-12) * knots[-1]).T
    return found[:3] / found[3]


def clamped(steps: np.ndarray, degree: int) -> np.ndarray:
    inner = np.concatenate([[0.0], np.cumsum(steps)])
    return np.concatenate([np.zeros(degree), inner, np.full(degree, inner[-1])])


def actual(machine: Machine, command: np.ndarray) -> np.ndarray:
    """(3, K) where the machine goes: each slide bears on the side in which it moved last."""
    way = np.sign(np.gradient(command, axis=1))
    for column in range(1, way.shape[1]):
        way[:, column] = np.where(way[:, column] == 0, way[:, column - 1], way[:, column])
    return command + machine.deviation(command, way)


def away(points: np.ndarray, path: np.ndarray) -> float:
    """mm, the largest distance of points (3, K) from a chain of lines (3, M)."""
    start, way = path[:, :-1], np.diff(path, axis=1)
    length = np.maximum((way**2).sum(axis=0), 1e-30)
    worst = 0.0
    for p in points.T:
        share = np.clip(((p[:, None] - start) * way).sum(axis=0) / length, 0.0, 1.0)
        off = np.linalg.norm(p[:, None] - start - way * share, axis=0).min()
        worst = max(worst, float(off))
    return worst


def blocks(rng: np.random.Generator, count: int, spaced: bool, monotone: bool) -> str:
    """Random control points, from X21 Y6 Z3 on."""
    steps = rng.uniform(0.4, 2.5, (count, 3)) * [1.0, 0.8, 0.5]
    steps *= 1.0 if monotone else rng.choice([-1.0, 1.0], (count, 3), p=[0.2, 0.8])
    places = np.array([21.0, 6.0, 3.0]) + np.cumsum(steps, axis=0)
    lines = []
    for x, y, z in places:
        lines.append(f"X{x:.3f} Y{y:.3f} Z{z:.3f}" + (" PL=1.5" if spaced else ""))
    return "BSPLINE " + "\n".join(lines)


def law(machine: Machine, seed: int, spaced: bool) -> bool:
    """One random spline; whether it was accepted."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 14))
    text = HEAD + blocks(rng, count, spaced, bool(seed % 2)) + TAIL
    tolerance = float(rng.choice([0.8, 1.5, 4.0]))
    try:
        _, seen, verifier = corrected(machine, text, tolerance)
    except ProgramError as error:
        assert "B-spline" in error.message, error
        return False
    assert verifier.passed, verifier.report()
    wanted, written = polygons(seen)
    for _ in range(4):
        degree = min(int(rng.integers(2, 4)), count)
        n = wanted.shape[1]
        weights = rng.uniform(0.0001, 3.0, n)
        if spaced:
            steps = rng.uniform(0.0, 1.0, n - degree) ** 3 + 1e-6
            one = two = clamped(steps, degree)
        else:
            power = rng.uniform(0.0, 1.0)
            one, two = (spaced_by(points, degree, power) for points in (wanted, written))
        nominal = curve(wanted, weights, one, degree)
        there = actual(machine, curve(written, weights, two, degree))
        fine = float(verifier.allowed) + 1e-5  # chords of the samples
        off = (
            np.linalg.norm(there - nominal, axis=0).max() if spaced else away(there[:, ::8], nominal)
        )
        assert off <= fine, (seed, off / UM, fine / UM)
    return True


def spaced_by(points: np.ndarray, degree: int, power: float) -> np.ndarray:
    """Knots by a power of the chord length, averaged (The NURBS Book, 9.5 to 9.8)."""
    length = np.linalg.norm(np.diff(points, axis=1), axis=0) ** power
    at = np.concatenate([[0.0], np.cumsum(length)])
    n = len(at)
    inner = [at[k + 1 : k + 1 + degree].mean() for k in range(n - degree - 1)]
    return np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, at[-1])])


@pytest.mark.parametrize("spaced", [True, False], ids=["PL", "own knots"])
def test_any_knots_and_weights_stay_within_the_tolerance(mill, spaced):
    accepted = sum(law(mill, seed, spaced) for seed in range(40))
    assert accepted >= 8, accepted
