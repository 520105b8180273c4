"""The fifth family of kinds. Do not read while working on the judged tool."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from scipy.signal import lfilter

from proof import strangers_trial
from proof.strangers import TIERS, make
from proof.strangers.base import observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import ballbar, features
from proof.strangers.forms_motion import maxwell
from proof.strangers.hidden import draw_effect
from proof.strangers.machines import draw_machine
from proof.strangers.noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, Noise
from proof.strangers.plans import EFFECTS, PLANS
from proof.strangers.registry import FORMS
from proof.strangers.unseen_designs import campaign, machine_kind
from proof.strangers.unseen_motion import power_law
from proof.strangers.unseen_place import propped
from proof.strangers.unseen_servo import loop
from proof.strangers.world import draw_world, thermometer
from tests.proof.strangers_runs import MILL, files, jog, run

NUMBERED = re.compile(r"(alien:)?unseen-\d+")
FAST, SLOW = (sorted(k for k in kinds if "unseen" in k) for kinds in (MORE_FAST, MORE_SLOW))
FREEZE = "2" * 40


def world(recs):
    return draw_world(stream("w"), MILL, recs, "unseen", {"load": True, "spindle": True})


def own(effect):
    return [f for _, family, f in FORMS[effect] if family == "unseen"]


def test_every_effect_has_an_unseen_form_and_all_bear_numbers():
    for effect in EFFECTS:
        assert own(effect), effect
    for forms in FORMS.values():
        assert all(NUMBERED.fullmatch(n) for n, family, _ in forms if family == "unseen")
    assert sum(n.startswith("alien:unseen-") for n in FORMS) == 6
    assert set(LATER["unseen"]["all"]) == set(FAST + SLOW) and len(FAST + SLOW) >= 8


@pytest.mark.parametrize("tier", TIERS)
def test_cases(tier):
    for k in (0, 1):
        c = make("test", tier, k, "unseen")
        check_case(c, tier)
        assert k or make("test", tier, k, "unseen") == c
        drawn = {s["kind"] for f in c.details["noise"].values() for s in f["signal"]}
        drawn |= {t["form"] for t in c.truth}
        assert not any("fresh" in k or "sealed" in k for k in drawn)
        assert any(NUMBERED.fullmatch(k) for k in drawn)
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
            rounded = [np.round(d.values / (d.quant or 1e-6)) * (d.quant or 1e-6) for d in drawn]
            x = [v / np.sqrt(d.var) for v, d in zip(rounded, drawn, strict=True)]
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
                g = kernel.trig[at] if hasattr(kernel, "trig") else np.ones(len(at))
                cov = cov + kernel(t[at], t[at]) * np.outer(g, g)
            for i, j in itertools.combinations(range(len(at)), 2):
                var = cov[i, i] + cov[j, j] - 2 * cov[i, j]
                if var > 1e-6:
                    ratio.append((x.values[at[i]] - x.values[at[j]]) ** 2 / var)
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.3), rec.kind


def test_missed_captures_are_few_and_never_the_ends():
    q = run(n=40)
    gone = [LOSSES["unseen"](stream("g", k), q) for k in range(100)]
    gone = [g for g in gone if g is not None]
    assert 8 < len(gone) < 35
    assert all(1 <= g.sum() <= 5 and not (g[0] or g[-1]) for g in gone)
    assert LOSSES["unseen"](stream("g", 1), jog()) is None


def test_thermometers_of_this_family_lag_more_often():
    t = np.linspace(0, 3600, 50)
    kinds = [thermometer(stream("k", k), t / 3600, t, "unseen")[1] for k in range(200)]
    assert 0.4 < np.mean([k["kind"] == "lag" for k in kinds]) < 0.6
    assert all(60 <= k["lag_s"] <= 1200 for k in kinds if k["kind"] == "lag")


def test_campaigns_are_what_a_metrologist_records():
    """One to six files one after another within the travels; circles in pairs of feeds, both
    senses, one radius; positioning in both directions, 3 to 5 runs of 10 to 40 targets."""
    count = 0
    for plan in sorted({p for plans in PLANS.values() for p in plans}):
        for k in range(8):
            r = stream("visit", plan, k)
            m = draw_machine(r, False, machine_kind(r, "x" if plan == "features" else None))
            recs = campaign(r, m, plan, 7.0)
            assert 1 <= len(recs) <= 6 and recs[0].t[0] >= 7.0
            assert all(b.t[0] > a.t[-1] for a, b in itertools.pairwise(recs))
            for q in recs:
                assert (
                    np.isfinite(q.pos).all() and (np.diff(q.t) >= 0).all() or q.kind == "features"
                )
                for a in m.axes:
                    lo, hi = m.travel[a]
                    assert q.pos[:, a].min() >= lo and q.pos[:, a].max() <= hi
                if q.kind == "targets":
                    assert (q.sgn[:, m.axes] != 0).all()
                if q.laser and q.meta["pattern"] == "iso" and plan != "long":
                    places = len(np.unique(q.pos, axis=0))
                    assert 10 <= places <= 40 and 3 <= q.run.max() <= 5
                    assert len(q.t) == 2 * places * q.run.max()
                if q.kind == "trace":
                    assert q.t[-1] - q.t[0] > 8 and q.meta["rate"] <= 200
                    assert np.abs(q.vel).max() * 60 < 1.3 * m.vmax
            bars = [q for q in recs if q.kind == "ballbar"]
            for a, b in zip(bars[::2], bars[1::2], strict=True):
                assert a.meta["plane"] == b.meta["plane"] and a.meta["feed"] < b.meta["feed"]
                assert a.meta["radius"] == b.meta["radius"] and set(a.meta["sense"]) == {1, -1}
            count += len(recs)
    assert count > 150


def test_reversal_values_lag_or_lead_by_half_their_size():
    q = run()
    w = world([q])
    lag, lead = (f(w, stream("f"), 0) for f in own("backlash"))
    assert np.allclose(observe(q, lag.field(q, 6.0))[0], -3.0 * q.sgn[:, 0])
    assert lag.params(6.0) == {"size_um": 6.0}
    assert np.allclose(observe(q, lead.field(q, 6.0))[0], 3.0 * q.sgn[:, 0])


def test_a_power_law_before_sliding():
    """(x / 0.2)^0.5: half of the force after a quarter of the way, all of it at 0.2 and beyond."""
    reach, share = power_law(0.2, 0.5, 400)
    assert share.sum() == pytest.approx(1.0)
    y = maxwell(np.linspace(0, 0.4, 801), reach, share)
    assert y[[100, 400, 800]] == pytest.approx([0.5, 1.0, 1.0], abs=0.01)


def test_propped_beam():
    """7/768 in the middle (Roark), nothing at its ends, more beyond the middle than before it."""
    assert propped(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 7 / 768, 0.0])
    assert propped(np.array([0.6]))[0] > propped(np.array([0.4]))[0]


def test_a_loop_on_a_circle_lags_and_draws_in():
    """First order, w tau = 0.1: behind by tau v / 1.01, and inwards by w tau of that."""
    q = ballbar(stream("b"), MILL, 0.0, "r2", force={"plane": [0, 1], "feed": 1200.0})
    w = 20.0 / q.meta["radius"]
    e = np.stack([-loop(q, a, 0.1 / w) for a in range(3)], 1) * 0.1 / w
    x, v = q.pos - q.meta["centre"], q.vel / 20.0
    assert (e * v).sum(1) == pytest.approx(-2.0 / w / 1.01, rel=1e-3)
    assert (e * x).sum(1) / q.meta["radius"] == pytest.approx(-0.2 / w / 1.01, rel=1e-3)


def test_lags_and_delays_fall_behind():
    q = jog("scale", rows=3000, rate=50)
    w, a = world([q]), q.moving[0]
    v = q.vel[:, a]
    k = np.abs(v) > 0.98 * np.abs(v).max()
    for effect in ("servo_lag", "delay"):
        for f in own(effect):
            s = f(w, stream("f"), a)
            y = observe(q, s.field(q, 2.0))[q.axes.index(a)]
            assert np.median(y[k] / v[k]) == pytest.approx(-2.0, abs=0.1), effect


def test_a_step_is_lost_at_a_reversal_and_stays():
    q = run()
    (f,) = own("step_loss")
    s = f(world([q]), stream("f"), 0)
    y, p = observe(q, s.field(q, 5.0))[0], s.params(5.0)
    assert abs(p["jump_um"]) == 5.0 and set(y) == {0.0, p["jump_um"]}
    before, after = q.sgn[y == 0, 0][-1], q.sgn[y != 0, 0][0]
    assert before == -after and (np.diff(y != 0) >= 0).all()


def test_angle_of_the_other_axis_is_the_same_angle():
    """On a circle both leans differ by a rotation only: the radial reading is the same but for the
    centre."""
    q = ballbar(stream("b"), MILL, 0.0, "r2", force={"plane": [0, 1], "senses": [1, -1]})
    w = world([q])
    open_form = next(f for n, _, f in FORMS["squareness"] if n == "lean")
    (f,) = own("squareness")
    got = []
    for make_one in (open_form, f):
        shapes = (make_one(w, stream("f", k), 0) for k in itertools.count())
        s = next(s for s in shapes if s.axis == "XY")
        y = observe(q, s.field(q, 50.0 * np.sign(s.params(1.0)["urad"])))[0]
        free = np.c_[np.ones(len(y)), q.meta["unit"][:, :2]]
        got.append(y - free @ np.linalg.lstsq(free, y, rcond=None)[0])
    assert np.allclose(got[0], got[1], atol=1e-6) and np.ptp(got[0]) > 1


def test_wear_goes_on_with_the_length_and_starts_anew_at_a_change():
    (f,) = own("tool_wear")
    for k in range(20):
        q = features(stream("wear", k), MILL, 0.0, "r4")
        if 3 < q.meta["change"] <= q.meta["part"].max():
            break
    y = -f(world([q]), stream("f"), 0).field(q, 10.0).reading
    rad, part = q.meta["radial"], q.meta["part"]
    wear = y[rad != 0] / rad[rad != 0]
    n = part[rad != 0]
    old = n < q.meta["change"]
    assert (np.diff(wear[old]) >= -1e-9).all() and (np.diff(wear[~old]) >= -1e-9).all()
    assert wear[~old][0] == pytest.approx(wear[old][0]) and wear[old][-1] > 2 * wear[old][0]


def test_periods_are_what_the_truth_says():
    q = run(n=200)
    w = world([q])
    f = own("cyclic")[0]
    s = f(w, stream("f"), 0)
    p = s.params(5.0)["period_mm"]
    moved = run(n=200)
    moved.pos = moved.pos + np.array([p, 0, 0])
    one = observe(q, s.field(q, 5.0))[0]
    assert np.allclose(observe(moved, s.field(moved, 5.0))[0], one, atol=1e-6)
    assert np.ptp(one) == pytest.approx(10.0, rel=0.05)


def test_unseen_forms_reach_their_size():
    recs = [*files(), run(n=8, runs=5, gap=7200.0), jog("scale")]
    w, missed = world(recs), set()
    for effect in EFFECTS:
        for k in range(30):
            h = draw_effect(stream("h", effect, k), w, recs, effect, 6.0)
            if h and h.family == "unseen":
                assert h.peak == pytest.approx(6.0, rel=0.45)
                break
        else:
            missed.add(effect)
    assert not missed


def test_a_trial_of_the_fifth_family(tmp_path):
    truth, details = strangers_trial.made(FREEZE, {"alien": 1}, tmp_path / "cases", 1, "unseen")
    assert [d["family"] for d in details.values()] == ["unseen"]
    ((case, entries),) = truth.items()
    assert make(details[case]["seed"], "alien", 0, "unseen").truth == entries
    assert all(re.fullmatch(r"alien:unseen-\d+", t["effect"]) for t in entries)
