"""Laws for every effect of the library."""

from __future__ import annotations

import inspect
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from postproc import effects
from postproc.diagnose.rows import pick_state
from postproc.effects import State

ROOT = Path(__file__).parents[2].parent / "shared"
NAMES = effects.names()
RNG = np.random.default_rng(5)
N = 12
T = np.sort(RNG.uniform(0, 7200, N))
STATE = State(
    position={x: RNG.uniform(0.0, 100.0, N) for x in "XYZ"},
    approach={x: RNG.choice([-1.0, 1.0], N) for x in "XYZ"},
    travel=dict.fromkeys("XYZ", (0.0, 100.0)),
    velocity={x: RNG.uniform(-30, 30, N) for x in "XYZ"},
    acceleration={x: RNG.uniform(-300, 300, N) for x in "XYZ"},
    distance={x: RNG.uniform(0, 30, N) for x in "XYZ"},
    since={x: RNG.uniform(0, 0.2, N) for x in "XYZ"},
    time=T,
    run=np.ones(N),
    channels={
        **{f"T_screw_{x}_C": 20 + RNG.uniform(0, 4, N) for x in "XYZ"},
        **{f"force_{x}_N": RNG.uniform(0, 300, N) for x in "XYZ"},
        "T_air_C": 20 + RNG.uniform(0, 2, N),
        "T_bed_C": 20 + RNG.uniform(0, 1, N),
        "spindle_rpm": RNG.uniform(0, 3000, N),
        "part": np.arange(N, dtype=float),
        "material": RNG.choice([-1.0, 1.0], N),
        "wall": np.resize([-1.0, 0.0, 1.0], N),
        "bore": RNG.choice([0.0, 1.0], N),
    },
    angles={x: RNG.uniform(-5e-5, 5e-5, (3, N)) for x in "XYZ"},
    beam=RNG.uniform(0, 500, N),
    passage=np.zeros(N),
    file=np.zeros(N),
    lines={"X": "YZ", "Y": "XZ", "Z": "XY"},
)
FOUND = {
    "cyclic": {"period_mm": 7.3, "second": 1.0, "grows": 1.0, "sided": 0.0},
    "encoder_cyclic": {"period_mm": 7.3, "second": 0.0, "grows": 0.0, "sided": 0.0},
    "vibration": {"frequency_hz": 11.0, "passages": 0.0},
    "stick_slip": {"period_mm": 3.1, "fastest_mm_s": 20.0, "slip_ms": 10.0, "scatter": 0.0},
    "dead_path": {"file": 0.0, "late_s": 0.0, "pressure": 1.0},
    "step_loss": {"t_s": 3000.0},
    "outlier": {"t_s": 3000.0},
    "sensor_drift": {},
}
APPLIED = ("tables", "grids", "by_angle")
ENDS = np.array([0.0, 100.0])
LINE = np.array([[-2e-5, 5e-5], [3e-5, -1e-5], [4e-5, 2e-5]])


def line_at(place):
    return LINE[:, :1] + (LINE[:, 1:] - LINE[:, :1]) * place / 100.0


def axis_of(module) -> str:
    return (
        "" if getattr(module, "LINE", False) else {"axis": "X", "pair": "XZ", "all": ""}[module.PER]
    )


def shapes_of(name, module):
    return [FOUND[name]] if name in FOUND else module.shapes(STATE, axis_of(module))


@pytest.mark.parametrize("name", NAMES)
def test_says_what_it_is(name):
    module = effects.load(name)
    assert module.KIND in ("machine", "instrument", "data")
    assert module.USE in ("compensate", "simulate", "recording")
    assert (module.USE == "recording") == (module.KIND != "machine")
    assert module.PER in ("axis", "pair", "all")
    assert len(module.__doc__.strip()) > 40
    assert module.TEXT.count(".") >= 2, "what it is, and what to do"
    for parameter, meaning in module.PARAMETERS.items():
        assert "," in meaning, f"{parameter}: unit, then meaning"
    assert list(inspect.signature(module.coefficients).parameters) == list(module.PARAMETERS)


@pytest.mark.parametrize("name", NAMES)
def test_columns_are_vectors_row_by_row(name):
    module = effects.load(name)
    shapes = shapes_of(name, module)
    assert shapes
    for shape in shapes:
        value = module.columns(STATE, axis_of(module), **shape)
        reading = module.USE == "recording" and "laser" in module.SEES
        assert value.ndim == (2 if reading else 3) and value.shape[-1] == N
        assert reading or value.shape[1] == 3
        assert np.isfinite(value).all() and np.abs(value).max() > 0
        assert np.linalg.matrix_rank(value.reshape(len(value), -1)) == len(value), (
            "two columns say the same"
        )


@pytest.mark.parametrize("name", [n for n in NAMES if getattr(effects.load(n), "ALONG", False)])
def test_what_is_along_its_axis_is_determined_by_the_rows_of_one_signal(name):
    """Two signals are read at the same moments, and one of them in another motion, too."""
    module = effects.load(name)
    rng = np.random.default_rng(7)
    inside = {x: p + rng.uniform(0, 2, (5, N)) for x, p in STATE.position.items()}
    motion = np.arange(N) // (N // 2)
    state = replace(STATE, inside=inside, width=np.zeros(N), passage=motion, file=motion)
    both, own = pick_state(state, np.repeat(np.arange(N), 2)), np.flatnonzero(motion == 0)
    shapes = shapes_of(name, module)
    for shape in list(shapes):
        shapes += getattr(module, "fuller", lambda *_: [])(shape, state, "Y")
    for shape in shapes:
        columns = module.columns(both, "Y", **shape)
        assert not columns[:, [0, 2]].any()
        of_own = module.columns(pick_state(state, own), "Y", **shape)
        assert of_own == pytest.approx(columns[..., ::2][..., own], rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_parameters_say_all_of_a_fit(name):
    """Coefficients to named parameters and back are the same deviation; no coefficients are no
    deviation."""
    module, rng = effects.load(name), np.random.default_rng(7)
    for shape in shapes_of(name, module):
        columns = module.columns(STATE, axis_of(module), **shape)
        value = rng.normal(size=len(columns))
        named = module.parameters(value, shape)
        assert set(named) == set(module.PARAMETERS)
        again, same = module.coefficients(**named)
        assert again == pytest.approx(value) and same == pytest.approx(shape)
        assert effects.deviation(module, STATE, axis_of(module), **named) == pytest.approx(
            np.tensordot(value, columns, axes=1)
        )


@pytest.mark.parametrize(
    "name", [n for n in NAMES if any(hasattr(effects.load(n), how) for how in APPLIED)]
)
def test_tables_are_the_same_physics(name):
    """What a compensator applies is what the diagnosis fits, within 1 % of its size (tables are
    linear between nodes). Windup is fully built up in the table, so it is compared far from a
    reversal; how bosses were milled is nothing that a slide knows."""
    module, rng = effects.load(name), np.random.default_rng(7)
    assert module.USE == "compensate"
    axis = axis_of(module)
    for shape in shapes_of(name, module):
        value = rng.normal(size=len(module.columns(STATE, axis, **shape)))
        named = module.parameters(value, shape)
        channels = STATE.channels | {"material": np.abs(STATE.channels["material"])}
        distance = dict.fromkeys("XYZ", np.full(N, 1e6))
        far = effects.State(**{**vars(STATE), "distance": distance, "channels": channels})
        wanted = effects.deviation(module, far, axis, **named)
        got = np.zeros((3, N))
        moving = module.moving(axis, **named) if module.PER == "pair" else axis
        rows = (
            module.tables(axis, STATE.travel[moving], **named) if hasattr(module, "tables") else []
        )
        if hasattr(module, "by_angle"):  # a measured rotation: a straight line here
            rows = rows + module.by_angle(axis, ENDS, LINE, LINE, **named)
            far = effects.State(**{**vars(far), "angles": {axis: line_at(STATE.position[axis])}})
            wanted = effects.deviation(module, far, axis, **named)
        if hasattr(module, "grids"):
            for component, letter, other, nodes, others, value in module.grids(
                axis, STATE.travel, **named
            ):
                at = np.clip(
                    (STATE.position[letter], STATE.position[other]),
                    [[nodes[0]], [others[0]]],
                    [[nodes[-1]], [others[-1]]],
                )
                got["XYZ".index(component[1])] += RegularGridInterpolator((nodes, others), value)(
                    at.T
                )
        for component, letter, nodes, forward, reverse in rows:
            assert (np.diff(nodes) > 0).all() and len(nodes) == len(forward) == len(reverse)
            table = np.where(
                STATE.approach[letter] > 0,
                np.interp(STATE.position[letter], nodes, forward),
                np.interp(STATE.position[letter], nodes, reverse),
            )
            got["XYZ".index(component[1])] += table
        assert np.abs(got).max() > 0
        assert got == pytest.approx(wanted, abs=0.01 * np.abs(wanted).max() + 1e-12)


def test_an_instrument_never_reaches_a_program():
    for name in NAMES:
        module = effects.load(name)
        if module.USE != "compensate":
            assert not any(hasattr(module, how) for how in APPLIED)


def test_every_name_of_the_contract_is_there():
    contract = ROOT / "contracts" / "diagnosis.md"
    if not contract.is_file():
        pytest.skip("../shared is absent")
    rows = [line for line in contract.read_text("utf-8").splitlines() if line.startswith("| `")]
    wanted = {name for line in rows for name in re.findall(r"`(\w+)`", line.split("|")[1])}
    assert len(wanted) > 30 and wanted <= set(NAMES)


def test_what_is_listed_is_never_fitted():
    for name in NAMES:
        module = effects.load(name)
        if getattr(module, "LISTED", False):
            assert module.KIND == "data" and module.shapes(STATE, axis_of(module)) == []


def test_zero_backlash_is_none():
    assert not effects.deviation(effects.load("backlash"), STATE, "X", size_um=0.0).any()
