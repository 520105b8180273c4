"""The seventh family of kinds. Do not read while working on the judged tool."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from scipy.signal import lfilter

from proof import strangers_trial
from proof.strangers import TIERS, apart_aliens, make
from proof.strangers.apart_designs import ALIENS, PLANS, absent, experiment
from proof.strangers.apart_motion import slow
from proof.strangers.apart_place import cut
from proof.strangers.apart_servo import loop_error
from proof.strangers.apart_time import birch_downs, rule_of_thumb
from proof.strangers.base import observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import ballbar, features
from proof.strangers.hidden import draw_effect
from proof.strangers.machines import draw_machine
from proof.strangers.noise import LATER, MORE_FAST, MORE_SLOW, Noise
from proof.strangers.plans import EFFECTS
from proof.strangers.registry import FORMS, allowed
from proof.strangers.world import draw_world
from tests.proof.strangers_runs import MILL, files, jog, run

NUMBERED = re.compile(r"(alien:)?apart-\d+")
FRAME = {"quant", "outlier", "wide_zero", "zero_by_run"}  # what rounds, slips and sets up
FAST, SLOW = (sorted(k for k in kinds if "apart" in k) for kinds in (MORE_FAST, MORE_SLOW))
FREEZE = "3" * 40


def world(recs):
    return draw_world(stream("w"), MILL, recs, "apart", {"load": True, "spindle": True})


def own(effect):
    return [f for _, family, f in FORMS[effect] if family == "apart"]


def test_every_effect_has_a_form_and_all_bear_numbers():
    for effect in EFFECTS:
        assert own(effect), effect
        assert {family for _, family, _ in allowed(effect, "apart")} == {"apart"}
    for forms in FORMS.values():
        assert all(NUMBERED.fullmatch(n) for n, family, _ in forms if family == "apart")
    assert sum(n.startswith("alien:apart-") for n in FORMS) == 8
    assert set(LATER["apart"]["all"]) == set(FAST + SLOW) and len(FAST + SLOW) == 10
    assert set(PLANS) == set(EFFECTS)


@pytest.mark.parametrize("tier", TIERS)
def test_cases_draw_from_their_own_family_alone(tier):
    for k in (0, 1):
        c = make("test", tier, k, "apart")
        check_case(c, tier)
        assert k or make("test", tier, k, "apart") == c
        drawn = {s["kind"] for f in c.details["noise"].values() for s in f["signal"]}
        drawn |= {t["form"] for t in c.truth}
        assert all(NUMBERED.fullmatch(k) for k in drawn - FRAME)
        if tier in ("single", "masked", "pair", "triple"):
            assert all(c.details["plan"] in PLANS[t["effect"]] for t in c.truth)


@pytest.mark.parametrize("kind", FAST)
def test_fast_kinds_have_their_variance(kind):
    """What the file holds, rounded where a kind rounds, over what the oracle is told of it."""
    for rec in files():
        drawn = [MORE_FAST[kind](stream("n", kind, k), 0.4, rec) for k in range(25)]
        x = []
        for d in drawn:
            var = d.var + sum(c**2 for c in d.columns)
            v = np.round(d.values / d.quant) * d.quant if d.quant else d.values
            v = lfilter(d.white_a, d.white_b, v)
            x.append((v / np.sqrt(var))[len(d.white_a) * 30 - 30 :])
            assert (v.std() > 0.15) and d.spec[0]["sd_um"] == 0.4
        if len(drawn[0].white_a) > 1:
            low = np.mean([np.mean(v[1:] * v[:-1]) for v in x if len(v) > 1500] or [0.0])
            assert abs(low) < 0.02
        x = np.concatenate(x)
        if len(x) > 1500:
            assert np.mean(x**2) == pytest.approx(1.0, abs=0.1), rec.kind
            assert abs(np.mean(x)) < 0.06


@pytest.mark.parametrize("kind", SLOW)
def test_slow_kinds_have_their_covariance(kind):
    """Differences of two readings, each over what the oracle is told of it, have unit variance."""
    for rec in files()[:2]:
        n = rec.n_obs
        at = [int(n * x) for x in (0.02, 0.1, 0.35, 0.4, 0.8, 0.99)]
        ratio = []
        for k in range(150):
            x = Noise(np.zeros(n), np.zeros(n), [])
            MORE_SLOW[kind](stream("s", kind, k), x, 0.7, rec, None, 0)
            cov = np.diag(x.var[at]) + sum(np.outer(c[at], c[at]) for c in x.columns)
            for kernel, t in x.kernels:
                cov = cov + kernel(t[at], t[at])
            for i, j in itertools.combinations(range(len(at)), 2):
                var = cov[i, i] + cov[j, j] - 2 * cov[i, j]
                ratio.append((x.values[at[i]] - x.values[at[j]]) ** 2 / var)
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.3), rec.kind


def test_experiments_are_acceptance_tests():
    """One to four files one after another within the travels; half an hour and more where heat is
    looked for, both senses and two feeds on circles, unless a visit is poor."""
    good = {"circles": 0, "full_cycles": 0}
    for suspect in [*EFFECTS, *sorted(set(ALIENS))]:
        for k in range(3):
            m, recs, _, plan = experiment(stream("x", suspect, k), suspect, False)
            assert 1 <= len(recs) <= 4
            assert all(b.t[0] > a.t[-1] for a, b in itertools.pairwise(recs))
            for q in recs:
                assert np.isfinite(q.pos).all()
                for a in m.axes:
                    lo, hi = m.travel[a]
                    assert q.pos[:, a].min() >= lo and q.pos[:, a].max() <= hi, plan
                if q.kind == "targets":
                    assert (q.sgn[:, m.axes] != 0).all()
                if q.kind == "trace":
                    assert q.moving and np.abs(q.vel).max() * 60 < 1.3 * m.vmax
            if plan in ("environment", "axis_heat", "spindle"):
                assert np.ptp(recs[0].t) > 1800
            if plan == "circles" and len({q.meta["feed"] for q in recs}) == 2:
                good[plan] += all(set(q.meta["sense"]) == {1, -1} for q in recs)
            if plan == "full_cycles":
                good[plan] += all(q.run.max() == 5 and len(q.t) >= 110 for q in recs)
    assert good["circles"] > 1 and good["full_cycles"] > 1


def test_a_fourth_of_visits_is_poor():
    runs = [experiment(stream("poor", k), "pitch_shape", False)[1] for k in range(80)]
    assert 10 <= sum(q[0].run.max() == 1 for q in runs) <= 30


def test_few_thermometers_are_absent():
    gone = [absent(stream("a", k), MILL, "screw_heat") for k in range(200)]
    assert 30 < sum(map(len, gone)) < 100


def test_reversal_values_lag_by_half_their_size():
    q = run()
    w = world([q])
    for f in own("backlash"):
        s = f(w, stream("f"), 0)
        far = q.since[:, 0] > 0.05
        y = observe(q, s.field(q, 6.0))[0]
        assert np.allclose(y[far], -3.0 * q.sgn[far, 0], atol=0.01)
        assert s.params(6.0) == {"size_um": 6.0}


def test_lost_motion_at_places_differs_and_lags():
    q = run()
    for f in own("backlash_position"):
        y = observe(q, f(world([q]), stream("f"), 0).field(q, 6.0))[0] * q.sgn[:, 0]
        assert (y < 0).all() and y.min() < 2 * y.max()


def test_wind_up_ends_on_either_side():
    q = ballbar(stream("b"), MILL, 0.0, "r2", force={"plane": [0, 1], "senses": [1, -1]})
    w = world([q])
    for f in own("windup"):
        y = f(w, stream("f"), 0).field(q, 5.0).tool[:, 0]
        far = (q.since[:, 0] > 10) & (q.run > 1)
        assert np.allclose(y[far], -5.0 * q.sgn[far, 0], atol=0.1)


def test_loop_of_the_second_order_lags_by_twice_its_damping_over_its_frequency():
    q = jog("scale", rows=3000, rate=1000)
    q.vel = np.where(q.t[:, None] > 0.2, 1.0, 0.0) * np.ones(3)
    y = loop_error(q, 0, 200.0, 0.7)
    assert y[-1] == pytest.approx(1.0, abs=1e-6) and 1.05 < y.max() < 1.3


def test_lags_and_delays_fall_behind():
    q = jog("scale", rows=3000, rate=50)
    w, a = world([q]), q.moving[0]
    v = q.vel[:, a]
    k = np.abs(v) > 0.98 * np.abs(v).max()
    for effect in ("servo_lag", "delay"):
        for f in own(effect):
            s = f(w, stream("f"), a)
            y = observe(q, s.field(q, 12.0))[q.axes.index(a)]
            assert np.median(y[k] / v[k]) == pytest.approx(-12.0, abs=0.6), effect


def test_mismatch_is_the_difference_of_two_lags():
    q = ballbar(stream("b"), MILL, 0.0, "r2", force={"plane": [0, 1], "senses": [1, -1]})
    for f in own("servo_mismatch"):
        for k in range(4):
            s = f(world([q]), stream("f", k), 0)
            v = s.field(q, 2.0).tool / np.where(np.abs(q.vel) > 1, q.vel, np.nan)
            lag = np.nan_to_num(np.nanmedian(-v[:, :2], axis=0))
            assert lag[1] - lag[0] == pytest.approx(s.params(2.0)["delta_tau_ms"], abs=1e-6)


def test_spikes_point_back_and_are_gone():
    q = ballbar(stream("b"), MILL, 0.0, "r2", force={"plane": [0, 1], "feed": 1000.0})
    for f in own("reversal_spike"):
        y = f(world([q]), stream("f"), 0).field(q, 5.0).tool[:, 0] * q.sgn[:, 0]
        assert y.max() < 1e-9 and np.abs(y[(q.revt[:, 0] > 2) & (q.since[:, 0] > 1)]).max() < 0.1


def test_slides_stick_at_low_speed_alone():
    q = jog("scale", rows=3000, rate=50, feed=4000.0)
    a = q.moving[0]
    for f in own("stick_slip"):
        y = f(world([q]), stream("f"), a).field(q, 5.0).tool[:, a]
        assert not y[np.abs(q.vel[:, a]) > 9].any() and not y[np.abs(q.vel[:, a]) < 1e-4].any()
    assert slow(q, a, 9.0).any()


def test_steps_are_lost_once_and_stay():
    q = run(runs=4)
    for f in own("step_loss"):
        s = f(world([q]), stream("f"), 0)
        y, p = observe(q, s.field(q, 5.0))[0], s.params(5.0)
        assert (y[q.t < p["t_s"]] == 0).all() and np.allclose(y[q.t > p["t_s"]], p["jump_um"])
        assert abs(p["jump_um"]) == 5.0 and (y == 0).any()


def test_index_of_air():
    """Birch and Downs: 1 um per m for each K and 3.7 hPa near 20 C, the rule of thumb within 15 %;
    Estler's dead path is dead length times the change."""
    w = world([run(laser=True)])
    w.pressure, w.air = np.zeros(3), np.array([-1.0, 0.0, 1.0])
    n = birch_downs(w)
    assert n[1] == pytest.approx(0, abs=1e-12)
    assert (n[0] - n[2]) / 2 == pytest.approx(0.93e-3, rel=0.02)
    assert np.allclose(rule_of_thumb(w), [1e-3, 0, -1e-3])
    w.pressure, w.air = np.array([0.0, 10.0]), np.zeros(2)
    assert np.diff(birch_downs(w))[0] == pytest.approx(2.68e-3, rel=0.02)


def test_a_new_tool_is_as_new():
    for k in range(200):
        q = features(stream("wear", k), MILL, 0.0, "r4")
        if q.meta["part"].max() >= 6 and 3 < q.meta["change"] <= q.meta["part"].max():
            break
    s, part = cut(q), q.meta["part"]
    assert s[part == 1].max() == s[part == q.meta["change"]].max() == pytest.approx(1 / 16)
    on = q.meta["radial"] != 0
    for f in own("tool_wear"):
        y = f(world([q]), stream("f"), 0).field(q, 10.0).reading
        y = (y[on] / q.meta["radial"][on])[np.argsort(s[on], kind="stable")]
        assert y[0] < 0 and (np.diff(y) <= 1e-9).all() and y[-1] < y[0]


def test_periods_are_what_the_truth_says():
    q, moved = run(n=200), run(n=200)
    w = world([q])
    for f in own("cyclic"):
        s = f(w, stream("f"), 0)
        p = s.params(5.0)["period_mm"]
        moved.pos = q.pos + np.array([p, 0, 0])
        one = observe(q, s.field(q, 5.0))[0]
        assert np.allclose(observe(moved, s.field(moved, 5.0))[0], one, atol=1e-6)
        assert np.ptp(one) > 9.0


def test_forms_reach_their_size():
    recs = [run(), jog(rate=100), files()[3], run(n=8, runs=5, gap=7200.0), jog("scale", rate=50)]
    w, missed = world(recs), set()
    for effect in EFFECTS:
        for k in range(30):
            size = 2.0 if effect in ("laser_air", "dead_path") else 6.0
            h = draw_effect(stream("h", effect, k), w, recs, effect, size)
            if h:
                assert h.family == "apart" and h.peak == pytest.approx(size, rel=0.45)
                break
        else:
            missed.add(effect)
    assert not missed


def test_crabbing_turns_round_with_the_direction():
    m = draw_machine(stream("mill"), kind="mill")
    _, recs, _, _ = experiment(stream("crab"), "straightness", False)
    s = next(
        s
        for k in range(60)
        if (
            s := apart_aliens.crabbing(
                draw_world(stream("w"), m, recs, "apart", {}), stream("c", k), recs[0].meta["along"]
            )
        )
        is not None
    )
    q, ax = recs[0], recs[0].meta["along"]
    y, x = s.field(q, 4.0).tool @ q.meta["sensitive"], np.round(q.pos[:, ax], 3)
    for place in np.unique(x):
        both = [y[(x == place) & (q.sgn[:, ax] == d)] for d in (1, -1)]
        assert both[0].mean() == pytest.approx(-both[1].mean(), abs=1e-9)


def test_a_trial_of_the_seventh_family(tmp_path):
    truth, details = strangers_trial.made(FREEZE, {"alien": 1}, tmp_path / "cases", 1, "apart")
    assert [d["family"] for d in details.values()] == ["apart"]
    ((case, entries),) = truth.items()
    assert make(details[case]["seed"], "alien", 0, "apart").truth == entries
    assert all(re.fullmatch(r"alien:apart-\d+", t["effect"]) for t in entries)
