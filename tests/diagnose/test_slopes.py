"""Causes that are a slope along an axis are told apart: by the instruments in which they show, by
time, by temperature."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import effects, recordings
from postproc.cli import main
from postproc.diagnose import assembly, nuisances
from postproc.diagnose.signals import signals_of
from postproc.effects import State, cosine, laser_air
from postproc.machine.file import read_machine
from tests.diagnose.command import diagnosed

STUDER = str(Path(__file__).resolve().parents[2] / "machines" / "studer-s36")
HEAD = (
    '# format = "gcomp-recording/1"\n# kind = "targets"\n# instrument = "{}"\n# quantity ='
    ' "displacement"\n# sensitive = {{ Z = 1.0 }}\n'
)


def targets(instrument: str) -> recordings.Recording:
    table = "run,t_s,Z_mm,approach_Z,reading_um\n" + "".join(
        f"1,{10 * k},{50 * k},1,0.0\n" for k in range(8)
    )
    return recordings.read(recordings.Source("r.csv", (HEAD.format(instrument) + table).encode()))


@pytest.mark.parametrize(
    "instrument, lit",
    [
        ("laser interferometer", 1.0),
        ("laser gauge", 1.0),
        ("XL-80 laser, air probe", 1.0),
        ("", 1.0),
        ("in-process gauge", 0.0),
        ("dial gauge", 0.0),
        ("glass scale", 0.0),
        ("grid encoder", 0.0),
    ],
)
def test_only_light_knows_of_air(instrument, lit):
    """Whatever reads a length may lie askew; of light alone air tells."""
    (_, columns), *_ = signals_of(targets(instrument), read_machine(Path(STUDER)))
    assert columns["beam"].max() == 350.0 and set(columns["channel lit"]) == {lit}
    faces = float("gauge" in instrument) * (1.0 - lit)  # a scale has none
    assert set(columns["channel faces"]) == {faces}
    flags = {"lit": np.full(12, lit), "faces": np.full(12, faces)}
    read = replace(state(**flags), run=np.ones(12))
    assert laser_air.light(read).max() == 500.0 * lit
    ways = {(s["file"], s["touched"]) for s in cosine.shapes(read, "Z")}
    assert ways == {(f, 0.0) for f in (-1.0, 0.0, 1.0)} | {(f, 1.0) for f in (0.0, 1.0) if faces}


def state(**channels: np.ndarray) -> State:
    """Two recordings, one after the other, of six readings each."""
    n = 12
    return State(
        {"Z": np.tile(np.linspace(0.0, 500.0, 6), 2)},
        {"Z": np.ones(n)},
        {"Z": (0.0, 500.0)},
        time=np.concatenate([np.arange(6) * 600.0 + 60.0, np.arange(6) * 600.0 + 7200.0]),
        channels=channels,
        beam=np.tile(np.linspace(0.0, 500.0, 6), 2),
        file=np.repeat([0.0, 1.0], 6),
        passage=-np.ones(n),
    )


def test_air_that_nobody_recorded_changes_in_each_recording_in_its_own_way():
    module, s = effects.load("laser_air"), state()
    assert module.shapes(s, "") == [
        {"told": 0.0, "by": -2.0},
        {"told": 1.0, "by": -2.0},
        {"told": 1.0, "by": 0.0},
    ]
    first, second, told = module.columns(s, "", told=1.0, by=-2.0)
    # 1 ppm/h over 500 mm and 50 min
    assert first[5] == pytest.approx(500e-6 * 3000 / 3600) and not first[6:].any()
    assert not second[:6].any() and second[11] == pytest.approx(first[5])
    assert told == pytest.approx(s.beam * 1e-6)
    named = module.parameters(np.array([2.0, -3.0, 7.0]), {"told": 1.0, "by": -2.0})
    assert (named["ppm_h_1"], named["ppm_h_2"], named["ppm_h_3"], named["wrong_ppm"]) == (
        2.0,
        -3.0,
        0.0,
        7.0,
    )
    value, shape = module.coefficients(**named)
    assert list(value) == [2.0, -3.0, 7.0] and shape == {"told": 1.0, "by": -2.0}


def test_recorded_air_stands_beside_air_that_changes_with_the_time():
    """A thermometer may be late or hang, and nobody records the pressure: two recordings, each with
    a rate of its own. The laser may know nothing of the temperature between them either."""
    s = state(T_air_C=np.linspace(20.0, 22.0, 12))
    assert {shape["by"] for shape in effects.load("laser_air").shapes(s, "")} == {
        2.0,
        1.0,
        -2.0,
        0.0,
    }


def test_air_that_nobody_recorded_is_not_offered_by_its_temperature():
    assert {shape["by"] for shape in effects.load("laser_air").shapes(state(), "")} == {-2.0, 0.0}


def test_a_coarse_thermometer_on_the_screw_does_not_hide_its_heat():
    """Heat that comes with time or travel is offered beside a recorded temperature, cold at the
    beginning."""
    s = state(T_screw_Z_C=np.round(np.linspace(20.0, 20.4, 12)))
    offered = effects.load("screw_heat").shapes(s, "Z")
    assert {shape["tau_s"] > 0 for shape in offered} == {False, True} and not any(
        shape["warm"] for shape in offered
    )


def test_a_screw_that_may_have_been_warm_is_offered_only_without_its_temperature():
    module = effects.load("screw_heat")
    assert any(shape["warm"] for shape in module.shapes(state(), "Z"))
    known = state(T_screw_Z_C=np.linspace(20.0, 22.0, 12))
    assert not any(shape["warm"] for shape in module.shapes(known, "Z"))


def test_a_temperature_goes_from_reading_to_reading_and_begins_as_the_room():
    air = np.where(np.arange(12) < 6, 19.0, np.nan)
    screw = np.where(np.arange(12) < 6, np.nan, 25.0)
    filled = assembly._filled("T_screw_Z_C", state(T_air_C=air, T_screw_Z_C=screw))
    assert filled[0] == 19.0 and list(filled[6:]) == [25.0] * 6
    assert filled[3] == pytest.approx(19.0 + 6.0 * 1800.0 / 7140.0)
    untimed = replace(state(T_screw_Z_C=screw), time=np.zeros(12))
    assert list(assembly._filled("T_screw_Z_C", untimed)) == [25.0] * 12


def changed(file: Path, wrong_ppm: float, ppm_h: float) -> None:
    """A laser's recording whose air was not recorded, was told wrong, and changed while it
    lasted."""
    lines = file.read_text().splitlines(keepends=True)
    head = "".join(line for line in lines if line.startswith("#"))
    table = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    letter = max("XZ", key=lambda x: np.ptp([float(r[f"{x}_mm"]) for r in table]))
    p, t = (np.array([float(r[name]) for r in table]) for name in (f"{letter}_mm", "t_s"))
    more = (wrong_ppm + ppm_h * (t - t[0]) / 3600.0) * (p - p[0]) * 1e-3
    out = io.StringIO()
    names = [n for n in table[0] if not n.startswith("T_")]
    writer = csv.DictWriter(out, names, extrasaction="ignore")
    writer.writeheader()
    for row, add in zip(table, more, strict=True):
        writer.writerow(row | {"reading_um": f"{float(row['reading_um']) + add:.2f}"})
    file.write_text(head + out.getvalue())


def test_one_air_says_the_slopes_of_all_lasers(tmp_path):
    files = []
    for number, test in enumerate(("positioning:Z", "positioning:X", "ballbar:XZ")):
        file = tmp_path / f"r{number}.csv"
        asked = [
            "simulate",
            "--test",
            test,
            "--machine",
            STUDER,
            "--noise",
            "0.4",
            "--seed",
            str(number + 5),
        ]
        assert main([*asked, "-o", str(file), "--quiet"]) == 0
        files.append(file)
    changed(files[0], 25.0, -20.0)
    changed(files[1], 25.0, 30.0)
    out = tmp_path / "answer.json"
    assert (
        main(["diagnose", *map(str, files), "--machine", STUDER, "--json", str(out), "--quiet"])
        == 0
    )
    told = json.loads(out.read_text())
    found = [(e["effect"], e["axis"]) for e in told["effects"] if e["status"] == "accepted"]
    assert found == [("laser_air", None)]
    assert told["effects"][0]["parameters"]["wrong_ppm"]["value"] == pytest.approx(25.0, rel=0.2)


def straightness(folder: Path, urad: float, um_per_h: float, angle: str = "") -> str:
    """A file of straightness of X across Z along 150 mm of Z, two runs there and back, 20 s a
    target; X leans and drifts."""
    lines = [
        '# format = "gcomp-recording/1"',
        '# kind = "targets"',
        '# instrument = "straightness optics"',
        '# quantity = "straightness"',
        "# sensitive = { X = 1.0 }",
        "run,t_s,X_mm,Z_mm,approach_X,approach_Z,reading_um",
    ]
    rng, t = np.random.default_rng(4), 0.0
    for run in range(1, 9):
        for k in list(range(16)) if run % 2 else list(range(15, -1, -1)):
            t += 20.0
            value = 10.0 * k * urad * 1e-3 + um_per_h * t / 3600 + rng.normal(0, 0.1)
            lines.append(f"{run},{t:.1f},100.0,{10.0 * k:.1f},1,{1 if run % 2 else -1},{value:.3f}")
    path = folder / "r.csv"
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def bare(folder: Path) -> str:
    """A machine of two axes without tables."""
    axes = "".join(
        f"[axes.{x}]\ntravel = [0.0, 200.0]\nleast_increment = 0.001\nmeasured_at = {{ {y} = 0.0"
        " }\n"
        for x, y in ("XZ", "ZX")
    )
    (folder / "bare").mkdir()
    text = (
        'format = "gcomp-machine/1"\nname = "bare"\ncontrol = "fanuc-lathe-a"\nchain ='
        ' "w-b-Z-X-t"\n'
    )
    (folder / "bare" / "machine.toml").write_text(text + axes)
    return str(folder / "bare")


def answered(folder: Path, path: str) -> dict:
    return diagnosed([path], bare(folder), folder / "a.json")


def test_a_frame_drifts_across_the_axis_that_moves(tmp_path):
    """12 um in 43 minutes across Z, which alone moves: X does not move, and drifts all the same."""
    answer = answered(tmp_path, straightness(tmp_path, 0.0, 17.0))
    assert [e["effect"] for e in answer["effects"] if e["status"] == "accepted"] == [
        "structure_drift"
    ]


def test_the_line_of_a_straightness_reading_is_the_machines_and_that_is_said(tmp_path, capsys):
    answer = answered(tmp_path, straightness(tmp_path, 60.0, 0.0))
    (found,) = answer["effects"]
    assert (found["effect"], found["axis"], found["status"]) == ("squareness", "XZ", "accepted")
    assert abs(found["parameters"]["urad"]["value"]) == pytest.approx(60.0, abs=10.0)
    main(["diagnose", str(tmp_path / "r.csv"), "--machine", str(tmp_path / "bare")])
    assert "take the line out of the readings" in " ".join("".join(capsys.readouterr()).split())


def test_slides_at_rest_show_what_drifts(tmp_path):
    """ISO 230-3: a reading a minute for two hours at one place; the frame goes 12 um with a time
    constant of 45 minutes."""
    rng, t = np.random.default_rng(7), np.arange(120) * 60.0
    value = 12.0 * (1 - np.exp(-t / 2700.0)) + rng.normal(0, 0.1, len(t))
    head = HEAD.format("dial gauge").replace("Z = 1.0", "X = 1.0")
    table = "run,t_s,X_mm,Z_mm,approach_X,approach_Z,reading_um\n"
    rows_ = "".join(f"1,{s:.0f},100.0,50.0,1,1,{v:.3f}\n" for s, v in zip(t, value, strict=True))
    (tmp_path / "r.csv").write_text(head + table + rows_)
    (found,) = answered(tmp_path, str(tmp_path / "r.csv"))["effects"]
    assert (found["effect"], found["status"]) == ("structure_drift", "accepted")
    assert found["parameters"]["tau_s"]["value"] == pytest.approx(2700.0, rel=0.5)


def test_the_map_errs_by_what_it_states(tmp_path):
    """EXZ is stated to 2.4 um (95 %), 1.2 um (k = 1), four times the usual 0.3: of its terms the
    columns are four times as large."""
    folder, path = Path(bare(tmp_path)), straightness(tmp_path, 0.0, 0.0)
    read = [recordings.read(recordings.Source("r.csv", Path(path).read_bytes()))]

    def terms() -> np.ndarray:
        machine = read_machine(folder)
        return nuisances.of_map(assembly.of(read, machine), machine)[0].columns

    (folder / "Z.csv").write_text("Z_mm,EXZ_um\n0,1\n200,1\n")
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(text.replace("[axes.Z]\n", '[axes.Z]\ntable = "Z.csv"\n'))
    usual = terms()
    (folder / "Z_uncertainty.csv").write_text("Z_mm,EXZ_um\n0,2.4\n200,2.4\n")
    stated = terms()
    ratio = np.abs(stated).max(axis=0) / np.abs(usual).max(axis=0)
    assert sorted({round(float(r), 6) for r in ratio}) == [1.0, 4.0]
