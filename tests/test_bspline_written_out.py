"""BSPLINE of Sinumerik that is refused as it is and whose knots are known: written out, the machine
goes along the curve that was programmed, within the tolerance."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc.cli import main
from postproc.commands import expansion
from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.motions import FEED
from postproc.nc import dialects
from postproc.units import TICKS_PER_MM, UM
from postproc.verify import Verifier
from tests.expand.test_known_knots import curve
from tests.small_machines import write_mill
from tests.test_bspline import away

LIMITS = SimpleNamespace(max_steps=20_000, max_depth=20)
HEAD = "G17 G90 G0 X20 Y5 Z3\nG1 X21 Y6 Z3 F500\n"
TAIL = "\nG0 X60\nM30\n"


@pytest.fixture(scope="module", params=[False, True], ids=["one way", "two ways"])
def mill(request, tmp_path_factory) -> Machine:
    return read_machine(write_mill(tmp_path_factory.mktemp("mills") / "mill", request.param))


def through(machine: Machine, text: str, tolerance: float, expand: bool):
    """(3, N) mm where the machine stands behind each corrected feed, and the verifier. Raises
    ProgramError."""
    filter_ = Filter(
        machine, dialects.load("siemens"), setup_of(machine, {"G54": dict.fromkeys("XYZ", 0.0)}),
        Options(tolerance * UM), "part.mpf",
    )  # fmt: skip
    seen = []
    filter_.watchers.append(lambda words, motions, pieces, *_: seen.append(pieces))
    verifier = Verifier(filter_)
    if expand:
        written = expansion.of_text(filter_, text.encode(), lambda name: None, LIMITS)
        assert len(list(expansion.through(filter_, written, lambda size: None)))
    else:
        filter_.feed(text.encode())
        filter_.finish()
    places = []
    for pieces in seen:
        feeds = pieces.code == FEED
        ways = np.sign(pieces.end - pieces.start)[:, feeds]
        places.append((pieces.end[:, feeds] / TICKS_PER_MM, ways))
    ends, ways = (np.concatenate(x, axis=1) for x in zip(*places, strict=True))
    for k in range(1, ways.shape[1]):
        ways[:, k] = np.where(ways[:, k] == 0, ways[:, k - 1], ways[:, k])
    return ends + machine.deviation(ends, ways), verifier


def polygon(rng: np.random.Generator, count: int) -> np.ndarray:
    """(3, count + 1) mm, that turns back and forth, from where HEAD ends."""
    steps = rng.uniform(2.0, 9.0, (3, count)) * [[1.0], [1.0], [0.4]]
    steps[1:] *= rng.choice([-1.0, 1.0], (2, count))
    places = np.cumsum(np.hstack([[[21.0], [6.0], [3.0]], steps]), axis=1).round(3)
    return np.clip(places, [[5], [-55], [-35]], [[195], [55], [35]])


@pytest.mark.parametrize("seed", range(10))
def test_the_machine_goes_along_the_curve(mill, seed):
    rng = np.random.default_rng(seed)
    degree, count = int(rng.integers(2, 4)), int(rng.integers(3, 9))
    points = polygon(rng, count)
    steps = rng.uniform(0.5, 3.0, count + 1 - degree).round(3)
    first = int(rng.integers(0, degree))
    lengths = np.concatenate([np.zeros(first), steps, np.zeros(degree - 1 - first)])
    blocks = "\n".join(
        f"X{x:.3f} Y{y:.3f} Z{z:.3f} PL={length:g}"
        for (x, y, z), length in zip(points[:, 1:].T, lengths, strict=True)
    )
    text = f"{HEAD}BSPLINE SD={degree} {blocks}{TAIL}"
    there, verifier = through(mill, text, 1.0, expand=True)
    assert verifier.passed, verifier.report()
    wanted = curve(points.T, np.ones(count + 1), steps, degree).T
    # the lines leave the curve by the tolerance, and the machine the lines by what is verified
    fine = float(verifier.allowed) + 1.0 * UM + 1e-5
    on_curve = there[:, np.argmax(there[0] > 21.2) :]
    assert away(on_curve[:, ::5], wanted) <= fine
    assert away(on_curve[:, -1:], points[:, -1:] + [[0.0, 0.0]]) <= fine


def test_what_is_refused_as_it_is_is_written_out_alone(mill):
    """Where it can be corrected in place it is not written out by itself."""
    rng, refused = np.random.default_rng(3), 0
    for _ in range(6):
        blocks = "\n".join(
            f"X{x:.3f} Y{y:.3f} Z{z:.3f} PL=2" for x, y, z in polygon(rng, 6)[:, 1:].T
        )
        text = f"{HEAD}BSPLINE {blocks}{TAIL}"
        try:
            through(mill, text, 1.0, expand=False)
        except ProgramError as error:
            refused += 1
            assert expansion.is_way_out(error)
            assert through(mill, text, 1.0, expand=True)[1].passed
    assert refused >= 5


TURNS = "BSPLINE X20 Y25 PL=1\nX35 Y30 PL=1\nX50 Y10 PL=1\nX60 Y30 PL=1\nG1 X90\nM30\n"
START = "G90 G17 G54 G0 X5 Y5 Z-50\nG1 X10 Y10 Z-45 F500\n"
EXAMPLE = ("--machine", "example-mill", "--offset", "G54=X0,Y0,Z0", "--dialect", "siemens")


def run(capfd, folder, text: str, *options: str) -> tuple[int, str, str]:
    (folder / "part.mpf").write_text(text)
    status = main([*EXAMPLE, *options, "--verify", str(folder / "part.mpf")])
    return (status, *capfd.readouterr())


def test_one_run_writes_it_out_and_says_so(tmp_path, capfd):
    status, out, err = run(capfd, tmp_path, START + TURNS)
    assert status == 0 and "BSPLINE" not in out and out.count("\n") > 100
    assert "written out as plain blocks" in err and "line 3: a B-spline whose curve" in err
    status, out, err = run(capfd, tmp_path, START + TURNS, "--no-expand")
    assert (status, out) == (2, "") and "--expand writes it out as straight lines" in err


def test_one_that_leaves_a_doubt_is_refused_with_the_reason(tmp_path, capfd):
    for options in ((), ("--expand",)):
        text = START + TURNS.replace("PL=1", "PL=2", 1)
        status, out, err = run(capfd, tmp_path, text, *options)
        assert (status, out) == (2, "")
        assert "not written out, because its PL leave open where its knots are" in err
        assert "BSPLINE X20 Y25 PL=2" in err and "PL alike in each of its blocks" in err


def test_one_that_is_corrected_in_place_stays(tmp_path, capfd):
    text = START + "BSPLINE X11 Y11 PL=1\nX12 Y13 PL=1\nX13 Y14 PL=1\nG1 X90\nM30\n"
    status, out, err = run(capfd, tmp_path, text)
    assert status == 0 and "BSPLINE X11" in out and "written out" not in err
