"""The third family of kinds. Do not read while working on the judged tool."""

from __future__ import annotations

import hashlib
import json
import re
from functools import lru_cache

import numpy as np
import pytest
from scipy.signal import lfilter

from proof import strangers_trial
from proof.strangers import TIERS, make
from proof.strangers.base import observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import ballbar, features, targets
from proof.strangers.hidden import draw_effect
from proof.strangers.machines import draw_machine
from proof.strangers.motion import trace
from proof.strangers.noise import LATER, LOSSES, MORE_FAST, MORE_SLOW, Noise
from proof.strangers.plans import EFFECTS
from proof.strangers.registry import FORMS
from proof.strangers.world import draw_world

MILL = draw_machine(stream("mill"), kind="mill")
NUMBERED = re.compile(r"fresh-\d+")
FAST, SLOW = (sorted(k for k in kinds if "fresh" in k) for kinds in (MORE_FAST, MORE_SLOW))
made = lru_cache(None)(make)  # a case that several tests ask for
LAID_DOWN = "878f946efe3e0d15b2a9"  # of the draws of two families, before the third was there


def world(recs, family="fresh"):
    return draw_world(stream("w"), MILL, recs, family, {"load": True, "spindle": True})


def files():
    return [
        targets(stream("t"), MILL, 0, 0.0, "r1", force={"n": 20, "runs": 2, "pattern": "iso"}),
        ballbar(stream("b"), MILL, 0.0, "r2"),
        trace(
            stream("c"), MILL, 0.0, "r3", "tool", force={"path": "jog", "rows": 2000, "rate": 20}
        ),
        features(stream("p"), MILL, 0.0, "r4"),
    ]


def choices(family, seed="laid down"):
    """What is drawn in some cases, without a digit that rounding could change."""
    out = []
    for tier in TIERS:
        for k in range(3):
            c = made(seed, tier, k, family)
            kinds = [[s["kind"] for s in f["signal"]] for f in c.details["noise"].values()]
            hidden = [(t["effect"], t["axis"], t["form"]) for t in c.truth]
            out.append(
                [c.name, c.details["plan"], c.details["rows"], c.details["files"], kinds, hidden]
            )
    return out


def test_other_families_draw_as_before():
    text = json.dumps([choices("open"), choices("held")])
    assert "fresh" not in text
    assert hashlib.sha256(text.encode()).hexdigest().startswith(LAID_DOWN)


def test_fresh_draws_nothing_held():
    held = {n for forms in FORMS.values() for n, family, _ in forms if family == "held"} | set(
        LATER["held"]["all"]
    )
    openly = {n for forms in FORMS.values() for n, family, _ in forms if family == "open"}
    own = 0
    for row in choices("fresh", "test"):
        drawn = {k for kinds in row[4] for k in kinds} | {form for _, _, form in row[5]}
        assert not drawn & (held - openly)
        own += any(NUMBERED.fullmatch(k) for k in drawn)
    assert own == 3 * len(TIERS)


def test_every_effect_has_a_fresh_form_and_all_bear_numbers():
    for effect in EFFECTS:
        assert any(family == "fresh" for _, family, _ in FORMS[effect]), effect
    for forms in FORMS.values():
        assert all(NUMBERED.fullmatch(n) for n, family, _ in forms if family == "fresh")
    assert sum(n.startswith("alien:fresh-") for n in FORMS) >= 4
    assert set(LATER["fresh"]["all"]) == set(FAST + SLOW) and len(LATER["fresh"]["all"]) >= 5


@pytest.mark.parametrize("tier", TIERS)
def test_cases(tier):
    for k in range(6):
        c = made("test", tier, k, "fresh")
        check_case(c, tier)
    assert make("test", tier, 5, "fresh") == c


@pytest.mark.parametrize("kind", FAST)
def test_fast_kinds_have_their_variance(kind):
    for rec in files():
        n = MORE_FAST[kind](stream("n0", kind), 0.4, rec)
        drawn = [MORE_FAST[kind](stream("n", kind, k), 0.4, rec) for k in range(300)]
        if len(n.white_a) > 1:  # whitened, it is white
            x = [
                lfilter(d.white_a, d.white_b, d.values)[400:] / np.sqrt(d.var[400:])
                for d in drawn
                if rec.n_obs > 800
            ]
        else:
            x = [
                np.round((d.values + k / 7) / d.quant) * d.quant - k / 7 if d.quant else d.values
                for k, d in enumerate(drawn)
            ]
            x = [v / np.sqrt(d.var) for v, d in zip(x, drawn, strict=True)]
        if x:
            assert np.mean(np.square(x)) == pytest.approx(1.0, abs=0.06), rec.kind
            assert abs(np.mean(x)) < 0.03


@pytest.mark.parametrize("kind", SLOW)
def test_slow_kinds_have_their_covariance(kind):
    """Differences of two readings, each over what the oracle is told of it, have unit variance."""
    for rec in files()[:3]:
        n = rec.n_obs
        at = [int(n * x) for x in (0.02, 0.1, 0.35, 0.4, 0.8, 0.99)]
        pairs = [(a, b) for a in at for b in at if a < b]
        ratio = []
        for k in range(250):
            x = Noise(np.zeros(n), np.zeros(n), [])
            MORE_SLOW[kind](stream("s", kind, k), x, 0.7, rec, world([rec]) if k == 0 else None, 0)
            cov = sum((np.outer(c[at], c[at]) for c in x.columns), np.zeros((len(at), len(at))))
            for kernel, t in x.kernels:
                gain = getattr(kernel, "trig", np.ones(n))[at]
                cov = cov + kernel(t[at], t[at]) * np.outer(gain, gain)
            for a, b in pairs:
                i, j = at.index(a), at.index(b)
                var = cov[i, i] + cov[j, j] - 2 * cov[i, j]
                if var > 1e-6:
                    ratio.append((x.values[a] - x.values[b]) ** 2 / var)
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.2), rec.kind


def test_rows_are_counted():
    lost = 0
    for k in range(12):
        c = make("gaps", "null", k, "fresh")
        for name, body in c.files.items():
            if name.startswith("r"):
                said = [
                    s for s in c.details["noise"][name[:-4]]["signal"] if s["kind"] == "fresh-0"
                ]
                lost += sum(s["rows"] for s in said)
        rows = sum(
            sum(x[0] != "#" for x in body.splitlines()) - 1
            for n, body in c.files.items()
            if n.startswith("r")
        )
        assert rows == c.details["rows"]
    assert lost > 0
    gone = [LOSSES["fresh"](stream("g", k), files()[0]) for k in range(40)]
    gone = [g for g in gone if g is not None]
    assert 3 < len(gone) < 25 and not any(g[0] or g[-1] for g in gone)


def test_lost_motion_lags_by_half_its_size():
    q = targets(stream("t"), MILL, 0, 0.0, "r1", force={"n": 7, "runs": 2, "pattern": "iso"})
    w = world([q])
    for name, family, f in FORMS["backlash"]:
        if family == "fresh":
            s = f(w, stream("f"), 0)
            far = q.since[:, 0] > 1.0
            assert np.allclose(
                observe(q, s.field(q, 6.0))[0][far], (-3.0 * q.sgn[:, 0])[far], atol=0.01
            ), name
            assert s.params(6.0) == {"size_um": 6.0}


def test_lags_and_delays_fall_behind():
    q = trace(stream("t"), MILL, 0.0, "r1", "scale", force={"path": "jog", "rows": 3000})
    w, a = world([q]), q.moving[0]
    v = q.vel[:, a]
    k = np.abs(v) > 0.98 * np.abs(v).max()
    for effect in ("servo_lag", "delay"):
        for name, family, f in FORMS[effect]:
            if family == "fresh":
                y = observe(q, f(w, stream("f"), a).field(q, 2.0))[q.axes.index(a)]
                assert np.median(y[k] / v[k]) == pytest.approx(-2.0, abs=0.1), (effect, name)


def test_squareness_with_a_number_closes_the_angle_by_it():
    """Radial reading of a circle: half of urad times the product of both coordinates, whatever
    leans (ISO 230-4)."""
    q = ballbar(stream("b"), MILL, 0.0, "r1", force={"plane": [0, 1], "senses": [1]})
    w, x = world([q]), q.pos - q.meta["centre"]
    plain = next(f for n, _, f in FORMS["squareness"] if n == "lean")

    def twice(f):
        s = next(s for s in (f(w, stream("f", k), 1) for k in range(40)) if s.axis == "XY")
        y = observe(q, s.field(q, 10.0))[0]
        both = np.c_[x[:, 0] * x[:, 1], q.meta["unit"][:, :2], np.ones(len(x))]
        return np.linalg.lstsq(both, y, rcond=None)[0][0], s.params(10.0)

    want, said = twice(plain)
    per_urad = want / said["urad"]
    for _, family, f in FORMS["squareness"]:
        if family == "fresh":
            got, said = twice(f)
            if said:
                assert got == pytest.approx(per_urad * said["urad"], rel=1e-6)


def test_fresh_forms_reach_their_size():
    recs = [
        *files(),
        targets(
            stream("t"),
            MILL,
            0,
            0.0,
            "r5",
            force={"n": 8, "runs": 5, "pattern": "iso", "gap": 7200.0},
        ),
        trace(
            stream("c"), MILL, 0.0, "r6", "scale", force={"path": "jog", "rows": 2000, "rate": 20}
        ),
    ]
    reached = set()
    for effect in EFFECTS:
        for k in range(60):
            h = draw_effect(stream("h", effect, k), world(recs), recs, effect, 6.0)
            if h and h.family == "fresh":
                assert h.peak == pytest.approx(6.0, rel=0.45)
                reached.add(effect)
                break
    assert set(EFFECTS) == reached


def test_a_trial_of_the_third_family_has_a_place_of_its_own(tmp_path):
    truth, details = strangers_trial.made(
        "0" * 40, {"null": 2, "alien": 2}, tmp_path / "cases", 1, "fresh"
    )
    assert {d["family"] for d in details.values()} == {"fresh"} and len(truth) == 4
    for entries in truth.values():
        assert all(re.fullmatch(r"alien:fresh-\d+", t["effect"]) for t in entries)
