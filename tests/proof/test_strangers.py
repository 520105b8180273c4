"""Self-checks of the strangers: signs by hand-made noise-free cases, formats, determinism."""

from __future__ import annotations

import csv
import io
import tomllib

import numpy as np
import pytest

from proof.strangers import TIERS, make
from proof.strangers.base import AX, Part, observe, stream
from proof.strangers.check import check_case
from proof.strangers.designs import ballbar, features, targets
from proof.strangers.hidden import draw_effect, effect_of
from proof.strangers.machines import draw_machine, stated
from proof.strangers.motion import trace
from proof.strangers.plans import EFFECTS
from proof.strangers.registry import FORMS
from proof.strangers.world import draw_world

LATHE = draw_machine(stream("lathe"), kind="lathe")
MILL = draw_machine(stream("mill"), kind="mill")


def world(m, recs, **drivers):
    return draw_world(stream("w"), m, recs, "open", drivers)


def form_of(effect, name):
    return next(f for n, _, f in FORMS[effect] if n == name)


def test_two_axis_formula_of_the_contract():
    m = draw_machine(stream("angle7"), kind="lathe")
    seed = 0
    while "EBZ" not in m.tables[2] or not m.tool[2]:
        seed += 1
        m = draw_machine(stream("angle", seed), kind="lathe")
    r = stream("p")
    pos = np.c_[r.uniform(*m.travel[0], 50), np.zeros(50), r.uniform(*m.travel[2], 50)]
    tool, _ = stated(m, pos, np.ones((50, 3)))
    t, x = m.tables, pos[:, 0]

    def e(ax, c):
        return np.interp(pos[:, ax], m.nodes[ax], t[ax][c][0])

    b = e(2, "EBZ") * 1e-3
    want_z = (
        e(2, "EZZ")
        + e(0, "EZX")
        - m.square["B0X"] * 1e-3 * x
        - b * (x + m.tool[0] - m.measured[2][0])
    )
    want_x = e(0, "EXX") + e(2, "EXZ") + b * m.tool[2]
    if "EBX" in t[0]:
        bx = e(0, "EBX") * 1e-3
        want_z, want_x = want_z - bx * m.tool[0], want_x + bx * m.tool[2]
    assert np.allclose(tool[:, 2], want_z) and np.allclose(tool[:, 0], want_x)


@pytest.mark.parametrize("form", ["play", "tanh"])
def test_backlash_lags(form):
    q = targets(stream("t"), LATHE, 2, 0.0, "r1", force={"n": 7, "runs": 2, "pattern": "iso"})
    s = form_of("backlash", form)(world(LATHE, [q]), stream("f"), 2)
    y = observe(q, s.field(q, 6.0))[0]
    assert np.allclose(y, -3.0 * q.sgn[:, 2], atol=1e-6) and s.params(6.0) == {"size_um": 6.0}


def test_approach_is_sign_of_last_move():
    q = targets(stream("t"), MILL, 0, 0.0, "r1", force={"n": 5, "runs": 1, "pattern": "iso"})
    assert q.sgn[:5, 0].tolist() == [1] * 5 and q.sgn[5:, 0].tolist() == [-1] * 5
    assert set(np.abs(q.sgn[:, MILL.axes]).ravel()) == {1.0}


def test_lag_and_delay_fall_behind():
    q = trace(stream("t"), MILL, 0.0, "r1", "scale", force={"path": "jog", "rows": 3000})
    w = world(MILL, [q])
    a = q.moving[0]
    i = q.axes.index(a)
    v = q.vel[:, a]
    for effect, form in (("servo_lag", "direct"), ("delay", "taylor"), ("delay", "shift")):
        s = form_of(effect, form)(w, stream("f"), a)
        y = observe(q, s.field(q, 2.0))[i]
        k = np.abs(v) > 0.9 * np.abs(v).max()
        assert np.allclose(y[k] / v[k], -2.0, atol=0.5), effect


def test_ballbar_spike_is_outward_and_mismatch_changes_with_sense():
    q = ballbar(stream("b"), MILL, 0.0, "r1", force={"plane": [0, 1], "senses": [1, -1]})
    w = world(MILL, [q])
    y = observe(q, form_of("reversal_spike", "distance")(w, stream("f"), 0).field(q, 5.0))[0]
    assert y.max() > 0.8 and y.max() > 3 * abs(y[q.revt[:, 0] > 0.2].min())
    pair = form_of("servo_mismatch", "direct")(w, stream("f"), 0)
    y = observe(q, pair.field(q, 1.0))[0]
    x = q.pos - q.meta["centre"]
    u = x[:, 0] * x[:, 1] * q.meta["sense"]
    if pair.axis == "XY":
        assert abs(np.corrcoef(u, y)[0, 1]) > 0.999


def test_squareness_by_iso_230_1():
    q = ballbar(stream("b"), MILL, 0.0, "r1", force={"plane": [0, 1], "senses": [1]})
    w = world(MILL, [q])
    for k in range(30):
        s = form_of("squareness", "lean")(w, stream("f", k), 1)
        if s.axis == "XY":
            break
    p = s.params(10.0)["urad"]
    tool = s.field(q, 10.0).tool
    assert np.allclose(tool[:, 0], -p * 1e-3 * q.pos[:, 1])


def test_parts():
    q = features(stream("parts"), MILL, 0.0, "r1")
    w = world(MILL, [q])
    kind = np.array([i[1] for i in q.meta["info"]])
    s = form_of("tool_size", "plain")(w, stream("f"), 0)
    y = observe(q, s.field(q, 4.0))[0] / s.params(4.0)["diameter_um"]
    sign = {"pocket_size": 1, "bore_diameter": 1, "boss_diameter": -1}
    assert np.allclose(y, [sign.get(k, 0) for k in kind])
    b = form_of("backlash", "play")(w, stream("f"), 0)
    y = observe(q, b.field(q, 8.0))[0]
    mine = np.array([i[2] == 0 for i in q.meta["info"]])
    want = {"pocket_size": -8, "bore_diameter": -8, "boss_diameter": 8}
    assert np.allclose(y[mine], [want.get(k, 0) for k in kind[mine]], atol=1e-6)


def test_scale_trace_has_no_tables_and_no_play():
    q = trace(stream("t"), MILL, 0.0, "r1", "scale", force={"path": "jog", "rows": 2000})
    w = world(MILL, [q])
    for effect in ("backlash", "cyclic", "scale", "windup", "screw_heat", "squareness", "bow"):
        for _, _, f in FORMS[effect]:
            assert not np.any(observe(q, f(w, stream("f"), 0).field(q, 5.0)))
    assert not np.any(observe(q, Part(tool=np.ones((len(q.t), 3)))))


def test_every_effect_has_forms():
    for e in EFFECTS:
        fam = [f[1] for f in FORMS[e]]
        assert fam.count("open") >= 2 and "held" in fam, e
    alien = [f[0][1] for n, f in FORMS.items() if n.startswith("alien:")]
    assert alien.count("open") >= 8 and alien.count("held") >= 6


def test_screw_grows_away_from_its_bearing():
    q = targets(
        stream("t"), LATHE, 2, 0.0, "r1", force={"n": 5, "runs": 8, "pattern": "iso", "gap": 900.0}
    )
    w = world(LATHE, [q])
    for form in ("lumped", "moving_source", "two_constants"):
        y = observe(q, form_of("screw_heat", form)(w, stream("f"), 2).field(q, 1.0))[0]
        last = q.run == q.run.max()
        assert np.ptp(y[last]) > 2 * np.ptp(y[:5]) and np.isfinite(y).all()


def test_effects_scale():
    q = targets(stream("t"), MILL, 0, 0.0, "r1", force={"n": 30, "runs": 3, "pattern": "iso"})
    w = world(MILL, [q])
    h = draw_effect(stream("h"), w, [q], "backlash", 6.0, 0)
    assert h and abs(h.peak - 6.0) < 0.6 and np.allclose(effect_of(h.shape, [q], h.amp)[0], h.mu[0])


@pytest.mark.parametrize("family", ["open", "held"])
@pytest.mark.parametrize("tier", TIERS)
def test_cases(tier, family):
    for k in range(6):
        case = make("test", tier, k, family)
        check_case(case, tier)
    assert make("test", tier, 5, family) == case


def test_files_parse_as_toml_and_csv():
    c = make("parse", "single", 3)
    tomllib.loads(c.files["machine/machine.toml"])
    for n, body in c.files.items():
        if n.endswith(".csv") and not n.startswith("machine/"):
            head = "\n".join(x[2:] for x in body.splitlines() if x.startswith("# "))
            assert tomllib.loads(head)["format"] == "gcomp-recording/1"
            rows = list(
                csv.reader(
                    io.StringIO("\n".join(x for x in body.splitlines() if not x.startswith("# ")))
                )
            )
            assert len({len(x) for x in rows}) == 1
    assert AX == "XYZ"
