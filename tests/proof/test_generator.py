"""Cases are as the contracts say, always the same, of the stated size, and know nothing of the
tool."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from postproc.machine.file import read_machine
from postproc.recordings import ReadingOptions, Source
from postproc.recordings.contract import read
from postproc.units import UM
from proof.generator import KINDS, cases, machines, make, oracle, physics
from proof.generator.__main__ import write
from proof.generator.streams import stream

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted(
    path for name in ("generator", "textbook") for path in (ROOT / "proof" / name).rglob("*.py")
)
NAMES = {  # contracts: the names of effects
    "scale",
    "pitch_shape",
    "backlash",
    "backlash_position",
    "windup",
    "reversal_spike",
    "stick_slip",
    "friction_asymmetry",
    "viscous_friction",
    "coulomb_friction",
    "servo_lag",
    "servo_mismatch",
    "inertia",
    "vibration",
    "cyclic",
    "encoder_cyclic",
    "screw_heat",
    "structure_drift",
    "spindle_growth",
    "squareness",
    "bow",
    "abbe",
    "sag",
    "force_compliance",
    "tool_wear",
    "tool_size",
    "step_loss",
    "laser_air",
    "dead_path",
    "cosine",
    "delay",
    "clock_skew",
    "sensor_drift",
    "outlier",
}


made = lru_cache(None)(make)  # the cases of one seed, which several tests ask for


def columns(text: str) -> dict[str, np.ndarray]:
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = [line.split(",") for line in lines[1:]]
    return {name: np.array([row[i] for row in rows]) for i, name in enumerate(lines[0].split(","))}


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_the_generators_import_nothing_of_the_tool(path):
    allowed = {"proof", "numpy", "scipy"} | set(sys.stdlib_module_names)
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            assert {a.name.split(".")[0] for a in node.names} <= allowed
        if isinstance(node, ast.ImportFrom) and not node.level:
            assert (node.module or "").split(".")[0] in allowed


@pytest.mark.parametrize("kind", KINDS)
def test_a_case_is_what_the_contracts_want(kind, tmp_path):
    for number in range(3):
        case = made("same", kind, number)
        write(case, tmp_path / "cases", tmp_path / "truth")
        folder = tmp_path / "cases" / case.name
        machine = read_machine(folder / "machine")
        paths = sorted(folder.glob("r*.csv"))
        assert [p.name for p in paths] == [f"r{k + 1}.csv" for k in range(len(paths))] and paths
        for path in paths:
            recording = read(Source(path.name, path.read_bytes()), ReadingOptions())
            assert not recording.faults and recording.machine == machine.name
            assert len(recording) <= 25000
            if recording.kind == "features":
                continue
            assert (np.diff(recording.columns["t_s"]) > 0).all()
            for x in recording.axes:
                low, high = machine.axes[x].travel
                assert (recording.position(x) >= low).all() and (
                    recording.position(x) <= high
                ).all()


def test_the_map_means_to_the_tool_what_it_means_here(tmp_path):
    """The written machine, read by the tool, deviates as the generator's: within the rounding of
    its tables (none: they are rounded before). All forms and chains that occur in thirty
    machines."""
    chains = set()
    for number in range(30):
        machine = machines.draw(stream("map", number))
        chains.add(machine.chain)
        for name, text in cases.files.machine_files(machine).items():
            path = tmp_path / str(number) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        rng = np.random.default_rng(number)
        position, direction = np.zeros((50, 3)), rng.choice([-1.0, 1.0], (50, 3))
        for x, axis in machine.axes.items():
            position[:, "XYZ".index(x)] = rng.uniform(axis.low, axis.high, 50)
        theirs = read_machine(tmp_path / str(number) / "machine")
        rows = ["XYZ".index(x) for x in theirs.letters]
        expected = theirs.deviation(position.T[rows], direction.T[rows]) / UM
        assert machine.deviation(position, direction, known=True).T[rows] == pytest.approx(
            expected, abs=1e-6
        )
    assert len(chains) >= 4


@pytest.mark.parametrize("kind", KINDS)
def test_a_case_follows_from_seed_kind_and_number(kind):
    first, again = made("same", kind, 1), make("same", kind, 1)
    assert first == again
    assert made("same", kind, 2).name != first.name and make("other", kind, 1).files != first.files


def without_effects(monkeypatch, seed, kind, number):
    with monkeypatch.context() as patch:
        patch.setattr(cases, "_hide", lambda *args: [])
        return make(seed, kind, number)


READING = {"targets": ("reading_um", "reading_urad"), "ballbar": ("radial_um",)}


@pytest.mark.parametrize("kind", ["single", "masked", "alien"])
def test_the_largest_reading_is_what_the_truth_says(kind, monkeypatch):
    """The files with and without the effect differ by its signal; without the set-up its peak is
    peak_um, within the 0.1 um of the readings on either side."""
    for number in range(5):
        case, bare = made("same", kind, number), without_effects(monkeypatch, "same", kind, number)
        (answer,) = case.truth
        assert 2.0 <= answer["peak_um"] <= 16.0
        low, high = map(float, answer["band"].split("-"))
        assert low <= answer["peak_um"] <= high
        largest = 0.0
        for name in (n for n in case.files if n.startswith("r")):
            a, b = columns(case.files[name]), columns(bare.files[name])
            if "measured_mm" in a:
                moved = (a["measured_mm"].astype(float) - b["measured_mm"].astype(float)) * 1e3
                largest = max(largest, np.abs(moved).max())
            for column in a:
                if column.startswith(("reading_u", "radial_")) or column.endswith("_act_mm"):
                    moved = a[column].astype(float) - b[column].astype(float)
                    moved *= 1e3 if column.endswith("_mm") else 1.0
                    basis = [np.ones(len(moved))]
                    if column == "radial_um":
                        at = [a[c].astype(float) for c in a if c.endswith("_cmd_mm")]
                        basis += [v - (v.max() + v.min()) / 2 for v in at]
                    left = (
                        moved
                        - np.array(basis).T
                        @ np.linalg.lstsq(np.array(basis).T, moved, rcond=None)[0]
                    )
                    largest = max(largest, np.abs(left).max())
        assert largest == pytest.approx(answer["peak_um"], abs=0.25)


def test_truth_has_the_form_of_the_practice_answers():
    for kind, count in (("null", 0), ("adversarial", 0), ("single", 1), ("pair", 2), ("triple", 3)):
        for number in range(3):
            truth = made("same", kind, number).truth
            assert len(truth) == count
            assert len({(a["effect"], a["axis"]) for a in truth}) == count
            for answer in truth:
                assert {"effect", "axis", "parameters", "peak_um", "visible"} <= set(answer)
                assert answer["effect"] in NAMES
                assert answer["axis"] is None or set(answer["axis"]) <= set("XYZ")
                json.dumps(answer)


def test_every_name_of_the_contract_can_be_hidden_but_the_two_faults_of_data():
    assert set(physics.names()) == NAMES - {"sensor_drift", "outlier"}
    assert len(physics.unnamed()) >= 8
    assert not set(physics.unnamed()) & NAMES


def test_masked_effects_lie_under_ten_times_larger_geometry():
    for number in range(6):
        machine = machines.draw(stream("masked", "masked", number, "machine"), masked=True)
        case = make("masked", "masked", number)
        smallest = min(np.ptp(axis.tables[f"E{x}{x}"][0]) for x, axis in machine.axes.items())
        assert smallest >= 10 * max(a["peak_um"] for a in case.truth)


def test_withheld_channels_are_not_in_the_files():
    gone = {"temperature": "T_", "force": "force_", "spindle": "spindle_rpm"}
    seen = set()
    for number in range(12):
        case = make("withheld", "withheld", number)
        group = case.details["withheld"]
        seen.add(group)
        assert case.truth[0]["effect"] in cases.WITHHELD[group]
        for name in (n for n in case.files if n.startswith("r")):
            assert not any(c.startswith(gone.get(group, "?")) for c in columns(case.files[name]))
    assert len(seen) >= 3


def test_what_a_blind_test_hides_is_invisible_or_ambiguous_and_stands_out_in_the_follow_up():
    spots, ambiguous, shown, twins = set(), {"one_arm", "one_sense"}, [], []
    for number in range(40):
        case = make("blind", "blind", number)
        blind = case.details["blind"]
        spots.add(blind["spot"])
        assert case.follow_up and not any(n.startswith("f") for n in case.files)
        for first, later in zip(case.truth, blind["follow_up"], strict=True):
            assert 2.0 <= later["peak_um"] <= 16.0
            shown.append(later["visible"])
            if first["effect"] in ("cyclic", "backlash"):
                assert not first["visible"] and first["peak_um"] < 0.05
            if blind["spot"] in ambiguous and first["visible"]:
                twins.append(bool(first["twins"]))  # another name explains it as well
    assert len(spots) == 4 and np.mean(shown) > 0.8 and np.mean(twins) > 0.8


def test_energy_of_a_scale_error_by_hand():
    """A line known without error, one laser file: energy = sum of (signal - mean)^2 / variance,
    here 10 ppm on 11 targets."""
    from proof.generator.tracks import Track

    machine = machines.draw(stream("energy", 0))
    machine = machines.Machine(**{**vars(machine), "stated_um": 1e-9})
    x = np.linspace(0, 100, 11)
    position = np.zeros((11, 3))
    position[:, 0] = x
    track = Track(
        "targets",
        {"quantity": "displacement"},
        "X",
        np.ones(11),
        x,
        position,
        np.ones((11, 3)),
        sensitive=np.eye(3)[0],
    )
    track.noise = {"sd": 0.5}
    signal = 10e-3 * x[:, None]
    variance = 0.25 + 0.01 / 12
    expected = ((signal - signal.mean()) ** 2).sum() / variance
    assert oracle.Oracle(machine, [track]).energies([[signal]]) == pytest.approx(
        [expected], rel=1e-3
    )
    assert oracle.peak([track], [signal]) == pytest.approx(0.5)


def test_the_command_writes_cases_and_keeps_the_truth_outside(tmp_path):
    command = [
        sys.executable,
        "-m",
        "proof.generator",
        "--seed",
        "7",
        "--kind",
        "single",
        "--count",
        "2",
        "-o",
        str(tmp_path / "out"),
    ]
    subprocess.run(command, cwd=ROOT, check=True)
    truth = json.loads((tmp_path / "truth" / "truth.json").read_text())
    assert set(truth) == {p.name for p in (tmp_path / "out").iterdir()} and len(truth) == 2
    assert not list((tmp_path / "out").rglob("*.json"))
    refused = subprocess.run(
        [*command, "--truth", str(tmp_path / "out" / "x")], cwd=ROOT, capture_output=True, text=True
    )
    assert refused.returncode == 2 and "must not lie among the cases" in refused.stderr
