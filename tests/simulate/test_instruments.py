"""Noise, zeros, resolution and seeds of readings; settings that make no sense; recordings that can
be read again."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from postproc.errors import GcompError, UsageError
from postproc.recordings import ReadingOptions, Source
from postproc.recordings.contract import read as read_contract
from postproc.recordings.contract import write
from postproc.simulate import instruments
from postproc.simulate.instruments import Noise
from postproc.simulate.timeline import Conditions

from .samples import MILL, STRICT, STUDER, exact, read, real, timed

RESTS = (
    "G0 X0 Z0\n"
    + "".join(f"G1 X{5 * (i % 7)} Z{i % 30} F2000\nG4 P2\n" for i in range(2000))
    + "M2\n"
)
LONG = timed("G0 X0\nG1 X100 F600\nM2\n", exact(), STRICT)


@pytest.mark.parametrize("tails", [0.0, 5.0])
def test_noise_has_the_stated_deviation(tails):
    """10,000 samples: the standard deviation of a standard deviation is about 0.7 % (Gauss), 1.7 %
    (t, 5 degrees)."""
    found = read("log", real(LONG), Noise(size=2.0, tails=tails, seed=4))
    off = (found.columns["X_act_mm"] - found.position("X")) * 1e3
    assert len(off) > 9_000 and off.std() == approx(2.0, rel=0.06) and abs(off.mean()) < 0.1
    kurtosis = ((off - off.mean()) ** 4).mean() / off.var() ** 2
    assert (kurtosis > 4) == bool(tails)
    assert found.head["noise_um"] == 2.0 and found.head["u_um"] == 2.0


def test_the_same_seed_gives_the_same_bytes_and_another_one_others():
    one, same, other = (
        write(read("log", real(LONG), Noise(size=1.0, seed=s), rate="50")) for s in (1, 1, 2)
    )
    assert one == same != other


def test_what_is_recorded_beside_it_does_not_change_the_noise():
    t = timed(RESTS, STUDER_LIKE := exact("XZ"), Conditions())
    module = instruments.load("laser")
    signal = module.measure(real(t), instruments.Settings("laser", module.SETTINGS, {"along": "X"}))
    noise = Noise(size=1.0, seed=3, sensors=0.1)
    some, all_ = (instruments.recorded(signal, noise, {}, w) for w in (("T_screw_X_C",), ()))
    assert (some.columns["reading_um"] == all_.columns["reading_um"]).all()
    assert "T_screw_X_C" not in some.columns and "T_screw_X_C" in all_.columns
    assert all_.columns["T_air_C"].std() == approx(0.1, rel=0.1)
    assert STUDER_LIKE.name == "exact"


def test_resolution_and_zero():
    t = timed(RESTS, exact("XZ"), Conditions())
    found = read("laser", real(t), Noise(size=1.0, resolution=0.5, zero=100.0), along="X")
    reading = found.columns["reading_um"]
    assert reading / 0.5 == approx(np.round(reading / 0.5)) and reading.mean() == approx(
        100.0, abs=0.2
    )
    assert found.head["zero_um"] == {"reading_um": 100.0} and found.head["resolution_um"] == 0.5
    first = read("log", real(LONG), Noise(zero="first"))
    assert first.columns["X_act_mm"][0] == first.position("X")[0]
    drawn = [
        read("log", real(LONG), Noise(zero="random", seed=s)).head["zero_um"]["X_act_mm"]
        for s in range(40)
    ]
    assert len(set(drawn)) == 40 and np.std(drawn) == approx(3.0, rel=0.4)


@pytest.mark.parametrize(
    ("instrument", "text", "given"),
    [
        ("laser", RESTS, {"along": "X1,Z1"}),
        ("straightness", RESTS.replace("X", "Y"), {"across": "X"}),
        ("angle", RESTS, {}),
        ("log", "G0 X0\nG1 X10 F600\nM2\n", {"sees": "tool"}),
        ("probe", "G0 X0\nG1 X10 F600\nM2\n", {"features": "X:20,Y:10"}),
        ("ballbar", "G17\nG0 X50 Y0\nG2 X50 Y0 I-50 J0 F2000\nM2\n", {"rate": "20"}),
    ],
)
def test_a_recording_reads_back_as_it_was(instrument, text, given):
    text = "G21 G90 G94 G54\nG0 Z-100\n" + text.replace("Z", "Z-1")
    found = read(
        instrument, real(timed(text, MILL, Conditions())), Noise(size=0.3, seed=1), **given
    )
    again = read_contract(Source("r.csv", write(found).encode()), ReadingOptions())
    assert again.kind == found.kind and list(again.columns) == list(found.columns)
    for name, column in found.columns.items():
        if again.columns[name].dtype != object:  # the number of a part is a word
            step = 1e-6 if name.endswith(("_mm", "_s", "_deg")) else 1e-4
            assert np.nan_to_num(again.columns[name]) == approx(np.nan_to_num(column), abs=step)
    assert again.head["simulated"] is True and again.machine == "example-mill"


def test_runs_are_passages_there_and_back():
    body = (
        "G0 X-1\n"
        + ("G1 X0 F6000\nG4 P2\nG1 X50\nG4 P2\nG1 X51\nG1 X50\nG4 P2\nG1 X0\nG4 P2\nG1 X-1\n" * 3)
        + "M2\n"
    )
    found = read("laser", real(timed(body, exact(), STRICT)))
    assert found.columns["run"].tolist() == [1] * 4 + [2] * 4 + [3] * 4
    assert found.columns["approach_X"].tolist() == [1, 1, -1, -1] * 3
    one_way = "G0 X-1\n" + ("G1 X0 F6000\nG4 P2\nG1 X50\nG4 P2\nG1 X-1\n" * 3) + "M2\n"
    assert read("laser", real(timed(one_way, exact(), STRICT))).columns["run"].tolist() == [
        1,
        1,
        2,
        2,
        3,
        3,
    ]


def test_overrun_can_be_left_out_and_short_rests_are_no_captures():
    body = "G0 X-1\nG1 X-2 F600\nG4 P2\nG1 X0\nG4 P2\nG4 P0.2\nG1 X50\nG4 P2\nG1 X52\nG4 P2\nM2\n"
    works = real(timed(body, exact(), STRICT))
    assert read("laser", works).position("X").tolist() == [-2, 0, 50, 52]
    assert read("laser", works, ignore="1").position("X").tolist() == [0, 50]


@pytest.mark.parametrize(
    ("instrument", "given", "message"),
    [
        ("laser", {"dwell": "99"}, "never rests for 99 s"),
        ("laser", {"dwell": "-1"}, "above zero"),
        ("laser", {"dwell": "x"}, "a number"),
        ("laser", {"speed": "1"}, "no setting 'speed'"),
        ("laser", {"along": "Q"}, "like X1,Z-2.5"),
        ("log", {"sees": "eye"}, "sees=eye"),
        ("log", {"rate": "1e9"}, "samples"),
        ("log", {"from": "9", "to": "1"}, "nothing lies between"),
        ("ballbar", {}, "no arcs"),
        ("probe", {}, "which features"),
        ("probe", {"features": "Q:3"}, "no feature"),
        ("probe", {"features": "X:9e9"}, "travels"),
        ("straightness", {"dwell": "99"}, "never rests"),
    ],
)
def test_what_an_instrument_can_not_do_is_said(instrument, given, message):
    works = real(timed("G0 X0\nG1 X100 F6000\nG4 P1\nG1 X50\nG4 P1\nM2\n", exact(), STRICT))
    with pytest.raises(GcompError, match=message):
        read(instrument, works, **given)


def test_a_circle_that_is_not_there_is_not_measured():
    t = timed("G17\nG0 X50 Y0\nG2 X50 Y0 I-50 J0 F2000\nM2\n", exact(), STRICT)
    with pytest.raises(GcompError, match="no arc has its centre"):
        read("ballbar", real(t), centre="X5,Y0")


def test_every_instrument_says_what_it_is_and_an_unknown_one_is_answered_with_the_names():
    assert instruments.names() == [
        "angle",
        "ballbar",
        "laser",
        "log",
        "mirror",
        "probe",
        "straightness",
        "tracker",
    ]
    for name in instruments.names():
        module = instruments.load(name)
        assert module.TITLE and module.SETTINGS and callable(module.measure)
    with pytest.raises(UsageError, match="instruments: angle, ballbar"):
        instruments.load("sextant")


def test_the_studer_has_no_third_axis():
    t = timed("G21 G90 G54\nG1 X0 Z0 F600\nG4 X2.\nX20.\nG4 X2.\n", STUDER, Conditions())
    found = read("laser", real(t))
    assert found.axes == ("X", "Z") and found.sensitive == {"X": 1.0, "Z": 0.0}
    assert found.position("X").tolist() == [0.0, 10.0]  # radius


CIRCLE = "G21 G90 G17 G94 G54\nG0 X50 Y0\nG2 X50 Y0 I-50 J0 F1000\nM2\n"


@pytest.mark.parametrize(
    ("instrument", "given", "said"),
    [
        ("straightness", {"across": "X0"}, "across=X0 is not a direction"),
        ("angle", {"about": "X0,Y0"}, "about=X0,Y0 is not a direction"),
        ("laser", {"along": "Z0"}, "along=Z0 is not a direction"),
        ("laser", {"along": "X" + 400 * "9"}, "is not like X1,Z-2.5"),
        ("straightness", {"across": "Y"}, "which has no axis Y"),
        ("laser", {"along": "X1,Y1"}, "which has no axis Y"),
        ("laser", {"runs": "0.5"}, "runs=0.5 is not a whole number"),
        ("probe", {"features": "X:20", "readings": "0.5"}, "readings=0.5 is not a whole number"),
        ("probe", {"features": "X:20", "readings": "9e6"}, "9,000,000 samples are more"),
        ("probe", {"features": "X:nan"}, "'X:nan' is no feature"),
        ("log", {"from": "2", "to": "1.9999"}, "nothing lies between 2 and 1.9999 s"),
    ],
)
def test_settings_that_make_no_reading_are_refused(instrument, given, said):
    """On a machine of X and Z."""
    with pytest.raises(UsageError, match=said):
        read(instrument, real(timed(RESTS[:400] + "\nM2\n", exact("XZ"), Conditions())), **given)


def test_a_direction_has_the_length_one_whatever_is_written():
    settings = instruments.Settings("laser", {"along": ""}, {"along": "X.3,Z-0.4"})
    assert settings.direction("along") == approx([0.6, 0.0, -0.8])
    tiny = instruments.Settings("laser", {"along": ""}, {"along": f"Y.{200 * '0'}1"})
    assert tiny.direction("along") == approx([0.0, 1.0, 0.0])
    assert instruments.Settings("laser", {"along": ""}, {}).direction("along") is None


@pytest.mark.parametrize("centre", ["X0", "X0,Z0"])
def test_a_centre_in_another_plane_is_refused(centre):
    with pytest.raises(UsageError, match="the longest arcs turn in X Y"):
        read("ballbar", real(timed(CIRCLE, MILL, Conditions())), centre=centre)


def test_the_feed_of_a_circle_by_its_time_is_told_in_mm_per_minute():
    """F2 of G93 goes round a circle of 50 mm twice a minute: 2 * 2 pi 50 mm/min."""
    by_time = CIRCLE.replace("G94", "G93").replace("F1000", "F2")
    for text, feed in ((CIRCLE, 1000.0), (by_time, 200 * np.pi)):
        found = read("ballbar", real(timed(text, MILL, Conditions())))
        assert found.head["feed_mm_min"] == approx(feed, abs=1e-5)


def test_samples_of_all_circles_together_are_counted(monkeypatch):
    """3000 samples a circle, of which two are more than 4000."""
    monkeypatch.setattr(instruments, "MOST", 4000)
    two = CIRCLE.replace("M2", "G3 X50 Y0 I-50 J0 F1000\nM2")
    assert len(read("ballbar", real(timed(CIRCLE, MILL, Conditions())), rate="160")) > 2900
    with pytest.raises(UsageError, match="samples are more than"):
        read("ballbar", real(timed(two, MILL, Conditions())), rate="160")
