"""What a machine's model leaves out is found, named with its size, written down, and then nothing
is left."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from postproc import recordings
from postproc.cli import main
from postproc.diagnose import report
from postproc.diagnose.analysis import diagnose
from postproc.machine import places
from postproc.machine.file import read_machine
from tests.diagnose.command import diagnosed, simulated

ROOT = Path(__file__).resolve().parents[2]
PRACTICE = ROOT.parent / "shared" / "recordings" / "practice"
STUDER = str(ROOT / "machines" / "studer-s36")
TESTS = ("positioning:Z", "positioning:X", "diagonal:XZ", "ballbar:XZ")


def simulate(
    folder: Path,
    effects: tuple[str, ...] = (),
    seed: int = 1,
    tests=TESTS,
    rate: float = 50.0,
    machine: str = STUDER,
) -> list[str]:
    """Recordings of a machine that has more errors than its file says; circles at a rate in Hz."""
    extra = [word for effect in effects for word in ("--with", effect)]
    files = []
    for k, test in enumerate(tests):
        at = ["--set", f"rate={rate:g}"] if test.startswith("ballbar") else []
        files += simulated([folder / f"r{k + 1}.csv"], [test], machine, seed + k, *extra, *at)
    return files


def answer(files: list[str], machine: str, folder: Path, *more: str) -> dict:
    return diagnosed(files, machine, folder / "answer.json", *more)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """By an effect: recordings of a machine that has it, what they tell, and the folder with the
    machine that was written and with what is left. Each is made once and stays as it is."""

    @cache
    def of(effect: str) -> tuple[list[str], dict, Path]:
        folder = tmp_path_factory.mktemp("found")
        files = simulate(folder, (effect,))
        written = "--write-machine", str(folder / "found"), "--residuals", str(folder / "r.csv")
        return files, answer(files, STUDER, folder, *written), folder

    return of


def accepted(told: dict) -> list[tuple[str, str]]:
    return [(e["effect"], e["axis"]) for e in told["effects"] if e["status"] == "accepted"]


@pytest.mark.parametrize(
    "effect, name, axis, parameter, value",
    [
        ("backlash:Z:size_um=7", "backlash", "Z", "size_um", 7.0),
        ("squareness:XZ:urad=60", "squareness", "XZ", "urad", 60.0),
        ("scale:X:ppm=40", "scale", "X", "ppm", 40.0),
        ("servo_lag:X:tau_ms=0.3", "servo_lag", "X", "tau_ms", 0.3),
        ("cyclic:Z:period_mm=11.3,amplitude_um=3,phase_deg=40", "cyclic", "Z", "amplitude_um", 3.0),
    ],
)
def test_one_effect_is_found_and_then_nothing_is_left(
    tmp_path, found, effect, name, axis, parameter, value
):
    files, told, folder = found(effect)
    assert told["verdict"] == "left-out-physics"
    first = told["effects"][0]
    names = [f"{first['effect']}:{first['axis']}", *first["equivalent"]]
    assert f"{name}:{axis}" in names
    if first["effect"] == name and first["axis"] == axis:
        low, high = first["parameters"][parameter]["ci95"]
        assert low - 0.02 * abs(value) <= value <= high + 0.02 * abs(value)
    fit = told["fit"]
    assert fit["rms_after_um"] < 1.3 * fit["noise_floor_um"] < fit["rms_before_um"]
    assert 0.90 <= fit["coverage95"]
    assert told["mismatch"] and all(m["p_value"] <= 0.01 for m in told["mismatch"])
    lines = (folder / "r.csv").read_text().splitlines()
    assert lines[0] == "recording,row,signal,measured_um,before_um,after_um,held_out"
    after = np.array([float(line.split(",")[5]) for line in lines[1:] if line.endswith(",1")])
    assert np.sqrt(np.mean(after**2)) == pytest.approx(fit["rms_after_um"], rel=1e-3)
    again = answer(files, str(folder / "found"), tmp_path)
    assert again["verdict"] == "nothing-left-out" and not again["effects"]


@pytest.mark.parametrize("effect", ["backlash:Z:size_um=7", "squareness:XZ:urad=60"])
def test_the_machine_that_was_written_explains_itself_on_another_day(tmp_path, found, effect):
    """As it explains the real one, above: its recordings hold nothing more for its file, and the
    old file misses the effect in them."""
    _, told, folder = found(effect)
    machine = str(folder / "found")
    assert {e.name for e in read_machine(folder / "found").effects} == {
        e["effect"] for e in told["effects"] if e["status"] == "accepted" and e["kind"] == "machine"
    }
    files = simulate(tmp_path, seed=50, machine=machine)
    rest = answer(files, machine, tmp_path)
    assert rest["verdict"] == "nothing-left-out" and not rest["effects"]
    missed = answer(files, STUDER, tmp_path)
    for was, now in zip(told["effects"], missed["effects"], strict=True):
        assert was["effect"] in {
            now["effect"],
            *(name.partition(":")[0] for name in now["equivalent"]),
        }


@pytest.mark.parametrize("seed", [11, 21, 31])
def test_nothing_is_found_where_nothing_is(tmp_path, seed):
    told = answer(simulate(tmp_path, seed=seed), STUDER, tmp_path)
    assert told["verdict"] == "nothing-left-out"
    assert not told["effects"] and told["unknown"] is None
    assert told["detection_limits_um"]["backlash:Z"] < 2.0  # it says what it would have seen
    assert all(size >= 0.7 for size in told["detection_limits_um"].values())
    unseen = {f"{spot['effect']}:{spot['axis'] or ''}" for spot in told["not_visible"]}
    # what can not be seen has no limit
    assert unseen and not unseen & set(told["detection_limits_um"])


def test_an_instrument_never_reaches_the_machine(tmp_path):
    """A laser that is not parallel to the axis, and a machine with lost motion: only the second is
    written down."""
    files = simulate(tmp_path, ("backlash:Z:size_um=7",))
    text = Path(files[1]).read_text().splitlines()
    at = text.index(next(line for line in text if line.startswith("run,")))
    names = text[at].split(",")
    x, y = names.index("X_mm"), names.index("reading_um")
    for k in range(at + 1, len(text)):
        cells = text[k].split(",")
        cells[y] = f"{float(cells[y]) - 60e-3 * float(cells[x]):.4f}"  # -60 um/m of beam length
        text[k] = ",".join(cells)
    Path(files[1]).write_text("\n".join(text) + "\n")
    told = answer(files, STUDER, tmp_path, "--write-machine", str(tmp_path / "found"))
    assert {("backlash", "Z"), ("cosine", "X")} <= set(accepted(told))
    written = [e.name for e in read_machine(tmp_path / "found").effects]
    assert written == ["backlash"]


def test_the_written_effect_has_its_interval(found):
    """Half of the 95 % interval stands beside the size, where it was fitted; the play over which it
    is taken up was not."""
    _, told, folder = found("backlash:Z:size_um=7")
    low, high = told["effects"][0]["parameters"]["size_um"]["ci95"]
    (term,) = read_machine(folder / "found").effects
    assert [(one.name, one.parameters) for one in term.spread] == [
        ("size_um", {"size_um": pytest.approx((high - low) / 2, rel=0.02)})
    ]
    assert 0 < high - low < 2


def test_what_even_targets_hide_is_said(tmp_path):
    """Targets every 30 mm: a screw of 10 mm could swing as it likes; the tool says so, and which
    test would show it."""
    rng = np.random.default_rng(8)
    head = (
        '# format = "gcomp-recording/1"\n# kind = "targets"\n# quantity = "displacement"\n#'
        " sensitive = { X = 0.0, Z = 1.0 }\n"
    )
    machine = places.load(STUDER)
    rows = []
    for run in (1, 2, 3):
        for way, z in [(1, 30.0 * k) for k in range(17)] + [
            (-1, 30.0 * k) for k in range(16, -1, -1)
        ]:
            position, approach = np.array([[50.0], [z]]), np.array([[1.0], [float(way)]])
            off = machine.deviation(position, approach)[1, 0] * 1000 + rng.normal(0, 0.4)
            rows.append(f"{run},{len(rows) * 6},50.0,{z},1,{way},{off:.2f}")
    file = tmp_path / "even.csv"
    file.write_text(
        head + "run,t_s,X_mm,Z_mm,approach_X,approach_Z,reading_um\n" + "\n".join(rows) + "\n"
    )
    told = answer([str(file)], STUDER, tmp_path)
    assert told["verdict"] == "nothing-left-out"
    hidden = [v for v in told["not_visible"] if v["effect"] == "cyclic" and v["axis"] == "Z"]
    assert (
        len(hidden) == 1
        and "even steps of 30 mm" in hidden[0]["why"]
        and "period:Z" in hidden[0]["next_test"]
    )
    assert all(v["why"] and v["next_test"] for v in told["not_visible"])


def test_the_order_of_files_does_not_matter(tmp_path, found):
    files, one, _ = found("backlash:Z:size_um=7")
    other = answer(files[::-1], STUDER, tmp_path)
    assert accepted(one) == accepted(other)
    sizes = [told["effects"][0]["parameters"]["size_um"]["value"] for told in (one, other)]
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-3)


@pytest.mark.parametrize(
    "change, why",
    [
        (lambda t: t.replace("reading_um", "reading"), "reading_um is missing"),
        (lambda t: t.split("run,")[0], "no header row"),
        (lambda t: "", "empty"),
        (lambda t: t.replace("gcomp-recording/1", "gcomp-recording/9"), "gcomp-recording/9"),
        (lambda t: t.replace("X_mm", "Y_mm"), "which is no axis of studer-s36"),
    ],
)
def test_unusable_input_is_refused(tmp_path, capsys, change, why):
    file = Path(simulate(tmp_path, tests=("positioning:Z",))[0])
    file.write_text(change(file.read_text()))
    capsys.readouterr()
    assert main(["diagnose", str(file), "--machine", STUDER]) == 2
    told = capsys.readouterr().err
    assert why in told and file.name in told
    assert "Traceback" not in told


def test_a_row_that_can_not_be_used_is_listed(tmp_path):
    file = Path(simulate(tmp_path, tests=("positioning:Z",))[0])
    lines = file.read_text().splitlines()
    cells = lines[-5].split(",")
    cells[
        [
            i
            for i, n in enumerate(next(x for x in lines if x.startswith("run,")).split(","))
            if n == "reading_um"
        ][0]
    ] = "nan"
    lines[-5] = ",".join(cells)
    file.write_text("\n".join(lines) + "\n")
    told = answer([str(file)], STUDER, tmp_path)
    assert any(f["row"] == len(lines) - 4 for f in told["data_faults"])


def thinned(data: bytes) -> bytes:
    """A recording: every second sample of motions, every twelfth of long traces."""
    lines = data.splitlines(keepends=True)
    head = next(k for k, line in enumerate(lines) if not line.startswith(b"#")) + 1
    step = 1 if len(lines) < 2000 else 2 if len(lines) < 20_000 else 12
    return b"".join(lines[:head] + lines[head::step])


@pytest.mark.skipif(not PRACTICE.is_dir(), reason="the practice cases are not here")
@pytest.mark.parametrize(
    "case", sorted(p.name for p in PRACTICE.iterdir() if p.is_dir()) if PRACTICE.is_dir() else []
)
def test_practice_cases(case):
    """Every visible effect is named or in the set; nothing is accepted where nothing is."""
    truth = json.loads((PRACTICE / "answers.json").read_text())[case]
    files = sorted((PRACTICE / case).glob("r*.csv"))
    sources = [recordings.Source(f.name, thinned(f.read_bytes())) for f in files]
    d = diagnose([*map(recordings.read, sources)], read_machine(PRACTICE / case / "machine"))
    told = report.as_json(d, [source.sha256 for source in sources])
    json.dumps(told, allow_nan=False)
    names = {f"{e['effect']}:{e['axis']}" for e in told["effects"]} | {
        k for e in told["effects"] for k in e["equivalent"]
    }
    for effect in truth:
        if effect["visible"]:
            assert f"{effect['effect']}:{effect['axis']}" in names
    if not truth:
        assert told["verdict"] == "nothing-left-out"


def test_scipy_is_loaded_only_where_it_is_needed():
    import subprocess
    import sys

    code = (
        "import sys, postproc.cli, postproc.commands.compensate, postproc.filter; assert 'scipy'"
        " not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)
    assert places.load(STUDER).name == "studer-s36"


def test_a_vibration_whose_phase_differs_from_run_to_run(tmp_path):
    """The run that is held out swings in a phase of its own: it is not explained, and nothing
    breaks."""
    file = Path(simulate(tmp_path, tests=("ballbar:XZ",), rate=250.0)[0])
    lines = file.read_text().splitlines()
    at = lines.index(next(line for line in lines if line.startswith("run,")))
    names = lines[at].split(",")
    centre = json.loads(
        next(x for x in lines if "centre" in x)
        .split("=", 1)[1]
        .replace(" = ", ":")
        .replace("X", '"X"')
        .replace("Z", '"Z"')
        .replace("Y", '"Y"')
    )
    rng = np.random.default_rng(5)
    phase: dict[str, float] = {}
    for k in range(at + 1, len(lines)):
        cells = dict(zip(names, lines[k].split(","), strict=True))
        key = cells["run"] + cells["sense"]
        unit = np.array(
            [float(cells["X_cmd_mm"]) - centre["X"], float(cells["Z_cmd_mm"]) - centre["Z"]]
        )
        oscillation = 4.0 * np.sin(
            2 * np.pi * 17.0 * float(cells["t_s"]) + phase.setdefault(key, rng.uniform(0, 6.28))
        )
        cells["radial_um"] = (
            f"{float(cells['radial_um']) + oscillation * unit[0] / np.linalg.norm(unit):.2f}"
        )
        lines[k] = ",".join(cells[n] for n in names)
    file.write_text("\n".join(lines) + "\n")
    told = answer([str(file)], STUDER, tmp_path)
    vibrations = [e["parameters"] for e in told["effects"] if e["effect"] == "vibration"]
    largest = max(vibrations, key=lambda p: p["amplitude_um"]["value"])
    assert largest["frequency_hz"]["value"] == pytest.approx(17.0, abs=0.1)
    assert largest["amplitude_um"]["value"] == pytest.approx(4.0, rel=0.3)
