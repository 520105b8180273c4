"""The cases of workshops: contracts, bytes, energy and signs by hand."""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache

import numpy as np
import pytest

from postproc.machine.file import read_machine
from postproc.recordings import ReadingOptions, Source
from postproc.recordings.contract import read
from postproc.units import UM
from proof.workshops import TIERS, make
from proof.workshops.aliens import ALIENS
from proof.workshops.base import Redraw
from proof.workshops.case import Case, Hidden, stacked
from proof.workshops.files import machine_files
from proof.workshops.forms import BUILDS, FORMS
from proof.workshops.machines import Machine, turn
from proof.workshops.readings import add, noisy
from proof.workshops.recordings import Recording
from proof.workshops.slow import STEEL
from proof.workshops.tiers import COARSE_SIZES, LEAST, SIZES
from proof.workshops.trial import judgeable
from proof.worlds import write
from tests.proof.digests import elsewhere

COUNTS = {"null": 9, "adversarial": 9, "single": 34, "pair": 8, "alien": 12}

cases = lru_cache(None)(lambda: tuple(make(1, COUNTS)))


def test_every_effect_of_the_contract_has_forms():
    assert len(FORMS) == 34 and sum(map(len, FORMS.values())) == 90 and len(ALIENS) == 12
    for build, forms in FORMS.items():
        assert len(set(forms)) == len(forms) > 1 and all(forms), build.__name__


@pytest.mark.parametrize("tier", TIERS)
def test_a_case_is_what_the_contracts_want(tier, tmp_path):
    of = [case for case in cases() if case.truth["tier"] == tier]
    assert len(of) == COUNTS[tier]
    for case in of:
        write(case.name, case.files, tmp_path)
        folder = tmp_path / case.name
        machine = read_machine(folder / "machine")
        paths = sorted(folder.glob("r*.csv"))
        assert len(paths) == sum(name.startswith("recordings/") for name in case.files) > 0
        ended = -1.0
        for path in paths:
            recording = read(Source(path.name, path.read_bytes()), ReadingOptions())
            assert not recording.faults and recording.machine == machine.name
            if recording.kind == "features":
                continue
            t = recording.columns["t_s"]
            assert (np.diff(t) >= 0).all() and t[0] > ended
            ended = t[-1]
            for x in recording.axes:
                low, high = machine.axes[x].travel
                assert low <= recording.position(x).min() and recording.position(x).max() <= high


def test_the_map_means_to_the_tool_what_it_means_here(tmp_path):
    """A machine whose tables are exact deviates as the tool reads it: to the rounding of its tables
    in the files, 0.01 um."""
    chains = set()
    for number in range(30):
        rng = np.random.default_rng(number)
        machine = Machine(rng)
        if machine.states_u:
            continue
        folder = tmp_path / str(number)
        folder.mkdir()
        for name, text in machine_files(machine).items():
            (folder / name).write_text(text)
        pos = {a: rng.uniform(*machine.travel[a], 50) for a in machine.axes}
        side = {a: rng.choice([-1.0, 1.0], 50) for a in machine.axes}
        theirs = read_machine(folder)
        letters = theirs.letters
        expected = theirs.deviation(
            np.array([pos[a] for a in letters]), np.array([side[a] for a in letters])
        )
        mine = machine.deviation(pos, side)
        assert np.array([mine[a] for a in letters]) == pytest.approx(expected / UM, abs=1e-5)
        chains.add(machine.chain)
    assert len(chains) >= 3


def digest(seed):
    total = hashlib.sha256()
    for case in make(seed, dict.fromkeys(TIERS, 3)):
        total.update(json.dumps([case.name, case.files, case.truth]).encode())
    return total.hexdigest()


def test_the_same_seed_makes_the_same_bytes():
    """In another process, too."""
    assert elsewhere("tests.proof.test_workshops", 5) == digest(5) != digest(6)


# -- what is hidden ------------------------------------------------------------------------


def test_every_effect_stands_out():
    """By six standard deviations (an energy of 36) beside what else is hidden, in the sizes of the
    trials; names of cases tell nothing."""
    names, number_of = set(), {"null": 0, "adversarial": 0, "single": 1, "pair": 2, "alien": 1}
    for case in cases():
        truths, tier = case.truth["truth"], case.truth["tier"]
        assert len({t["effect"] for t in truths}) == number_of[tier]
        for t in truths:
            least, most = COARSE_SIZES if case.truth["machine"]["coarse"] else SIZES
            assert t["snr"] >= LEAST and least <= t["peak_um"] <= most, t
        names |= {t["effect"] for t in truths if tier == "single"}
    assert names == set(BUILDS)
    in_order = sorted(cases(), key=lambda case: case.name)
    assert [c.truth["tier"] for c in in_order[:9]] != ["null"] * 9


def at_rest(n):
    """A case of one recording along X, one reading a second."""
    c = Case(np.random.default_rng(1), Machine(np.random.default_rng(1), kinds=["mill"]))
    rec = Recording("targets", "r", sensitive={"X": 1.0})
    way = {a: np.zeros(n) for a in c.machine.axes}
    rec.set_way(np.arange(float(n)), way, np.arange(n))
    return c, rec


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_the_energy_of_a_step_by_hand(memory):
    """Half of n readings h higher than the others, white noise s: h / 2 less its zero, sqrt(n) h /
    2 s standard deviations. Noise of which half has a correlation m from reading to reading has
    (1 + (1 + m) / (1 - m)) / 2 times the variance in a mean: 5 for m = 0.8."""
    n, h, s = 4000, 3.0, 0.5
    c, rec = at_rest(n)
    rec.step = 1e-6
    add(c, rec, s, memory)
    step = np.where(np.arange(n) % 2, h, 0.0)
    shape, peak = stacked(c, Hidden("scale", "X", "", lambda rec, size: {"reading_um": step}))
    spread = 5.0 if memory else 1.0
    assert peak == pytest.approx(h / 2)
    assert np.sqrt(shape @ shape) == pytest.approx(h * np.sqrt(n) / 2 / s / np.sqrt(spread))
    y = noisy(np.random.default_rng(3), rec, "reading_um") - rec.zero["reading_um"]
    assert np.std(y) == pytest.approx(s, rel=0.05)
    means = y.reshape(-1, 100).mean(axis=1)
    assert np.std(means) == pytest.approx(s * np.sqrt(spread / 100), rel=0.3)


def drawn(effect, begins, kind, wanted=lambda c, hidden: True):
    """A case with a form, not yet scaled, what is hidden, and the first recording of a kind."""
    (form,) = (f for f in FORMS[BUILDS[effect]] if f.startswith(begins))
    for seed in range(200):
        r = np.random.default_rng(seed)
        c = Case(r, Machine(r))
        try:
            hidden = BUILDS[effect](c, form)
        except Redraw:
            continue
        of_kind = [rec for rec in c.recs if rec.kind == kind]
        if of_kind and wanted(c, hidden):
            return c, hidden, of_kind[0]
    raise AssertionError(f"no {effect} in {kind}")


def test_backlash_lags():
    """10 um of play: 5 um short of the target from either side."""
    _, hidden, rec = drawn("backlash", "dead play", "targets")
    hidden.size = 10.0
    assert {*rec.sense_of[hidden.axis]} == {-1.0, 1.0}
    assert hidden.seen(rec)["reading_um"] == pytest.approx(-5.0 * rec.sense_of[hidden.axis])


def test_lost_motion_comes_over_a_length():
    """10 um of lost motion, 5 um behind on the way up. A contact that gives way over 2 mm: of the
    10 um behind a turn 63.2 % are there after 2 mm. A belt that slips after 4 mm: half of them."""
    c, rec = at_rest(5)
    x = np.array([0.0, 50.0, 49.0, 48.0, 0.0])
    rec.set_way(np.arange(5.0), {a: x for a in c.machine.axes}, np.arange(5))
    gone = np.array([1.0, 2.0, 50.0])  # mm since the turn
    expected = [-5.0, -5.0, *(5.0 - 10.0 * np.exp(-gone / 2.0))]
    y = rec.relaxing("X", lambda sense: -sense * 5.0, 2.0)
    assert y == pytest.approx(np.array(expected))
    assert rec.play("X", 10.0, 4.0) == pytest.approx([-5.0, -5.0, -2.5, 0.0, 5.0])


def test_a_scale_grows_with_the_place():
    """10 um too far in 1 m; and in parts 1 um too much in 100 mm."""
    _, hidden, rec = drawn("scale", "screw warmer", "targets")
    hidden.size = 0.01
    assert np.ptp(hidden.seen(rec)["reading_um"] - 0.01 * rec.pos[hidden.axis]) < 1e-9
    _, hidden, rec = drawn("scale", "wrong steps/mm in parts", "features")
    hidden.size = 0.01
    along = rec.parts["axis"] == hidden.axis
    assert hidden.seen(rec)["measured"] == pytest.approx(0.01 * rec.parts["nominal_mm"] * along)


@pytest.mark.parametrize("name", ["C0Y", "B0Z", "A0Z", "B0X"])
def test_squareness_is_a_rotation(name):
    """ISO 230-1: Y that leans by C0Y = 100 urad goes towards -X, 10 um in 100 mm. B0X of the
    thesis' grinder, -382.35 urad, lifts Z by 65 um at X = 170 mm. What is hidden is the same as in
    the map."""
    moved = {d: np.zeros(1) for d in "XYZ"}
    turn(moved, np.array([[0.0], [0.0], [100.0]]), {"Y": np.array([100.0])})
    assert moved["X"] == pytest.approx([-10.0])
    turn(moved, np.array([[0.0], [-382.352941], [0.0]]), {"X": np.array([170.0])})
    assert moved["Z"] == pytest.approx([65.0])
    c, hidden, rec = drawn(
        "squareness", "face", "targets", lambda c, hidden: hidden.params["name"] == name
    )
    hidden.size = 100.0
    m = Machine(np.random.default_rng(0), flat=True, kinds=[c.machine.kind])
    m.chain, m.square_true, m.axes = c.machine.chain, {name: 100.0}, c.machine.axes
    for tables in m.true.values():
        tables.clear()
    in_map = rec.project(m.deviation(rec.pos, rec.sense_of))["reading_um"]
    assert hidden.seen(rec)["reading_um"] == pytest.approx(in_map) and abs(in_map).max() > 1


def test_a_lag_is_behind():
    """2 ms behind: at 10 mm/s 20 um, whatever the sign of the speed; a control's log shows it."""
    _, hidden, rec = drawn("servo_lag", "pure", "trace")
    hidden.size = 2e-3
    v = rec.vel[hidden.axis]
    assert rec.sees == "scale" and v.min() < 0 < v.max()
    assert hidden.seen(rec)[f"{hidden.axis}_act"] == pytest.approx(-2.0 * v)
    _, loop, rec = drawn("servo_lag", "first order", "trace")
    loop.size = 2e-3
    y, v = loop.seen(rec)[f"{loop.axis}_act"], rec.vel[loop.axis]
    fast = np.abs(v) > 0.5 * np.abs(v).max()
    assert np.corrcoef(y[fast], -v[fast])[0, 1] > 0.9


def test_a_warm_screw_is_longer():
    """11.7 um for 1 m and 1 K, away from the fixed bearing; more after the strokes."""
    for end, sign in (("low", 1), ("high", -1)):
        c, hidden, rec = drawn("screw_heat", f"fixed bearing at the {end}", "targets")
        a, m = hidden.axis, c.machine
        hidden.size = STEEL * m.length(a) / c.heat(a, rec.t, hidden.params["tau_s"]).max()  # 1 K
        y = hidden.seen(rec)["reading_um"]
        far = (rec.pos[a] - m.travel[a][end == "high"]) * sign
        assert (far > 0).all() and (sign * y >= 0).all()
        assert np.max(sign * y / far) == pytest.approx(STEEL)


def test_a_small_cutter_leaves_more():
    """5 um under its size: bores are 5 um smaller, bosses larger, distances as they were."""
    _, hidden, rec = drawn("tool_size", "cutter", "features")
    assert hidden.size == -5.0
    y, kind = hidden.seen(rec)["measured"], rec.parts["kind"]
    assert set(y[kind == "pocket_size"]) == {-5.0} and set(y[kind == "boss_diameter"]) == {5.0}
    assert not y[(kind == "centre_distance") | (kind == "step")].any()


def test_angles_act_by_their_arm():
    """EBZ of 10 urad: X 115 mm, tool 5 mm, measured at 20 mm: an arm of 100 mm, -1 um in Z; a tool
    of 40 mm along Z: +0.4 um in X."""
    m = Machine(np.random.default_rng(0), kinds=["lathe"])
    m.measured_at["Z"]["X"], m.tool = 20.0, {"X": 5.0, "Z": 40.0}
    moved = {d: np.zeros(1) for d in "XYZ"}
    at = {"X": np.array([115.0]), "Z": np.array([300.0])}
    turn(moved, np.array([[0.0], [10.0], [0.0]]), m.arm("Z", at))
    assert (moved["Z"][0], moved["X"][0]) == pytest.approx((-1.0, 0.4))


def test_faults_of_the_data_are_no_effects_to_be_named():
    fault = {"effect": "outlier", "axis": "", "peak_um": 5.0, "effect_also": []}
    effect = {"effect": "bow", "axis": "X", "peak_um": 5.0, "effect_also": ["sag"]}
    noise = [
        {"file": "a", "notes": ["slow wander 0.12 um", "correlated noise rho=0.3"]},
        {"harsh": "traffic", "text": "forklift"},
    ]
    hidden, details = judgeable(
        {"tier": "pair", "truth": [effect, fault], "plan": ["straightness"], "noise": noise}
    )
    assert [t["effect"] for t in hidden] == ["bow"] and hidden[0]["twins"] == ["sag"]
    assert details["tier"] == "pair_fault"
    kinds = [of["kind"] for of in details["noise"]["all"]["signal"]]
    assert kinds == ["slow wander", "correlated noise", "traffic"]
    alien = {"effect": "alien", "axis": "X", "peak_um": 4.0, "effect_also": []}
    hidden, details = judgeable({"tier": "alien", "truth": [alien], "plan": [], "noise": []})
    assert (hidden[0]["axis"], details["tier"]) == ("", "alien")
