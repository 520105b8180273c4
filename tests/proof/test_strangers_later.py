"""The sixth family of kinds. Do not read while working on the judged tool."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from scipy.signal import lfilter

from proof import strangers_trial
from proof.strangers import TIERS, later_aliens, make
from proof.strangers.base import observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import ballbar, features
from proof.strangers.hidden import draw_effect
from proof.strangers.later_designs import ALIENS, PLANS, experiment
from proof.strangers.later_motion import dahl_power
from proof.strangers.later_place import two_spans
from proof.strangers.later_servo import overshooting
from proof.strangers.later_time import dead_band
from proof.strangers.noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, Noise
from proof.strangers.plans import EFFECTS
from proof.strangers.registry import FORMS, allowed
from proof.strangers.world import draw_world
from tests.proof.strangers_runs import MILL, files, jog, run

NUMBERED = re.compile(r"(alien:)?later-\d+")
FRAME = {"quant", "outlier", "wide_zero", "zero_by_run"}  # what rounds, slips and sets up
FAST, SLOW = (sorted(k for k in kinds if "later" in k) for kinds in (MORE_FAST, MORE_SLOW))
FREEZE = "3" * 40


def world(recs):
    return draw_world(stream("w"), MILL, recs, "later", {"load": True, "spindle": True})


def own(effect):
    return [f for _, family, f in FORMS[effect] if family == "later"]


def test_every_effect_has_a_form_and_all_bear_numbers():
    for effect in EFFECTS:
        assert own(effect), effect
        assert {family for _, family, _ in allowed(effect, "later")} == {"later"}
    for forms in FORMS.values():
        assert all(NUMBERED.fullmatch(n) for n, family, _ in forms if family == "later")
    assert sum(n.startswith("alien:later-") for n in FORMS) == 8
    assert set(LATER["later"]["all"]) == set(FAST + SLOW) and len(FAST + SLOW) == 10
    assert set(PLANS) == set(EFFECTS)


@pytest.mark.parametrize("tier", TIERS)
def test_cases_draw_from_their_own_family_alone(tier):
    for k in (0, 1):
        c = make("test", tier, k, "later")
        check_case(c, tier)
        assert k or make("test", tier, k, "later") == c
        drawn = {s["kind"] for f in c.details["noise"].values() for s in f["signal"]}
        drawn |= {t["form"] for t in c.truth}
        assert all(NUMBERED.fullmatch(k) for k in drawn - FRAME)
        assert tier == "blind" or all(t["visible"] for t in c.truth)
        if tier in ("single", "masked", "pair", "triple"):
            assert all(c.details["plan"] in PLANS[t["effect"]] for t in c.truth)


@pytest.mark.parametrize("kind", FAST)
def test_fast_kinds_have_their_variance(kind):
    for rec in files():
        drawn = [MORE_FAST[kind](stream("n", kind, k), 0.4, rec) for k in range(25)]
        if len(drawn[0].white_a) > 1:  # whitened, it is white
            x = [lfilter(d.white_a, d.white_b, d.values)[60:] / np.sqrt(d.var[60:]) for d in drawn]
            low = np.mean([np.mean(v[1:] * v[:-1]) for v in x if len(v) > 1500] or [0.0])
            assert abs(low) < 0.02
            if rec.n_obs > 1500:  # and has the size that was asked for
                assert np.mean([d.values.std() for d in drawn]) == pytest.approx(0.4, rel=0.1)
        else:
            var = [d.var + sum(c**2 for c in d.columns) for d in drawn]
            x = [d.values / np.sqrt(v) for d, v in zip(drawn, var, strict=True)]
            assert np.mean([v.mean() for v in var]) == pytest.approx(0.16, rel=0.01)
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
                if var > 1e-6:
                    ratio.append((x.values[at[i]] - x.values[at[j]]) ** 2 / var)
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.3), rec.kind


def test_a_closed_drift_is_nothing_at_the_ends_of_a_run():
    q = run(runs=3)
    x = Noise(np.zeros(q.n_obs), np.zeros(q.n_obs), [])
    MORE_SLOW["later-9"](stream("s"), x, 0.7, q, None, 0)
    for k in (1, 2, 3):
        v = x.values[q.run == k]
        assert v[0] == 0 and v[-1] == pytest.approx(0, abs=1e-9) and np.ptp(v) > 0.1


def test_places_in_the_way_are_few_and_never_the_ends():
    q = run(n=40)
    gone = [LOSSES["later"](stream("g", k), q) for k in range(100)]
    gone = [g for g in gone if g is not None]
    assert 5 < len(gone) < 35
    assert all(1 <= g.sum() <= 12 and not (g[0] or g[-1]) for g in gone)
    assert LOSSES["later"](stream("g", 1), jog()) is None


def test_experiments_are_what_people_record():
    """One to six files one after another within the travels; both directions, few runs, uneven
    targets; days between the files of a plan of days; work and rest in a warm-up."""
    for suspect in [*EFFECTS, *sorted(set(ALIENS))]:
        for k in range(3):
            m, recs, _, plan = experiment(stream("x", suspect, k), suspect, False)
            assert 1 <= len(recs) <= 6
            assert all(b.t[0] > a.t[-1] for a, b in itertools.pairwise(recs))
            for q in recs:
                assert np.isfinite(q.pos).all()
                for a in m.axes:
                    lo, hi = m.travel[a]
                    assert q.pos[:, a].min() >= lo and q.pos[:, a].max() <= hi, plan
                if q.kind == "targets":
                    assert (q.sgn[:, m.axes] != 0).all()
                    assert q.run.max() <= 5 or plan in (
                        "step_and_dwell",
                        "warm_spindle",
                        "two_days",
                    )
                if q.kind == "trace":
                    assert q.t[-1] - q.t[0] > 7 and np.abs(q.vel).max() * 60 < 1.3 * m.vmax
            if plan == "two_days":
                assert recs[1].t[0] - recs[0].t[-1] > 60000
            if plan == "step_and_dwell":
                (q, *_) = recs
                assert q.activity and max(x[0] for x in q.activity) < q.t[0] + 0.76 * np.ptp(q.t)


def test_reversal_values_lag_by_half_their_size():
    q = run()
    w = world([q])
    for f in own("backlash"):
        s = f(w, stream("f"), 0)
        size = s.params(6.0)["size_um"]
        far = q.since[:, 0] > 0.05
        y = observe(q, s.field(q, 6.0))[0]
        assert np.allclose(y[far], -0.5 * size * q.sgn[far, 0]) and 4.5 < size <= 6.0


def test_dahls_exponent():
    """du/dx = -u^i / s0 from a standstill (u = 1): 1 / (1 + x) for i = 2, (1 - x / 2)^2 for 0.5."""
    x = np.linspace(0, 4, 400)
    assert np.allclose(dahl_power(x, 1.0, 2.0), 1 - 1 / (1 + x), atol=1e-6)
    assert np.allclose(dahl_power(x, 1.0, 0.5), 1 - np.maximum(1 - x / 2, 0) ** 2, atol=1e-6)
    there = dahl_power(np.r_[x, x[::-1]], 0.05, 1.5)
    assert there[399] > 0.99 and there[-1] < -0.99


def test_two_spans():
    """Nothing on the supports, 23 l^3 / 1536 in the middle of one of two spans l (tables of
    continuous beams: 0.015 P l^3 / E I), the same in both if they are alike."""
    c = 0.5
    assert two_spans(np.array([0.0, 0.5, 1.0]), c) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    simple, top = (0.25 * 0.25) ** 2 / 1.5, two_spans(np.linspace(0, 1, 1001), c).max()
    assert top == pytest.approx(1.0, abs=0.01)
    x, turn = 0.25, 0.25 * (0.25 - 0.0625) / 3
    middle = simple - 3 * turn**2
    assert middle == pytest.approx(23 / 1536 * 0.5**3, rel=1e-6) and x < c
    assert two_spans(np.array([0.3]), c) == pytest.approx(two_spans(np.array([0.7]), c))


def test_symmetrical_optimum_shoots_over_by_two_fifths():
    q = jog("scale", rows=3000, rate=1000)
    q.vel = np.where(q.t[:, None] > 0.2, 1.0, 0.0) * np.ones(3)
    y = overshooting(q, 0, 0.01)
    assert y.max() == pytest.approx(1.434, abs=0.01) and y[-1] == pytest.approx(1.0, abs=1e-3)


def test_lags_and_delays_fall_behind():
    q = jog("scale", rows=3000, rate=50)
    w, a = world([q]), q.moving[0]
    v = q.vel[:, a]
    k = np.abs(v) > 0.98 * np.abs(v).max()
    for effect in ("servo_lag", "delay"):
        for f in own(effect):
            s = f(w, stream("f"), a)
            y = observe(q, s.field(q, 2.0))[q.axes.index(a)]
            both = [np.median(y[k & (v * d > 0)] / v[k & (v * d > 0)]) for d in (1, -1)]
            assert np.mean(both) == pytest.approx(-2.0, abs=0.1), effect


def test_steps_are_lost_once_and_stay():
    q = run(runs=4)
    for f in own("step_loss"):
        s = f(world([q]), stream("f"), 0)
        y, p = observe(q, s.field(q, 5.0))[0], s.params(5.0)
        assert abs(p["jump_um"]) == 5.0 and (y[q.t < p["t_s"]] == 0).all()
        assert y[-1] == pytest.approx(p["jump_um"], rel=0.2)
        assert np.abs(y[q.t > p["t_s"]]).min() > 3.5


def test_what_is_shown_follows_beyond_its_band():
    x = np.array([0.0, 0.4, 0.6, 0.9, 1.2, 0.7, 0.5])
    assert list(dead_band(x, 0.5)) == [0.0, 0.0, 0.6, 0.6, 1.2, 1.2, 0.5]


def test_a_wheel_is_as_new_after_it_was_dressed():
    f = own("tool_wear")[0]
    for k in range(200):
        q = features(stream("wear", k), MILL, 0.0, "r4")
        if q.meta["part"].max() >= 7 and q.meta["change"] > 7 and (q.meta["radial"] > 0).any():
            break
    y = -f(world([q]), stream("f"), 0).field(q, 10.0).reading
    on = q.meta["radial"] != 0
    y, part = (y[on] / q.meta["radial"][on]), q.meta["part"][on]
    wear = [float(y[part == k].mean()) for k in range(1, 8)]
    assert min(wear) == pytest.approx(wear[0]) and wear.count(wear[0]) >= 2 and wear[1] > wear[0]


def test_periods_are_what_the_truth_says():
    q = run(n=200)
    w = world([q])
    s = own("cyclic")[0](w, stream("f"), 0)
    p = s.params(5.0)["period_mm"]
    moved = run(n=200)
    moved.pos = moved.pos + np.array([p, 0, 0])
    one = observe(q, s.field(q, 5.0))[0]
    assert np.allclose(observe(moved, s.field(moved, 5.0))[0], one, atol=1e-6)
    assert np.ptp(one) == pytest.approx(10.0, rel=0.05)


def test_forms_reach_their_size():
    recs = [run(), jog(rate=100), files()[3], run(n=8, runs=5, gap=7200.0), jog("scale", rate=50)]
    w, missed = world(recs), set()
    for effect in EFFECTS:
        for k in range(30):
            size = 2.0 if effect == "laser_air" else 6.0
            h = draw_effect(stream("h", effect, k), w, recs, effect, size)
            if h:
                assert h.family == "later" and h.peak == pytest.approx(size, rel=0.45)
                break
        else:
            missed.add(effect)
    assert not missed


def test_pads_multiply():
    """One axis alone turns the sign, both together leave it."""
    q = ballbar(stream("b"), MILL, 0.0, "r2", force={"plane": [0, 1], "senses": [1, -1]})
    s = next(
        s
        for k in range(50)
        if (s := later_aliens.diagonal_pads(world([q]), stream("p", k), 0)) is not None
    )
    far = (q.since[:, :2] > 5).all(1)
    y, unit = s.field(q, 4.0).tool, q.sgn[:, 0] * q.sgn[:, 1]
    d = y[far] / unit[far][:, None]
    assert np.allclose(d, d[0], atol=0.02) and np.linalg.norm(d[0]) == pytest.approx(4.0, abs=0.05)


def test_a_trial_of_the_sixth_family(tmp_path):
    truth, details = strangers_trial.made(FREEZE, {"alien": 1}, tmp_path / "cases", 1, "later")
    assert [d["family"] for d in details.values()] == ["later"]
    ((case, entries),) = truth.items()
    assert make(details[case]["seed"], "alien", 0, "later").truth == entries
    assert all(re.fullmatch(r"alien:later-\d+", t["effect"]) for t in entries)
