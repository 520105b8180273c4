"""Jobs on a real GRBL image with motion, judged by the steps of its motors."""

from __future__ import annotations

import functools
import math
import random
import signal
import time

import numpy as np
import pytest

from postproc.streaming import journal
from tests.streaming import real_grbl
from tests.streaming.real_grbl import STEPS, RealGrbl, in_order, stream

WHY = real_grbl.missing()
pytestmark = [pytest.mark.real, pytest.mark.skipif(bool(WHY), reason=WHY)]


def wave(step: float, feed: int, n: int, radius: float = 5.0) -> tuple[str, np.ndarray]:
    """Half circles to either side in straight pieces of `step` mm; the places that the motors must
    come by (steps)."""
    rows, places = ["G21 G90 G94 G17", "G54"], []
    x = y = way = 0.0
    for i in range(n):
        way += step / radius * (1 if int(i * step / (radius * math.pi)) % 2 == 0 else -1)
        x, y = round(x + step * math.cos(way), 3), round(y + step * math.sin(way), 3)
        rows.append(f"G1 X{x} Y{y} F{feed}")
        places.append((x, y, 0.0))
    return "\n".join([*rows, "M2", ""]), np.array(places) * STEPS


# Pieces whose motions last 1.2 to 12 ms; at 0.5 mm and F5000 the machine is one behind a planner's
# 16 motions and 2 to spare.
SHORT = [(0.5, 5000), (0.3, 3000), (0.1, 1000), (1.0, 5000), (0.2, 1500)]


def in_time(make):
    """A test that is made again where the simulator was starved: gcomp and the machine then do not
    live in one time, and a dwell of 4 s, for one, lasts longer than gcomp waits for it."""

    @functools.wraps(make)
    def again(tmp_path, **arguments):
        for number in range(AGAIN):
            folder = tmp_path / str(number)
            folder.mkdir()
            RealGrbl.lost = 0.0
            try:
                make(folder, **arguments)
                return
            except AssertionError:
                if RealGrbl.lost < real_grbl.BEHIND:
                    raise
        pytest.skip(
            f"the simulator fell {RealGrbl.lost:.1f} s behind the clock, {AGAIN} times: the"
            " computer is too busy"
        )

    return again


AGAIN = 3


@pytest.mark.parametrize(("step", "feed"), SHORT)
@in_time
def test_short_motions_are_no_alarm_and_exact(tmp_path, step, feed):
    text, places = wave(step, feed, 300)
    (tmp_path / "job.nc").write_text(text)
    with RealGrbl(tmp_path) as real:
        real.talk("G21 G90", "G10 L2 P1 X0 Y0 Z0")
        status, said = stream(tmp_path, real.path, "job.nc", "--quiet")
        steps = real.steps()
    assert status == 0, said
    assert in_order(steps, places, 1.5) == len(places)


@in_time
def test_lines_without_a_block_and_motions_below_a_step_are_no_alarm(tmp_path):
    """Between motions of 6 ms: M and F words alone, and a motion of a tenth of a step, which GRBL
    answers at once."""
    text, places = wave(0.5, 5000, 250)
    r, rows = random.Random(3), []
    for row in text.split("\n"):
        rows.append(row)
        if row.startswith("G1"):
            rows += r.choice(([], ["G94"], [f"G1 Z{r.choice((0.0004, 0.0))}"], ["F5000", "G90"]))
    (tmp_path / "job.nc").write_text("\n".join(rows))
    with RealGrbl(tmp_path) as real:
        real.talk("G21 G90", "G10 L2 P1 X0 Y0 Z0")
        status, said = stream(tmp_path, real.path, "job.nc", "--quiet")
        steps = real.steps()
    assert status == 0, said
    assert in_order(steps, places, 1.5) == len(places)


# -- an interrupted job, and the way back into it --------------------------------------------------

DEPTH = -3.0  # mm, of the cut


def zigzag(n: int, words: bool = True, spindle: bool = False) -> tuple[str, np.ndarray]:
    """A contour of 3 mm to and fro at F3000, F on a line of its own before every motion; places on
    it every 0.5 mm (steps). spindle: it turns, for which a restart waits 4 s."""
    rows = ["G21 G90 G94 G17", "G54", "G0 X0 Y0 Z5", *["M3 S1000"] * spindle, f"G1 Z{DEPTH} F2000"]
    corners = [(1.5 * (i % 2) + 0.8 * i, 2.5 * (i % 2)) for i in range(n)]
    for x, y in corners:
        rows += ["F3000"] * words + [f"G1 X{x:.3f} Y{y:.3f}"]
    ends = np.array([(0.0, 0.0), *corners])
    share = np.linspace(0, 1, 7)[1:, None, None]
    way = (ends[:-1] + share * np.diff(ends, axis=0)).transpose(1, 0, 2).reshape(-1, 2)
    return "\n".join([*rows, "G0 Z5", "M5", "M2", ""]), np.c_[way, np.full(len(way), DEPTH)] * STEPS


def interrupted(real: RealGrbl, folder, answered: int, how) -> None:
    """A job that `how` (real, process) stops when so many lines were answered."""
    process = real_grbl.start(folder, real.path, "job.nc", "--quiet")
    written = folder / "job.nc.journal"
    wait(lambda: written.exists() and written.read_bytes().count(b'"answered"') >= answered)
    assert process.poll() is None, process.communicate()
    how(real, process)
    process.communicate(timeout=60)
    real.rest()


def wait(until) -> None:
    deadline = time.monotonic() + 60
    while not until():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def ctrl_c_twice(real, process) -> None:
    process.send_signal(signal.SIGINT)
    written = real.folder / "job.nc.journal"
    wait(lambda: b'"state":"hold","detail":"0"' in written.read_bytes())
    process.send_signal(signal.SIGINT)


def killed(real, process) -> None:
    process.kill()


def cable(real, process) -> None:
    real.tell("cut")
    process.wait(30)
    real.tell("plug")


def home(real: RealGrbl) -> None:
    """G54 20 mm below where the machine was switched on, and the tool 5 mm above it."""
    real.talk("G21 G90", "G10 L2 P1 X0 Y0 Z-20", "G0 Z5 X0 Y0")
    real.rest()


@pytest.mark.parametrize(("how", "answered"), [(ctrl_c_twice, 57), (killed, 73), (cable, 57)])
@in_time
def test_a_restart_leaves_nothing_uncut(tmp_path, how, answered):
    """By 16 wire lines back, 8 to 12 motions (10.7 mm) of this contour were left out. All of it
    must be cut, in order, nothing below it."""
    text, way = zigzag(45, spindle=how is killed)
    (tmp_path / "job.nc").write_text(text)
    with RealGrbl(tmp_path) as real:
        home(real)
        interrupted(real, tmp_path, answered, how)
        first = real.steps()
        status, said = stream(
            tmp_path, real.path, "job.nc", "--quiet", "--resume-from", "job.nc.journal", "--yes"
        )
        steps = real.steps()
    assert status == 0, said
    at = way + [0, 0, -20 * STEPS]
    assert in_order(steps, at, 1.5) == len(at)
    assert steps[:, 2].min() >= (DEPTH - 20) * STEPS - 0.5
    again = in_order(first, at, 1.5) - (
        len(at) - in_order(steps[len(first) :][::-1], at[::-1], 1.5)
    )
    print(
        f"\n{how.__name__} at {answered}: {len(first)} steps, then {len(steps) - len(first)};"
        f" {again / 6:.1f} motions cut twice"
    )
    assert 0 <= again / 6 < journal.MARGIN + 2


@in_time
def test_a_restart_behind_a_lost_zero_is_refused(tmp_path):
    """The power goes in the cut: GRBL believes that it stands at zero, and G53 G0 Z-15 would go 15
    mm below the cut."""
    text, _ = zigzag(45)
    (tmp_path / "job.nc").write_text(text)
    resume = ("job.nc", "--quiet", "--resume-from")
    with RealGrbl(tmp_path) as real:
        home(real)
        interrupted(real, tmp_path, 57, lambda real, process: real.tell("power"))
        before = real.steps()
        said = [
            stream(tmp_path, real.path, *resume, how, "--yes") for how in ("job.nc.journal", "60")
        ]
        assert len(real.steps()) == len(before)
    for status, words in said:
        assert status == 2 and "the zero may be lost" in words and "--zero-is-right" in words, words
    assert before[:, 2].min() >= (DEPTH - 20) * STEPS - 0.5


@in_time
def test_a_controller_that_stands_elsewhere_is_refused(tmp_path):
    text, _ = zigzag(45)
    (tmp_path / "job.nc").write_text(text)
    with RealGrbl(tmp_path) as real:
        home(real)
        interrupted(real, tmp_path, 57, ctrl_c_twice)
        real.talk("G91", "G0 Z4", "G90")
        real.rest()
        status, said = stream(
            tmp_path, real.path, "job.nc", "--quiet", "--resume-from", "job.nc.journal", "--yes"
        )
    assert status == 2 and "mm from where the journal left it" in said, said
