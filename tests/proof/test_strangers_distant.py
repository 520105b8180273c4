"""The eighth family of kinds. Do not read while working on the judged tool."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from scipy.signal import lfilter

from proof import strangers_trial
from proof.strangers import TIERS, distant_aliens, make
from proof.strangers.base import observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import targets
from proof.strangers.distant_designs import ALIENS, PLANS, experiment
from proof.strangers.distant_motion import hyperbola
from proof.strangers.distant_paths import batch, route, sampled
from proof.strangers.distant_place import on_two_supports
from proof.strangers.distant_time import index
from proof.strangers.hidden import draw_effect
from proof.strangers.noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, Noise
from proof.strangers.plans import EFFECTS
from proof.strangers.registry import FORMS, allowed
from proof.strangers.world import draw_world
from tests.proof.strangers_runs import MILL, files, jog, run

NUMBERED = re.compile(r"(alien:)?distant-\d+")
FRAME = {"quant", "outlier", "wide_zero", "zero_by_run"}  # what rounds, slips and sets up
FAST, SLOW = (sorted(k for k in kinds if "distant" in k) for kinds in (MORE_FAST, MORE_SLOW))
FREEZE = "4" * 40


def world(recs):
    return draw_world(stream("w"), MILL, recs, "distant", {"load": True, "spindle": True})


def own(effect):
    return [f for _, family, f in FORMS[effect] if family == "distant"]


def log(kind="speeds", sees="scale", key=0):
    return sampled(MILL, *route(stream("log", kind, key), MILL, kind), sees, kind, True)(0.0, "r5")


def parts(key=0):
    return batch(stream("parts", key), MILL, 4)(0.0, "r4")


def test_every_effect_has_two_forms_and_all_bear_numbers():
    for effect in EFFECTS:
        assert len(own(effect)) >= 2, effect
        assert {family for _, family, _ in allowed(effect, "distant")} == {"distant"}
    for forms in FORMS.values():
        assert all(NUMBERED.fullmatch(n) for n, family, _ in forms if family == "distant")
    assert sum(n.startswith("alien:distant-") for n in FORMS) >= 10
    assert set(LATER["distant"]["all"]) == set(FAST + SLOW) and len(FAST + SLOW) >= 10
    assert set(PLANS) == set(EFFECTS)
    assert len({p for plans in PLANS.values() for p in plans}) >= 14


@pytest.mark.parametrize("tier", TIERS)
def test_cases_draw_from_their_own_family_alone(tier):
    for k in (0, 1):
        c = make("test", tier, k, "distant")
        check_case(c, tier)
        assert k or make("test", tier, k, "distant") == c
        drawn = {s["kind"] for f in c.details["noise"].values() for s in f["signal"]}
        drawn |= {t["form"] for t in c.truth}
        assert all(NUMBERED.fullmatch(k) for k in drawn - FRAME)
        assert tier == "blind" or all(t["visible"] for t in c.truth)
        if tier in ("single", "masked", "pair", "triple"):
            assert all(c.details["plan"] in PLANS[t["effect"]] for t in c.truth)


@pytest.mark.parametrize("kind", FAST)
def test_fast_kinds_have_their_variance(kind):
    for rec in files():
        drawn = [MORE_FAST[kind](stream("n", kind, k), 0.4, rec) for k in range(70)]
        if len(drawn[0].white_a) > 1:  # whitened, it is white
            x = [lfilter(d.white_a, d.white_b, d.values)[60:] / np.sqrt(d.var[60:]) for d in drawn]
            low = np.mean([np.mean(v[1:] * v[:-1]) for v in x if len(v) > 1500] or [0.0])
            assert abs(low) < 0.02
            if rec.n_obs > 1500:  # and has the size that was asked for
                assert np.mean([d.values.std() for d in drawn]) == pytest.approx(0.4, rel=0.1)
        else:
            x = [d.values / np.sqrt(d.var) for d in drawn]
            assert np.mean([d.var.mean() for d in drawn]) == pytest.approx(0.16, rel=0.01)
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


def test_lost_samples_are_few_and_never_the_ends():
    for q, most in ((run(n=40), 3), (jog(), 120)):
        gone = [LOSSES["distant"](stream("g", k), q) for k in range(150)]
        gone = [g for g in gone if g is not None]
        assert 5 < len(gone) < 45
        assert all(1 <= g.sum() <= most and not (g[0] or g[-1]) for g in gone)
    assert LOSSES["distant"](stream("g", 1), parts()) is None


def readings(c):
    return [
        sum(not x.startswith("#") for x in body.splitlines()) - 1
        for name, body in c.files.items()
        if not name.startswith("machine/")
    ]


def test_experiments_are_what_a_laboratory_records():
    """One to six files one after another within the travels, 12 readings or more in each; days
    between the files of a plan of days; work and rest in a warm-up."""
    for suspect in [*EFFECTS, *sorted(set(ALIENS))]:
        for k in range(3):
            m, recs, _, plan = experiment(stream("x", suspect, k), suspect, False)
            assert 1 <= len(recs) <= 6
            assert all(b.t[0] > a.t[-1] for a, b in itertools.pairwise(recs))
            for q in recs:
                assert np.isfinite(q.pos).all() and q.n_obs >= 12
                for a in m.axes:
                    lo, hi = m.travel[a]
                    assert q.pos[:, a].min() >= lo and q.pos[:, a].max() <= hi, plan
                if q.kind == "targets":
                    assert (q.sgn[:, m.axes] != 0).all()
                if q.kind == "trace":
                    assert q.t[-1] - q.t[0] > 7 and np.abs(q.vel).max() * 60 < 1.3 * m.vmax
            if plan == "days":
                assert recs[1].t[0] - recs[0].t[-1] > 60000
            if plan == "heat":
                (q, *_) = recs
                assert q.activity and max(x[0] for x in q.activity) < q.t[0] + 0.91 * np.ptp(q.t)
    assert min(readings(make("rows", "null", 0, "distant"))) >= 12


def test_what_tells_lags_apart_is_in_their_plans():
    """Two axes in motion for delays and lags; both senses for axes that lag unlike; two lines or an
    angle for arms; two set-ups or runs for a misaligned beam."""
    one = sampled(MILL, *route(stream("one"), MILL, "creep"), "scale", "creep", False)(0.0, "r1")
    assert len(one.moving) == 1
    for effect in ("delay", "clock_skew", "servo_lag", "viscous_friction"):
        for f in own(effect):
            assert f(world([one]), stream("f"), one.moving[0]) is None
            q = log()
            assert f(world([q]), stream("f"), q.moving[0]) is not None
    single = run(runs=1)
    for f in own("cosine"):
        assert f(world([single]), stream("f"), 0) is None
    assert own("abbe")[0](world([run()]), stream("f"), 0) is None


def test_reversal_values_have_their_size():
    q = run()
    w = world([q])
    for f in own("backlash"):
        s = f(w, stream("f"), 0)
        size = s.params(6.0)["size_um"]
        far = q.since[:, 0] > 0.1
        y = observe(q, s.field(q, 6.0))[0]
        assert abs(size) == 6.0
        assert np.allclose(y[far], -0.5 * size * q.sgn[far, 0], atol=1e-3)


def test_a_hyperbola_doubles_after_a_reversal():
    x = np.linspace(0, 1, 401)
    z = hyperbola(np.r_[x, x[::-1]], 0.1)
    assert np.allclose(z[:401], x / (0.1 + x))
    back = 1 - x[::-1]
    assert np.allclose(z[401:], z[400] - 2 * back / (0.2 + back))
    assert z.min() >= -1


def test_a_beam_on_two_supports():
    """Simply supported at its ends it is (s - 2 s^3 + s^4) 16 / 5 deep; at Bessel's points ends and
    middle hang alike within a few per cent (0.2232: least largest deflection)."""
    s = np.linspace(0, 1, 101)
    assert np.allclose(on_two_supports(s, 0.0), -(s - 2 * s**3 + s**4) * 3.2, atol=2e-3)
    y = on_two_supports(s, 0.2232)
    assert y[0] == pytest.approx(y[50], rel=0.05) and y.min() == pytest.approx(-1, abs=1e-3)


def test_index_of_air():
    assert index(1.0, 0.0) == pytest.approx(-0.93e-3) and index(0.0, 10.0) == pytest.approx(2.68e-3)


def test_lags_and_delays_fall_behind():
    q = log()
    w, a = world([q]), q.moving[0]
    v, acc = q.vel[:, a], q.acc[:, a]
    k = (np.abs(v) > 0.15 * np.abs(v).max()) & (np.abs(acc) < 1e-6)
    for effect in ("servo_lag", "delay"):
        for f in own(effect):
            y = observe(q, f(w, stream("f"), a).field(q, 2.0))[q.axes.index(a)]
            assert np.median(y[k] / v[k]) == pytest.approx(-2.0, abs=0.15), effect


def test_steps_are_lost_once_and_stay():
    q = run(runs=4)
    for f in own("step_loss"):
        s = f(world([q]), stream("f"), 0)
        y, p = observe(q, s.field(q, 5.0))[0], s.params(5.0)
        assert abs(p["jump_um"]) == 5.0 and y[0] == 0
        assert y[-1] == pytest.approx(p["jump_um"])
        assert ((np.abs(y) > 1e-9) & (np.abs(y) < 5 - 1e-9)).sum() <= 4


def test_wear_is_gone_at_a_change():
    for k in range(300):
        q = parts(k)
        change, part = q.meta["change"], q.meta["part"]
        if 3 < change <= part.max():
            break
    on, w = q.meta["radial"] != 0, world([q])
    for f in own("tool_wear"):
        y = -f(w, stream("f"), 0).field(q, 10.0).reading[on] / q.meta["radial"][on]
        mean = {int(p): y[part[on] == p].mean() for p in np.unique(part)}
        assert mean[2] > mean[1] > 0 and mean[change - 1] > mean[change]
        assert mean[change] == pytest.approx(mean[1])


def test_periods_are_what_the_truth_says():
    q, moved = run(n=200), run(n=200)
    w = world([q])
    for f in own("cyclic")[:2]:
        s = f(w, stream("f", 3), 0)
        p = s.params(5.0)["period_mm"] * (3 if f is own("cyclic")[0] else 1)
        moved.pos = q.pos + np.array([2 * p, 0, 0])
        one = observe(q, s.field(q, 5.0))[0]
        assert np.ptp(one) > 8 and s.params(5.0)["period_mm"] <= w.machine.lead[0]
        if f is not own("cyclic")[0]:
            assert np.allclose(observe(moved, s.field(moved, 5.0))[0], one, atol=1e-6)


def test_what_sinks_goes_down():
    """Sag is in Z on three axes: the tool goes down, or the table does and the tool goes up
    against it; nothing where Z is not read."""
    found = 0
    for ax, f in itertools.product((0, 1), own("sag")):
        force = {"n": 20, "runs": 2, "pattern": "iso", "across": 2}
        q = targets(stream("t"), MILL, ax, 0.0, "r1", "straightness", force=force)
        s = f(world([q]), stream("f"), ax)
        if s is not None:
            y = s.field(q, 5.0).tool * (-1.0 if ax in MILL.tool_side() else 1.0)
            assert (y[:, :2] == 0).all() and y[:, 2].min() >= -1e-9 and y[:, 2].max() > 0.5
            found += 1
        assert f(world([run()]), stream("f"), 0) is None
    assert found >= 1


def test_forms_reach_their_size():
    angle = targets(stream("a"), MILL, 0, 9e4, "r6", "angle", force={"n": 12, "runs": 2})
    side = {"n": 20, "runs": 2, "across": 2}
    recs = [
        run(),
        log("speeds", "tool"),
        files()[1],
        parts(),
        log("creep", "scale", 1),
        run(n=8, runs=5, gap=7200.0),
        targets(stream("t"), MILL, 0, 8e4, "r7", "straightness", force=side),
        angle,
    ]
    w, missed = world(recs), set()
    for effect in EFFECTS:
        for number, f in enumerate(own(effect)):
            for k in range(60):
                r = stream("h", effect, k)
                size = 0.5 if effect in ("laser_air", "dead_path") else 6.0  # of a mill in an hour
                h = draw_effect(r, w, recs, effect, size, kinds={f"distant-{number + 1}"})
                if h and h.form == f"distant-{number + 1}":
                    assert h.peak == pytest.approx(size, rel=0.45)
                    break
            else:
                missed.add((effect, f.__name__))
    assert not {e for e, _ in missed} & (set(EFFECTS) - {"abbe", "sag"}), missed
    assert len(missed) <= 4  # a mill has no ram or no cross rail, and perhaps no table of angles


def test_a_film_knows_no_sign():
    q = log("slants", "tool")
    a = q.moving[0]
    s = distant_aliens.floats_with_speed(world([q]), stream("f"), a)
    y = s.field(q, 4.0).tool
    to = int(np.argmax(np.abs(y).max(0)))
    assert to != a and y.min() >= 0 and y[np.abs(q.vel[:, a]) < 1e-9].max() == 0


def test_pallets_come_by_turns():
    q = parts()
    y = distant_aliens.two_pallets(world([q]), stream("f"), 0).field(q, 4.0).reading
    size = np.array([i[3] for i in q.meta["info"]])
    ratio = {int(p): y[q.meta["part"] == p] / size[q.meta["part"] == p] for p in (1, 2, 3, 4)}
    assert np.allclose(ratio[1].mean(), ratio[3]) and np.allclose(ratio[2].mean(), -ratio[1])


def test_a_trial_of_the_eighth_family(tmp_path):
    truth, details = strangers_trial.made(FREEZE, {"alien": 1}, tmp_path / "cases", 1, "distant")
    assert [d["family"] for d in details.values()] == ["distant"]
    ((case, entries),) = truth.items()
    assert make(details[case]["seed"], "alien", 0, "distant").truth == entries
    assert all(re.fullmatch(r"alien:distant-\d+", t["effect"]) for t in entries)
