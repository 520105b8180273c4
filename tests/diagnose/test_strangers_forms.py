"""Forms of physics that a measurement engineer simulated without having read the library: they are
written out here by hand, and share nothing with it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import signals, telegraph
from tests.diagnose.test_workshop import HEAD, MACHINE, diagnosed

LASER = '# quantity = "displacement"\n# sensitive = { X = 1.0 }\n'


def names(answer: dict) -> list[str]:
    return [f"{e['effect']}:{e['axis']}" for e in answer["effects"] if e["status"] == "accepted"]


def laser(deviation, y_mm: float = 100.0, seed: int = 1, noise_um: float = 0.2, runs: int = 5):
    """X from 20 to 580 mm, there and back. deviation(place, side, run) um."""
    rng = np.random.default_rng(seed)
    there = np.linspace(20.0, 580.0, 18) + rng.uniform(-5, 5, 18)
    rows, t = [], 1000.0 * seed
    for run in range(1, runs + 1):
        for side, places in ((1, there), (-1, there[::-1])):
            for p in places:
                t += 6.0
                read = deviation(p, side, run) + noise_um * rng.standard_normal()
                rows.append(f"{run},{t},{p:.3f},{y_mm},{side},1,{read:.2f}")
    head = HEAD.format("targets", "laser interferometer") + LASER
    return head + "run,t_s,X_mm,Y_mm,approach_X,approach_Y,reading_um\n" + "\n".join(rows) + "\n"


def test_a_rotation_shows_on_two_lines_of_two_recordings(tmp_path):
    """X turns about Z, by 15 urad in an S, on lines 300 mm apart; each recording has its zero."""

    def off(y_mm):
        return lambda p, side, run: -y_mm * 7.5e-3 * np.tanh((p - 300.0) / 90.0)

    texts = [laser(off(50.0), 50.0, 1), laser(off(350.0), 350.0, 2)]
    assert names(diagnosed(tmp_path, *texts)) == ["abbe:X"]


@pytest.mark.parametrize("middle,wide", [(330.0, 150.0), (200.0, 90.0)])
def test_a_worn_stretch_of_a_screw(tmp_path, middle, wide):
    """1.5 um of lost motion, 8 um more where most parts were cut, with soft ends."""

    def off(p, side, run):
        edge = 1 / (1 + np.exp((abs(p - middle) - wide / 2) / 8.0))
        return -side / 2 * (1.5 + 8.0 * edge)

    answer = diagnosed(tmp_path, laser(off))
    assert names(answer) == ["backlash_position:X"]
    value = {k: p["value"] for k, p in answer["effects"][0]["parameters"].items()}
    assert value["worn_mm"] == pytest.approx(middle, abs=15)
    assert value["worn_um"] == pytest.approx(8.0, rel=0.15)


def plays(way: np.ndarray, lengths: tuple[float, ...]) -> np.ndarray:
    """Mean of play operators of so many mm, each -1 to 1, along a way (N,) mm."""
    state, result = -np.ones(len(lengths)), []
    for step in np.diff(way, prepend=way[0]):
        state = np.clip(state + 2 * step / np.array(lengths), -1, 1)
        result.append(state.mean())
    return np.array(result)


def test_a_turn_is_read_in_small_steps(tmp_path):
    """Pre-sliding over 0.1 to 2.9 mm, read in steps from 0.02 to 5 mm behind each turn: the axis
    overran none of these places."""
    rng = np.random.default_rng(3)
    steps = np.geomspace(0.02, 5.0, 15)
    there = np.concatenate([[0.0], np.cumsum(steps)])
    place, side = [250.0], [1]
    for k in range(6):
        way = -1 if k % 2 == 0 else 1
        start = place[-1]
        place += (start + way * there[1:]).tolist()
        side += [way] * len(steps)
    far = np.concatenate([np.arange(200.0, 250.0, 0.01), np.array(place)])
    off = -2.5 * plays(far, (0.1, 0.4, 1.1, 2.9))[-len(place) :]
    rows = [
        f"1,{6.0 * k},{p:.3f},100,{s},1,{y + 0.15 * rng.standard_normal():.2f}"
        for k, (p, s, y) in enumerate(zip(place, side, off, strict=True))
    ]
    head = HEAD.format("targets", "laser interferometer") + LASER
    text = head + "run,t_s,X_mm,Y_mm,approach_X,approach_Y,reading_um\n" + "\n".join(rows) + "\n"
    assert names(diagnosed(tmp_path, text)) == ["windup:X"]


def test_a_step_shorter_than_an_overrun_is_not_overrun():
    place = np.array([50.0, 49.98, 49.9, 20.0, 45.0])
    side = np.array([1.0, -1.0, -1.0, -1.0, 1.0])
    gone = signals._since_turn(place, side, np.full(5, np.nan))
    assert gone[1:] == pytest.approx([0.02, 0.1, 30.0, 28.0])


def test_tools_that_are_changed_again_and_again(tmp_path):
    """A quick wear, then a steady one, in 16 parts; the bore is smaller by the wear of its edge."""
    rng = np.random.default_rng(2)
    rows = []
    for part in range(1, 49):
        age = (part - 1) % 16
        worn = 0.25 * age + 1.2 * (1 - np.exp(-age / 1.5))
        for reading in (1, 2):
            value = 32.0 + (-worn + 0.25 * rng.standard_normal()) * 1e-3
            rows.append(f"F1,bore_diameter,X,32.000,{value:.4f},{part},{reading}")
    head = HEAD.format("features", "coordinate measuring machine")
    text = head + "feature,kind,axis,nominal_mm,measured_mm,part,reading\n" + "\n".join(rows) + "\n"
    answer = diagnosed(tmp_path, text)
    assert [n.split(":")[0] for n in names(answer)] == ["tool_wear"]
    assert answer["effects"][0]["parameters"]["every"]["value"] == 16


def circles(radial, feeds=(600.0, 2000.0), radius=80.0, noise_um=0.2) -> list[str]:
    """A ball bar, both senses, at each feed. radial(t, x, y, vx, vy) um of samples in a row."""
    rng, texts = np.random.default_rng(4), []
    for k, feed in enumerate(feeds):
        rows, begin = [], 100.0 * k
        for run, sense in enumerate((1, -1), 1):
            t = np.linspace(0, 2 * np.pi * radius / (feed / 60), 2000)
            a = 0.7 + sense * t * feed / 60 / radius
            x, y = 300 + radius * np.cos(a), 200 + radius * np.sin(a)
            vx, vy = np.gradient(x, t), np.gradient(y, t)
            off = radial(t, x, y, vx, vy, a) + noise_um * rng.standard_normal(len(t))
            rows += [
                f"{run},{s:.4f},{p:.5f},{q:.5f},{sense},{e:.2f}"
                for s, p, q, e in zip(begin + t, x, y, off, strict=True)
            ]
            begin += t[-1] + 10
        head = HEAD.format("ballbar", "ball bar") + "# centre = { X = 300.0, Y = 200.0 }\n"
        head += f"# radius_mm = {radius}\n# feed_mm_min = {feed}\n"
        texts.append(head + "run,t_s,X_cmd_mm,Y_cmd_mm,sense,radial_um\n" + "\n".join(rows) + "\n")
    return texts


def test_an_ellipse_at_45_degrees_is_a_squareness(tmp_path):
    """A bow or a sag says the same, with more that is to be chosen."""
    texts = circles(lambda t, x, y, vx, vy, a: 80.0 * 60e-3 * np.sin(a) * np.cos(a))
    assert names(diagnosed(tmp_path, *texts))[0] == "squareness:XY"


@pytest.mark.parametrize("stated, leans", [("", 0.0), ("C0X", 1.0), ("C0Y", 0.0)])
def test_of_two_axes_the_one_leans_that_the_machine_names(tmp_path, stated, leans):
    """The circle says nothing of a turn of the part, by which both forms differ: a program that is
    corrected by the other one would cut a part that is turned against the axis it was set along. Y
    leans where nothing is stated (first the primary axis X, ISO 841)."""
    texts = circles(lambda t, x, y, vx, vy, a: 80.0 * 60e-3 * np.sin(a) * np.cos(a))
    machine = MACHINE + (f"[squareness]\n{stated} = 0.0\n" if stated else "")
    found = diagnosed(tmp_path, *texts, machine=machine)["effects"][0]
    assert (found["effect"], found["axis"]) == ("squareness", "XY")
    assert found["parameters"]["leans"]["value"] == leans
    assert found["parameters"]["urad"]["value"] == pytest.approx(-60.0, abs=3.0)


def spike(t: np.ndarray, v: np.ndarray, tau: float, length: float) -> np.ndarray:
    """Friction of -1 to 1 that turns round over a way, as a loop with integral action of the second
    order leaves it: e'' + 2 e' / tau + e / tau^2 = f' / tau, in small steps."""
    e = rate = 0.0
    friction, result = float(np.sign(v[0])), []
    for dt, speed in zip(np.diff(t, prepend=t[0]), v, strict=True):
        now = friction
        friction += (np.sign(speed) - friction) * (1 - np.exp(-abs(speed) * dt / length))
        jerk = (friction - now) / tau / dt if dt > 0 else 0.0
        for _ in range(4):
            rate += dt / 4 * (jerk - 2 * rate / tau - e / tau**2)
            e += dt / 4 * rate
        result.append(e)
    return np.array(result)


def test_a_spike_of_a_loop_and_of_friction_that_builds_up(tmp_path):
    """Both count, so that it is higher at the higher feed; it is alike in both directions."""

    def radial(t, x, y, vx, vy, a):
        return -25.0 * spike(t, vx, 0.04, 0.05) * np.cos(a)

    answer = diagnosed(tmp_path, *circles(radial))
    assert names(answer)[0] == "reversal_spike:X"
    assert not any("friction_asymmetry" in name for name in names(answer))


def test_a_hump_in_two_runs_only_is_unknown(tmp_path):
    """10 um at one place in runs 3 and 4: no outliers, for they lie side by side."""

    def off(p, side, run):
        return 10.0 * np.exp(-(((p - 300.0) / 80.0) ** 4)) * (run in (3, 4))

    answer = diagnosed(tmp_path, laser(off))
    assert answer["verdict"] == "unknown" and answer["unknown"]


def test_levels_of_burst_noise_follow_no_slope():
    """Signals that jump to and fro have a level between two jumps each, about one zero: the sum of
    what jumped does not carry a slope away."""
    rng = np.random.default_rng(5)
    n, at = 4000, np.sort(rng.choice(np.arange(100, 3900, 40), 40, replace=False))
    level = rng.normal(0, 1e-3, 41)[np.searchsorted(at, np.arange(n), side="right")]
    y = level + rng.normal(0, 5e-5, n)
    rows = SimpleNamespace(
        residual=np.concatenate([y, y]),
        file=np.zeros(2 * n, int),
        state=SimpleNamespace(velocity={}, position={}, approach={}, channels={}),
    )

    class Unit(SimpleNamespace):
        def __len__(self) -> int:
            return n

    units = [
        Unit(
            rows=np.arange(k * n, (k + 1) * n),
            dense=True,
            r=np.full(n, 5e-5),
            edges=np.array([0, n]),
            time=np.arange(n) * 0.01,
        )
        for k in (0, 1)
    ]
    found = telegraph.steps(cast(Any, rows), cast(Any, units))
    assert found[0] is not None
    assert (found[0][0].sum(axis=1) == 1).all()


def log(deviation, seconds: float = 60.0, rate_hz: float = 250.0, noise_um: float = 0.2) -> str:
    """X to and fro over 60 mm by its scale. deviation(t, x) um, of samples (N,)."""
    rng = np.random.default_rng(6)
    t = np.arange(0.0, seconds, 1 / rate_hz)
    share = (t * 10.0 / 60.0) % 2.0
    x = 200.0 + 60.0 * np.where(share < 1.0, share, 2.0 - share)
    off = deviation(t, x) + noise_um * rng.standard_normal(len(t))
    rows = [f"1,{s:.3f},{c:.4f},{c + d * 1e-3:.5f}" for s, c, d in zip(t, x, off, strict=True)]
    head = HEAD.format("trace", "scale") + f'# sees = "scale"\n# rate_hz = {rate_hz}\n'
    return head + "run,t_s,X_cmd_mm,X_act_mm\n" + "\n".join(rows) + "\n"


def test_an_oscillation_faster_than_the_averages_of_samples(tmp_path):
    """15,000 samples are averaged by three: 44.3 Hz is faster than half of 83."""
    answer = diagnosed(tmp_path, log(lambda t, x: 2.0 * np.sin(2 * np.pi * 44.3 * t + 1.0)))
    assert names(answer) == ["vibration:X"]
    value = {k: p["value"] for k, p in answer["effects"][0]["parameters"].items()}
    assert value["frequency_hz"] == pytest.approx(44.3, abs=0.01)
    assert value["amplitude_um"] == pytest.approx(2.0, abs=0.15)


def test_bursts_that_come_and_go_are_unknown(tmp_path):
    """Three bursts of 5 um for a second each, of no one frequency, in a log of 0.1 um."""

    def off(t, x):
        within = sum(np.exp(-(((t - c) / 0.6) ** 4)) for c in (11.0, 23.0, 44.0))
        return 5.0 * within * np.sin(2 * np.pi * (4.0 * t + 0.35 * t**2 % 50))

    answer = diagnosed(tmp_path, log(off, rate_hz=70.0, noise_um=0.1))
    assert answer["verdict"] == "unknown" and answer["unknown"]


@pytest.mark.parametrize("noise_um, verdict", [(1.0, "nothing-left-out"), (2.5, "unknown")])
def test_samples_that_scatter_more_than_logs_do_are_unknown(tmp_path, noise_um, verdict):
    """White, with no form that a name could have, and nothing stated of a reading: more than 1.5 um
    is no order of a log, whatever it is."""
    answer = diagnosed(tmp_path, log(lambda t, x: 0.0 * t, rate_hz=70.0, noise_um=noise_um))
    assert names(answer) == [] and answer["verdict"] == verdict


def test_a_control_that_overcompensates_is_plain_lost_motion(tmp_path):
    """The slide leads by 3.5 um behind every turn: negative, and the same everywhere."""
    rng = np.random.default_rng(4)
    t = np.arange(3000) * 0.02
    place = 300 + 180 * np.sin(2 * np.pi * t / 11.0)
    side = np.sign(np.gradient(place))
    rows = [
        f"1,{a:.3f},{p:.6f},100.0,{p + e:.6f},{100 + n:.6f}"
        for a, p, e, n in zip(
            t,
            place,
            1e-3 * (3.5 / 2 * side + 0.1 * rng.standard_normal(len(t))),
            1e-4 * rng.standard_normal(len(t)),
            strict=True,
        )
    ]
    head = HEAD.format("trace", "grid encoder") + '# sees = "tool"\n'
    text = head + "run,t_s,X_cmd_mm,Y_cmd_mm,X_act_mm,Y_act_mm\n" + "\n".join(rows) + "\n"
    answer = diagnosed(tmp_path, text)
    assert names(answer) == ["backlash:X"]
    size = answer["effects"][0]["parameters"]["size_um"]["value"]
    assert size == pytest.approx(-3.5, abs=0.1)


def test_bosses_that_are_milled_in_circles_come_out_smaller(tmp_path):
    """A boss' widest place is where the axis turns, having come outwards: short by half of 6 um
    of lost motion on either side, as a pocket is."""
    rng = np.random.default_rng(3)
    rows = []
    for part in (1, 2, 3):
        for number, (kind, nominal) in enumerate(
            (kind, nominal)
            for nominal in (20.0, 45.0, 80.0)
            for kind in ("pocket_size", "boss_diameter", "centre_distance")
        ):
            off = -6.0 * (kind != "centre_distance") + 0.7 * rng.standard_normal()
            rows.append(f"F{number},{kind},X,{nominal},{nominal + off * 1e-3:.4f},{part},1")
    head = HEAD.format("features", "coordinate measuring machine")
    text = head + "feature,kind,axis,nominal_mm,measured_mm,part,reading\n" + "\n".join(rows) + "\n"
    answer = diagnosed(tmp_path, text)
    assert names(answer) == ["backlash:X"]
    value = {k: p["value"] for k, p in answer["effects"][0]["parameters"].items()}
    assert (value["around"], value["size_um"]) == (1.0, pytest.approx(6.0, abs=0.6))


@pytest.mark.parametrize("yaw_urad,verdict", [(0.0, "nothing-left-out"), (20.0, "unknown")])
def test_an_autocollimator_alone(tmp_path, yaw_urad, verdict):
    """No name of the library is of a rotation alone: it is as the machine's file says, or not."""
    rng = np.random.default_rng(8)
    rows, t = [], 0.0
    for run in (1, 2, 3):
        for p in np.linspace(20.0, 580.0, 16):
            t += 9.0
            read = yaw_urad * np.sin(p / 90.0) + 0.4 * rng.standard_normal()
            rows.append(f"{run},{t},{p:.3f},100.0,1,1,{read:.2f}")
    head = HEAD.format("targets", "autocollimator") + '# quantity = "angle"\n'
    head += "# sensitive = { Z = 1.0 }\n"
    text = head + "run,t_s,X_mm,Y_mm,approach_X,approach_Y,reading_urad\n" + "\n".join(rows) + "\n"
    assert diagnosed(tmp_path, text)["verdict"] == verdict


def test_what_goes_with_a_force_is_no_noise(tmp_path):
    """A pull test of 21 readings at three places, no force twice: 2 um at 350 N, 0.45 um noise."""
    rng = np.random.default_rng(9)
    rows, t = [], 0.0
    for run, place in enumerate((150.0, 300.0, 450.0), 1):
        for force in (20.0, 310.0, 380.0, 175.0, -180.0, -390.0, -320.0):
            t += 15.0
            pulled = force + 15.0 * rng.standard_normal()
            read = 0.0055 * pulled + 0.45 * rng.standard_normal()
            rows.append(f"{run},{t},{place},100.0,1,1,{read:.2f},{pulled:.0f}")
    head = HEAD.format("targets", "dial indicator and load cell")
    head += '# quantity = "displacement"\n# sensitive = { X = 1.0 }\n# u_um = 0.3\n'
    text = head + "run,t_s,X_mm,Y_mm,approach_X,approach_Y,reading_um,force_X_N\n"
    answer = diagnosed(tmp_path, text + "\n".join(rows) + "\n")
    assert names(answer) == ["force_compliance:X"]


def test_lost_motion_at_one_place_that_is_pulled_from_both_sides(tmp_path):
    """X rests at 300 mm, reached from one side in odd runs and from the other in even ones, and is
    pulled to and fro by up to 400 N: 0.008 um per N, and 6 um between the two sides."""
    rng = np.random.default_rng(3)
    pulls = np.concatenate([np.arange(0, 401, 100), np.arange(300, -401, -100), [-200, 0]])
    rows = []
    for run in range(1, 5):
        side = 1 if run % 2 else -1
        for force in pulls:
            read = 0.008 * force - 3.0 * side + 0.2 * rng.standard_normal()
            rows.append(f"{run},{14 * len(rows)},300,100,{side},1,{read:.2f},{force + 0.5}")
    head = HEAD.format("targets", "dial gauge") + LASER
    head += "run,t_s,X_mm,Y_mm,approach_X,approach_Y,reading_um,force_X_N\n"
    answer = diagnosed(tmp_path, head + "\n".join(rows) + "\n")
    assert sorted(names(answer)) == ["backlash:X", "force_compliance:X"]
    size = next(e for e in answer["effects"] if e["effect"] == "backlash")["parameters"]["size_um"]
    assert size["value"] == pytest.approx(6.0, rel=0.1)


def test_a_carriage_on_two_rails_that_bend(tmp_path):
    """A rail on two supports gives by 16 a^2 (1 - a)^2 of what it gives in the middle under a load
    at a; 9 um. The carriage rests on both by the lever rule, on lines 40, 200 and 360 mm across."""
    level = '# quantity = "straightness"\n# sensitive = { Z = 1.0 }\n'
    texts = []
    for k, y in enumerate((40.0, 200.0, 360.0)):
        share = (y / 400.0) ** 2 + (1 - y / 400.0) ** 2

        def off(p, side, run, share=share):
            a = p / 600.0
            return -9.0 * 16 * (a * (1 - a)) ** 2 * share

        texts.append(laser(off, y, k + 1, noise_um=0.3).replace(LASER, level))
    answer = diagnosed(tmp_path, *texts)
    assert names(answer) == ["sag:X"]
    value = {k: p["value"] for k, p in answer["effects"][0]["parameters"].items()}
    assert value["rails"] == 1 and value["size_um"] == pytest.approx(9.0, rel=0.1)


@pytest.mark.parametrize("width_s, at_s", [(0.3, 13.3), (1.0, 8.1)])
def test_an_excursion_is_no_wander_of_a_zero(tmp_path, width_s, at_s):
    """8 um, once, over noise of 0.3 um: nobody knows what it was, and something was there."""
    rng = np.random.default_rng(1)
    t = np.arange(0, 30, 0.01)
    x = 300 + 100 * np.sin(2 * np.pi * t / 6)
    off = 8.0 * np.exp(-(((t - at_s) / width_s) ** 2)) + 0.3 * rng.normal(size=len(t))
    rows = [f"1,{a:.2f},{b:.5f},{b + e * 1e-3:.6f}" for a, b, e in zip(t, x, off, strict=True)]
    head = HEAD.format("trace", "grid encoder") + '# sees = "tool"\n'
    text = head + "run,t_s,X_cmd_mm,X_act_mm\n" + "\n".join(rows) + "\n"
    answer = diagnosed(tmp_path, text)
    assert answer["verdict"] == "unknown" and not names(answer)
