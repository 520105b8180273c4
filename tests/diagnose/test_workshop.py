"""Recordings as a workshop makes them: a dial gauge of 0.01 mm, a calliper, the log of a drive. The
physics is written out here by hand and shares nothing with the library of effects."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc.cli import main

MACHINE = """format = "gcomp-machine/1"
name = "router"
control = "grbl"
chain = "w-X-b-Y-Z-t"
[axes.X]
travel = [0.0, 600.0]
least_increment = 0.001
[axes.Y]
travel = [0.0, 400.0]
least_increment = 0.001
[axes.Z]
travel = [-100.0, 0.0]
least_increment = 0.001
"""
HEAD = '# format = "gcomp-recording/1"\n# kind = "{}"\n# machine = "router"\n# instrument = "{}"\n'


def diagnosed(
    folder: Path, *texts: str, machine: str = MACHINE, options: tuple[str, ...] = ()
) -> dict:
    """The answer to recordings together."""
    (folder / "machine").mkdir(parents=True)
    (folder / "machine" / "machine.toml").write_text(machine)
    files = [folder / f"r{k}.csv" for k in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    words = ["diagnose", *map(str, files), "--machine", str(folder / "machine"), *options]
    assert main([*words, "--json", str(folder / "a.json"), "--quiet"]) == 0
    answer: dict = json.loads((folder / "a.json").read_text())
    return answer


def names(answer: dict) -> dict[str, dict]:
    """Effect and axis to its parameters, of those that are accepted."""
    accepted = (e for e in answer["effects"] if e["status"] == "accepted")
    return {f"{e['effect']}:{e['axis'] or ''}": e["parameters"] for e in accepted}


def gauge(deviation, scatter_um=4.0, step_um=10.0, runs=3, seed=1, targets=9, gap=50.0) -> str:
    """X from 20 mm, there and back, read to a division, zero at the first reading. deviation(place,
    side, seconds) um."""
    rng = np.random.default_rng(seed)
    there = 20.0 + gap * np.arange(targets)
    rows, t, zero = [], 0, None
    for run in range(1, runs + 1):
        for side, places in ((1, there), (-1, there[::-1])):
            for p in places:
                t += 6
                y = deviation(p, side, t) + scatter_um * rng.standard_normal()
                zero = y if zero is None else zero
                read = step_um * round((y - zero) / step_um)
                rows.append(f"{run},{t},{p:g},{side},{read:g}")
    head = HEAD.format("targets", "dial gauge, 0.01 mm")
    head += '# quantity = "displacement"\n# sensitive = { X = 1.0 }\n'
    return head + "run,t_s,X_mm,approach_X,reading_um\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize("scatter_um", [0.0, 3.0, 8.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_gauge_that_scatters_by_less_than_a_division_finds_nothing(tmp_path, scatter_um, seed):
    answer = diagnosed(tmp_path, gauge(lambda p, side, t: 0.0, scatter_um, seed=seed))
    assert not answer["effects"] and answer["verdict"] == "nothing-left-out"


@pytest.mark.parametrize("lost_um", [25.0, 150.0, 1200.0])
def test_lost_motion_of_any_size(tmp_path, lost_um):
    found = names(diagnosed(tmp_path, gauge(lambda p, side, t: -side * lost_um / 2)))
    assert list(found) == ["backlash:X"]
    assert found["backlash:X"]["size_um"]["value"] == pytest.approx(lost_um, abs=4, rel=0.02)


@pytest.mark.parametrize("ppm", [200.0, 3000.0, -10000.0])
def test_steps_per_mm_that_are_wrong(tmp_path, ppm):
    """A belt's pulley, a screw of another lead: 0.02 to 1 %."""
    found = names(diagnosed(tmp_path, gauge(lambda p, side, t: ppm * p * 1e-3)))
    assert list(found) == ["scale:X"]
    assert found["scale:X"]["ppm"]["value"] == pytest.approx(ppm, abs=10, rel=0.02)


def test_lost_motion_beside_wrong_steps_per_mm(tmp_path):
    """100 um beside 0.15 %, which is 630 um over these targets."""
    found = names(diagnosed(tmp_path, gauge(lambda p, side, t: 1.5 * p - 50 * side)))
    assert set(found) == {"scale:X", "backlash:X"}
    assert found["backlash:X"]["size_um"]["value"] == pytest.approx(100, abs=5)


def test_half_a_wave_over_the_travel_is_no_wave_of_the_screw(tmp_path):
    """At targets 50 mm apart a wave of 900 mm and one of 47.4 mm read the same."""
    answer = diagnosed(tmp_path, gauge(lambda p, side, t: 60 * np.sin(np.pi * p / 450)))
    assert list(names(answer)) == ["pitch_shape:X"]
    assert not any("cyclic" in str(e["equivalent"]) for e in answer["effects"])


def test_a_jump_takes_no_reading_for_an_outlier(tmp_path):
    """400 um lost behind 170 s: the interval holds them, and not a quarter of them."""
    answer = diagnosed(tmp_path, gauge(lambda p, side, t: -400.0 * (t > 170)))
    jump = names(answer)["step_loss:X"]["jump_um"]
    assert jump["value"] == pytest.approx(-400, abs=8)
    assert jump["ci95"][0] < -400 < jump["ci95"][1] < -200
    assert not answer["data_faults"]


def parts(deviation, scatter_mm: float, seed: int) -> str:
    """Two parts, 24 features, each read twice by a calliper of 0.01 mm. deviation(kind, axis, mm)
    mm."""
    rng = np.random.default_rng(seed)
    sizes = {
        "centre_distance": (20, 40, 80, 120, 160),
        "pocket_size": (15, 30, 60),
        "boss_diameter": (12, 25, 50, 100),
    }
    rows = []
    for part in (1, 2):
        for axis in "XY":
            for kind, many in sizes.items():
                for mm in many:
                    for reading in (1, 2):
                        y = mm + deviation(kind, axis, mm) + scatter_mm * rng.standard_normal()
                        name = f"{kind[0]}{axis}{mm}"
                        rows.append(f"{name},{kind},{axis},{mm},{y:.2f},{part},{reading}")
    columns = "feature,kind,axis,nominal_mm,measured_mm,part,reading\n"
    return HEAD.format("features", "calliper, 0.01 mm") + columns + "\n".join(rows) + "\n"


@pytest.mark.parametrize("seed", [8, 9, 10])
def test_no_feature_of_good_parts_stands_out(tmp_path, seed):
    """With a test for each of 24 features one of them stood out in every other lot."""
    answer = diagnosed(tmp_path, parts(lambda kind, axis, mm: 0.0, 0.004 * (seed - 7), seed))
    assert answer["verdict"] == "nothing-left-out" and not answer["mismatch"]


def drive(gain: float, velocity_s: float) -> str:
    """The log of X under a position loop of a gain (1/s), a velocity loop of the first order, an
    encoder of 2.5 um: integrated by Euler in steps of 0.2 ms."""
    dt, sub = 0.002, 10
    command = [50.0]
    moves = ((150, 40, 400), (50, 80, 400), (120, 15, 400), (80, 60, 800), (150, 30, 400))
    for target, feed, a in moves:
        way = target - command[-1]
        ends = abs(way) / feed + feed / a
        t = np.arange(dt, ends + 0.3, dt)
        speed = np.interp(t, [0, feed / a, ends - feed / a, ends], [0, feed, feed, 0])
        gone = np.minimum(np.cumsum(speed) * dt, abs(way))
        command += list(command[-1] + np.sign(way) * gone)
    c = np.array(command)
    x, v, actual = c[0], 0.0, []
    for place, then in zip(c, [*c[1:], c[-1]], strict=True):
        actual.append(x)
        for part in np.arange(sub) / sub:
            wanted = gain * (place + part * (then - place) - x)
            v += dt / sub / velocity_s * (wanted - v)
            x += v * dt / sub
    read = np.round(np.array(actual) / 0.0025) * 0.0025
    rows = [f"1,{k * dt:.3f},{c[k]:.4f},{read[k]:.4f}" for k in range(0, len(c), 2)]
    columns = "run,t_s,X_cmd_mm,X_act_mm\n"
    return HEAD.format("trace", "encoder") + '# sees = "scale"\n' + columns + "\n".join(rows) + "\n"


def test_a_loop_without_feed_forward_is_one_lag(tmp_path):
    """A gain of 30 per s: 33.3 ms, and no friction or delay beside it, though at 400 mm/s2 the lag
    comes and goes by 0.4 mm."""
    found = names(diagnosed(tmp_path, drive(30.0, 0.004)))
    assert list(found) == ["servo_lag:X"]
    assert found["servo_lag:X"]["tau_ms"]["value"] == pytest.approx(33.3, rel=0.03)
    assert found["servo_lag:X"]["settle_ms"]["value"] == pytest.approx(30.0, rel=0.15)


def test_a_curve_of_few_targets_on_a_long_travel_is_the_one_of_a_short_travel(tmp_path):
    """Polynomials over a metre are a line and a parabola within 160 mm of it: a screw's error with
    two turns there was unknown."""

    def curve(p, side, t):
        u = (p - 100.0) / 80.0
        return 40.0 * (u - u**3) + 20.0 * u**2 * (1 - u) - 6.0 * side

    text = gauge(curve, scatter_um=1.0, step_um=1.0, gap=20.0)
    short = MACHINE.replace("[0.0, 600.0]", "[15.0, 185.0]")
    wide = MACHINE.replace("[0.0, 600.0]", "[-500.0, 500.0]")
    answers = [
        diagnosed(tmp_path / name, text, machine=machine)
        for name, machine in (("short", short), ("wide", wide))
    ]
    one, other = map(names, answers)
    assert set(one) == set(other) == {"pitch_shape:X", "backlash:X"}
    ends = [other["pitch_shape:X"][name]["value"] for name in ("from_mm", "to_mm")]
    assert ends == [20.0, 180.0]
    (curved,) = (e for e in answers[1]["effects"] if e["effect"] == "pitch_shape")
    assert curved["equivalent"] == ["abbe:X"]  # no length that is wrong is such a curve
    after = [answer["fit"]["rms_after_um"] for answer in answers]
    assert after[1] == pytest.approx(after[0], rel=0.1)


@pytest.mark.parametrize("both", [False, True])
def test_a_step_gauge_that_stands_askew(tmp_path, both):
    """15 ppm too long by a touch probe on a step gauge; a scale of glass beside it says nothing is
    wrong. By itself the gauge tells it from no error of the screw."""

    def table(instrument: str, ppm: float, seed: int) -> str:
        text = gauge(lambda p, side, t: ppm * 1e-3 * p, 0.3, 0.1, seed=seed)
        return text.replace("dial gauge, 0.01 mm", instrument)

    texts = [table("touch probe on step gauge", 15.0, 1)]
    texts += [table("linear comparator (glass scale)", 0.0, 2)] * both
    answer = diagnosed(tmp_path, *texts)
    if not both:
        assert list(names(answer)) == ["scale:X"]
        assert "cosine:X" in answer["effects"][0]["equivalent"]
        return
    assert list(names(answer)) == ["cosine:X"]
    found = names(answer)["cosine:X"]
    assert found["ppm"]["value"] == pytest.approx(-15.0, abs=2.0)
    assert (found["file"]["value"], found["touched"]["value"]) == (0.0, 1.0)


@pytest.mark.parametrize("seconds", [240.0, 280.0])
def test_a_screw_gets_warm_within_a_test_of_some_minutes(tmp_path, seconds):
    """100 ppm with a time constant of 10 minutes, of which a few minutes show a third: not 170 ppm
    that went when the axis was run no longer."""

    def warm(p, side, t):
        return 100e-3 * (p - 20) * (1 - np.exp(-t * seconds / 324 / 600))

    text = gauge(warm, scatter_um=0.3, step_um=0.1)
    head, rows = text.rsplit("reading_um\n", 1)
    cells = [row.split(",") for row in rows.split()]
    quick = [",".join([c[0], f"{float(c[1]) * seconds / 324:g}", *c[2:]]) for c in cells]
    text = head + "reading_um\n" + "\n".join(quick) + "\n"
    found = names(diagnosed(tmp_path, text.replace("dial gauge, 0.01 mm", "glass scale")))
    assert list(found) == ["screw_heat:X"]
    assert found["screw_heat:X"]["until_s"]["value"] == 0.0
    assert found["screw_heat:X"]["grown_ppm"]["value"] == pytest.approx(100.0, rel=0.15)
