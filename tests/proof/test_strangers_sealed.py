"""The fourth family of kinds. Do not read while working on the judged tool."""

from __future__ import annotations

import argparse
import itertools
import re
from collections import Counter

import numpy as np
import pytest
from scipy.signal import lfilter

from proof import strangers_trial
from proof.strangers import TIERS, make
from proof.strangers.base import observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import targets
from proof.strangers.forms_motion import maxwell
from proof.strangers.hidden import draw_effect
from proof.strangers.machines import draw_machine
from proof.strangers.noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, Noise
from proof.strangers.plans import EFFECTS
from proof.strangers.registry import FORMS
from proof.strangers.sealed_designs import (
    CHAINS,
    OTHERS,
    at_rest,
    circle,
    in_motion,
    standing,
    union_jack,
    williams,
)
from proof.strangers.sealed_motion import hyperbola
from proof.strangers.sealed_place import on_two_supports, pair_gives
from proof.strangers.sealed_time import edlen, two_rates
from proof.strangers.world import draw_world
from tests.proof.strangers_runs import MILL, files, jog, run

NUMBERED = re.compile(r"(alien:)?sealed-\d+")
FAST, SLOW = (sorted(k for k in kinds if "sealed" in k) for kinds in (MORE_FAST, MORE_SLOW))
FREEZE = "2" * 40
QUICK = {  # cases of few rows
    "null": [0, 9],
    "adversarial": [0, 3],
    "single": [11, 33],
    "pair": [0, 7],
    "triple": [1, 12],
    "masked": [0, 2],
    "withheld": [3, 11],
    "alien": [5, 13],
    "blind": [3, 5],
}


def world(recs):
    return draw_world(stream("w"), MILL, recs, "sealed", {"load": True, "spindle": True})


def own(effect):
    return [f for _, family, f in FORMS[effect] if family == "sealed"]


def test_every_effect_has_a_sealed_form_and_all_bear_numbers():
    for effect in EFFECTS:
        assert own(effect), effect
    for forms in FORMS.values():
        assert all(NUMBERED.fullmatch(n) for n, family, _ in forms if family == "sealed")
    assert sum(n.startswith("alien:sealed-") for n in FORMS) == 6
    assert set(LATER["sealed"]["all"]) == set(FAST + SLOW) and len(FAST + SLOW) >= 8


@pytest.mark.parametrize("tier", TIERS)
def test_cases(tier):
    for k in QUICK[tier]:
        c = make("test", tier, k, "sealed")
        check_case(c, tier)
        drawn = {s["kind"] for f in c.details["noise"].values() for s in f["signal"]}
        drawn |= {t["form"] for t in c.truth}
        assert not any("fresh" in k for k in drawn)
        assert any(NUMBERED.fullmatch(k) for k in drawn)
        assert tier == "blind" or all(t["visible"] for t in c.truth)


@pytest.mark.parametrize("kind", FAST)
def test_fast_kinds_have_their_variance(kind):
    for rec in files():
        drawn = [MORE_FAST[kind](stream("n", kind, k), 0.4, rec) for k in range(25)]
        if len(drawn[0].white_a) > 1:  # whitened, it is white
            x = [lfilter(d.white_a, d.white_b, d.values)[60:] / np.sqrt(d.var[60:]) for d in drawn]
            low = np.mean([np.mean(v[1:] * v[:-1]) for v in x if len(v) > 1500] or [0.0])
            assert abs(low) < 0.02
        else:
            x = [d.values / np.sqrt(d.var) for d in drawn]
        x = np.concatenate(x)
        if len(x):
            assert np.mean(x**2) == pytest.approx(1.0, abs=0.1), rec.kind
            assert abs(np.mean(x)) < 0.06


@pytest.mark.parametrize("kind", SLOW)
def test_slow_kinds_have_their_covariance(kind):
    """Differences of two readings, each over what the oracle is told of it, have unit variance."""
    for rec in files()[:2]:
        n = rec.n_obs
        at = [int(n * x) for x in (0.02, 0.1, 0.35, 0.4, 0.8, 0.99)]
        ratio = []
        for k in range(100):
            x = Noise(np.zeros(n), np.zeros(n), [])
            MORE_SLOW[kind](stream("s", kind, k), x, 0.7, rec, None, 0)
            cov = sum((np.outer(c[at], c[at]) for c in x.columns), np.zeros((len(at), len(at))))
            for kernel, t in x.kernels:
                cov = cov + kernel(t[at], t[at])
            for i, j in itertools.combinations(range(len(at)), 2):
                var = cov[i, i] + cov[j, j] - 2 * cov[i, j]
                if var > 1e-6:
                    ratio.append((x.values[at[i]] - x.values[at[j]]) ** 2 / var)
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.3), rec.kind


def test_what_is_lost_leaves_both_ends():
    for rec in files()[:3]:
        gone = [LOSSES["sealed"](stream("g", k), rec) for k in range(60)]
        gone = [g for g in gone if g is not None]
        assert 5 < len(gone) < 35
        assert all(0 < g.mean() < 0.45 and not (g[0] or g[-1]) for g in gone)


def test_beam_on_two_supports():
    """Held at its ends: 5/384 down in the middle, 19/2048 at a quarter (Roark). On Airy's points,
    0.2113 from the ends, its ends are level; on points at 0.2232 ends and middle are as high."""
    assert on_two_supports(np.array([0.5, 0.25]), 0.0) == pytest.approx(
        [-5 / 384, -19 / 2048], rel=1e-9
    )
    ends = on_two_supports(np.array([0.0, 0.01, 0.99, 1.0]), (1 - 1 / 3**0.5) / 2)
    assert ends[0] == pytest.approx(ends[1], abs=1e-6) and ends[3] == pytest.approx(ends[0])
    level = on_two_supports(np.array([0.0, 0.5]), 0.2232)
    assert level[0] == pytest.approx(level[1], rel=0.02)


def test_preloaded_pair_lets_go_at_2_83_times_its_preload():
    """Small loads give 1 um/N by definition; at 2^1.5 preloads one contact is free and the other
    has gone once more by what both were pressed together, 3 preloads in this unit."""
    n = np.array([0.01, -0.01, 2**1.5 * 50.0, -(2**1.5) * 50.0])
    want = [0.01, -0.01, 150.0, -150.0]
    assert pair_gives(n, 50.0) == pytest.approx(want, rel=1e-4)


def test_index_of_air():
    """1 K warmer: 271.8 (1 - 1.07322 / 1.076881) = 0.924 less; 10 hPa more: 2718 / 1013.25."""
    got = edlen(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 10.0]))
    assert got == pytest.approx([0.0, -0.9240, 2.6825], abs=5e-4)


def test_two_rates_settle_and_cool():
    y = two_rates(np.r_[np.ones(300), np.zeros(300)], 1.0, 50.0, 150.0)
    assert y[49] == pytest.approx(1 - np.exp(-1), rel=1e-6)
    assert y[299 + 150] == pytest.approx(y[299] * np.exp(-1), rel=1e-6)


def test_masing_branch_is_the_virgin_curve_doubled():
    """Out by 4 reaches of half: 0.8; back by twice x from there falls by twice the curve at x."""
    reach, share = hyperbola(0.1, 400)
    way = np.r_[np.linspace(0, 0.4, 400), np.linspace(0.4, -0.4, 800)]
    y = maxwell(way, reach, share)
    assert np.interp([0.1, 0.4], way[:400], y[:400]) == pytest.approx([0.5, 0.8], abs=0.03)
    assert y[399] - y[-1] == pytest.approx(2 * y[399], abs=1e-9)


def test_a_latin_square_balances_what_came_before():
    """Four targets: rows 0 1 3 2, its mirror, 1 2 0 3 ...: in eight runs each ordered pair stands
    together twice."""
    p = np.arange(4.0)
    rows = [[int(x) for x, run in williams(p, k, 0.5) if run] for k in range(1, 9)]
    assert rows[:3] == [[0, 1, 3, 2], [2, 3, 1, 0], [1, 2, 0, 3]]
    pairs = Counter(pair for row in rows for pair in itertools.pairwise(row))
    assert len(pairs) == 12 and set(pairs.values()) == {2}


def test_designs_stay_within_their_machines():
    """In travel, time runs on, traces start and end their moves smoothly."""
    made = []
    for kind in OTHERS:
        m = draw_machine(stream(kind), kind=kind)
        assert m.chain in CHAINS[kind][1]
        made += [(m, circle(stream("c", kind), m, 5.0, "r1"))]
        made += [(m, standing(stream("s", kind), m, 5.0, "r1"))]
        made += [(m, in_motion(stream("m", kind), m, 5.0, "r1", "tool"))]
        if len(m.axes) == 3:
            made += [(m, union_jack(stream("u", kind), m, 5.0, "r1"))]
        for k in range(3):
            force = at_rest(stream("f", kind, k), m, "displacement", m.axes[0])
            made += [(m, targets(stream("t", k), m, m.axes[0], 5.0, "r1", force=force))]
    for m, q in made:
        assert (np.diff(q.t) >= 0).all() and q.t[0] >= 5.0
        assert np.isfinite(q.pos).all() and (q.sgn[:, m.axes] != 0).all() | (q.kind != "targets")
        for a in m.axes:
            assert q.pos[:, a].min() >= m.travel[a][0] and q.pos[:, a].max() <= m.travel[a][1]
        if q.kind == "trace":
            assert np.abs(np.diff(q.pos, axis=0)).max() * q.meta["rate"] < 200  # mm/s
    assert len(made) == 40


def test_lost_motion_lags_by_half_its_size():
    q = run()
    w, far = world([q]), q.since[:, 0] > 1.0
    for f in own("backlash"):
        s = f(w, stream("f"), 0)
        got = observe(q, s.field(q, 6.0))[0][far]
        assert np.allclose(got, (-3.0 * q.sgn[:, 0])[far]) and s.params(6.0) == {"size_um": 6.0}


def test_lags_and_delays_fall_behind():
    q = jog("scale", rows=3000, rate=50)
    w, a = world([q]), q.moving[0]
    v = q.vel[:, a]
    k = np.abs(v) > 0.98 * np.abs(v).max()
    for effect in ("servo_lag", "delay"):
        for f in own(effect):
            s = f(w, stream("f"), a)
            if s.params(2.0):
                y = observe(q, s.field(q, 2.0))[q.axes.index(a)]
                assert np.median(y[k] / v[k]) == pytest.approx(-2.0, abs=0.1), effect


def test_a_clock_has_lost_its_samples_by_the_end():
    q = jog("scale")
    (f,) = own("clock_skew")
    y = f(world([q]), stream("f"), 0).field(q, 3.0).reading
    late = q.t > q.t[0] + 0.985 * np.ptp(q.t)
    assert np.allclose(y[late], -3.0 * q.vel[late]) and np.allclose(y[:20], 0.0)


def test_periods_are_what_the_truth_says():
    """A joint's error comes twice a turn, a belt's whole pattern once a turn of the pulley."""
    q = run(n=200)
    w = world([q])
    for f in own("cyclic"):
        s = f(w, stream("f"), 0)
        p = s.params(5.0)["period_mm"]
        one = observe(q, s.field(q, 5.0))[0]
        moved = run(n=200)
        moved.pos = moved.pos + np.array([p, 0, 0])
        assert np.allclose(observe(moved, s.field(moved, 5.0))[0], one, atol=1e-6)


def test_sealed_forms_reach_their_size():
    recs = [*files(), run(n=8, runs=5, gap=7200.0), jog("scale")]
    w, missed = world(recs), set()
    for effect in EFFECTS:
        for k in range(30):
            h = draw_effect(stream("h", effect, k), w, recs, effect, 6.0)
            if h and h.family == "sealed":
                assert h.peak == pytest.approx(6.0, rel=0.45)
                break
        else:
            missed.add(effect)
    assert not missed


def test_a_trial_of_the_fourth_family(tmp_path):
    truth, details = strangers_trial.made(FREEZE, {"alien": 1}, tmp_path / "cases", 1, "sealed")
    assert [d["family"] for d in details.values()] == ["sealed"]
    ((case, entries),) = truth.items()
    assert make(details[case]["seed"], "alien", 0, "sealed").truth == entries
    assert all(re.fullmatch(r"alien:sealed-\d+", t["effect"]) for t in entries)


def test_a_table_of_tiers():
    assert strangers_trial.counts("null=60,pair=10") == {"null": 60, "pair": 10}
    for wrong in ("nulls=3", "null", "null=0", "null=x"):
        with pytest.raises(argparse.ArgumentTypeError, match="tiers are null, adversarial"):
            strangers_trial.counts(wrong)
