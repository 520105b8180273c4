"""Time with accelerations: by hand, and by the step pulses of a real GRBL."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.pace import Pace
from postproc.streaming.protocols import Controller
from postproc.streaming.rates import Clock
from tests.streaming import real_grbl
from tests.streaming.real_grbl import RECORD, RealGrbl

WHY = real_grbl.missing()
SAYS = {
    "11": "0.010",
    "110": "6000",
    "111": "6000",
    "112": "6000",
    "120": "400.000",
    "121": "400.000",
    "122": "100.000",
}


def lines(*places: tuple[float, float, float], feed: float = 3000.0) -> list[WireLine]:
    found = [WireLine(1, 1, 0, b"G0X0", (0.0, 0.0, 0.0))]
    for n, (a, b) in enumerate(zip(((0.0, 0.0, 0.0), *places), places, strict=False), 2):
        length = math.dist(a, b)
        found.append(WireLine(n, n, 0, b"G1X1", b, length=length, seconds=length / feed * 60))
    return found


def seconds(
    *places: tuple[float, float, float], wire: float = 0.0, settings: dict[str, str] = SAYS
) -> float:
    pace = Pace(Controller(settings=settings, planner=16), (0, 1, 2), lambda line: wire)
    for line in lines(*places):
        pace.add(line)
    pace.end()
    return pace.total


CORNER = math.sqrt(
    400 * 0.01 * math.sqrt(0.5) / (1 - math.sqrt(0.5))
)  # mm/s round 90 degrees: planner.c, by hand 3.107

LOOKS = math.sqrt(2 * 400 * 1.6)  # mm/s from which it can stop within the 16 motions that it holds


@pytest.mark.parametrize(
    ("places", "expected"),
    [
        ([(100, 0, 0)], 2 + 50 / 400),  # 50 mm/s, and the two ramps cost half of their time each
        ([(1, 0, 0)], 2 * math.sqrt(1 / 400)),  # never comes to its feed
        ([(50, 0, 0), (100, 0, 0)], 2 + 50 / 400),  # straight on: nothing is lost
        ([(50, 0, 0), (0, 0, 0)], 2 + 2 * 50 / 400),  # back: it stops
        ([(50, 0, 0), (50, 50, 0)], 2 * (1 + 50 / 800) + 2 * (50 - CORNER) ** 2 / (2 * 400 * 50)),
        ([(0, 0, 50)], 1 + 50 / 100),  # Z is slower to come to speed
        (
            [(0.1 * i, 0, 0) for i in range(1, 201)],
            20 / LOOKS + LOOKS / 400,
        ),  # it can stop within the 16 motions that it holds from 36 mm/s, and goes no faster
    ],
)
def test_by_hand(places, expected):
    tolerance = 0.02 if len(places) > 100 else 1e-6
    assert seconds(*places) == pytest.approx(expected, abs=tolerance)


def test_a_curve_is_gone_round_no_faster_than_its_radius_allows():
    """A circle of 5 mm in chords of 5 degrees at 100 mm/s and 400 mm/s2: v2 = a r, less what a
    chord is shorter than its arc; the ramps up to v and down again cost v / a. The first chord
    leans by 2.5 degrees, so that a is 400 / cos(2.5 degrees)."""
    turn = math.radians(5)
    ring = [(5 * math.cos(k * turn), 5 * math.sin(k * turn), 0.0) for k in range(73)]
    chord, acceleration = 10 * math.sin(turn / 2), 400 / math.cos(turn / 2)
    pace = Pace(Controller(settings=SAYS, planner=16), (0, 1, 2), lambda line: 0.0)
    pace.add(WireLine(1, 1, 0, b"G0X5", ring[0]))
    points = tuple(ring[1:-1])
    pace.add(
        WireLine(
            2, 2, 0, b"G3I-5", ring[-1], length=72 * chord, seconds=0.72 * chord, points=points
        )
    )
    pace.end()
    rate = math.sqrt(acceleration * chord / turn)
    assert rate == pytest.approx(math.sqrt(400 * 5), rel=1e-3)
    assert pace.total == pytest.approx(72 * chord / rate + rate / acceleration, rel=1e-6)


def test_the_link_may_be_slower_than_the_feed():
    assert seconds(*[(0.1 * i, 0, 0) for i in range(1, 201)], wire=0.01) == pytest.approx(
        2.0, abs=0.1
    )


def test_what_is_over_by_lines():
    pace = Pace(Controller(settings=SAYS, planner=16), (0, 1, 2), lambda line: 0.0)
    for line in lines(*[(10 * i, 0, 0) for i in range(1, 301)]):
        pace.add(line)
    pace.end()
    for n in (0, 10, 64, 150, 300):
        assert pace.at(n) == pytest.approx(n * 0.2, abs=0.25)
    assert pace.at(10**6) == pytest.approx(pace.total)


def test_where_it_probably_is():
    """Six long motions answered, of which the planner holds three: the fourth, half of it."""
    from postproc.streaming.account import Account

    account = Account(Controller(settings=SAYS, planner=16, segments=5))
    for line in lines(*[(10 * i, 0, 0) for i in range(1, 9)]):
        account.sent(line)
    for n in range(1, 8):
        account.answered(n)
    line, share = account.likely(Status("run", place=(35.0, 0.0, 0.0), free=(12, 100)))
    assert (line, share) == (4, 0.5)


def test_where_it_probably_is_by_its_place_alone():
    """As GRBL reports where $10 is left as it comes: to and fro over one way, and past where an
    earlier line ended."""
    from postproc.streaming.account import Account

    account = Account(Controller(settings=SAYS, planner=16, segments=5))
    for line in lines((10, 0, 0), (10, 10, 0), (0, 10, 0), (0, 0, 0), (10, 0, 0), (10, 5, 0)):
        account.sent(line)
    for n in range(1, 7):
        account.answered(n)
    seen = [(2.5, 0), (9, 0), (10, 5), (10, 5), (2.5, 10), (0, 7.5), (5, 0), (10, 2.5)]
    found = [account.likely(Status("run", place=(x, y, 0.0))) for x, y in seen]
    assert found == [
        (1, 0.25),
        (1, 0.9),
        (2, 0.5),
        (2, 0.5),
        (3, 0.75),
        (4, 0.25),
        (5, 0.5),
        (6, 0.5),
    ]
    assert account.executed == 0  # for nothing else: nothing is surely over
    assert account.at(Status("run", place=(10.0, 2.5, 0.0))).number == 7


@pytest.mark.real
@pytest.mark.skipif(bool(WHY), reason=WHY)
def test_a_real_grbl_takes_as_long_as_it_was_told(tmp_path):
    """By the clock of its own pulses: without accelerations 3.6 s would be said."""
    rows = [f"G1 X{1.5 * (i % 2) + 0.8 * i:.3f} Y{2.5 * (i % 2):.3f} F3000" for i in range(60)]
    (tmp_path / "job.nc").write_text(
        "\n".join(["G21 G90 G94 G17", "G54", *rows, "G2 X54.7 Y2.5 I3", "M2", ""])
    )
    with RealGrbl(tmp_path) as real:
        real.talk("G21 G90", "G10 L2 P1 X0 Y0 Z0")
        status, said = real_grbl.stream(
            tmp_path, real.path, "job.nc", "--quiet", "--report", "run.json"
        )
        assert status == 0, said
        real.steps()
        rows = np.frombuffer(
            (tmp_path / "t.bin").read_bytes()[: len(real.steps()) * RECORD.itemsize], RECORD
        )
    took = (int(rows["cycle"][-1]) - int(rows["cycle"][0])) / 16e6
    report = json.loads((tmp_path / "run.json").read_text())
    assert report["outcome"] == "done" and report["sent"] == report["lines"] == report["executed"]
    print(f"\nsaid {report['expected_s']} s, took {took:.2f} s")
    assert report["expected_s"] == pytest.approx(took, rel=0.05)


@pytest.mark.parametrize(
    ("done", "spent", "left"),
    [
        (5.0, 50.0, 95.0),  # five seconds of the program, and five of the clock, say no pace yet
        (20.0, 5.0, 80.0),
        (5.5, 11.0, 2 * 94.5),  # then twice as slow so far is twice as slow to the end
        (11.0, 5.5, 89.0 / 2),
        (20.0, 200.0, 4 * 80.0),  # never more than four times, nor less than half
        (60.0, 6.0, 40.0 / 2),
    ],
)
def test_what_is_left_by_the_pace_of_the_job_so_far(done, spent, left):
    """Of 100 s; 7 s in a hold say nothing of the pace."""
    clock = Clock(expected=100.0, started=1000.0, done=done, held=7.0)
    assert clock.left(1000.0 + 7.0 + spent) == pytest.approx(left)
