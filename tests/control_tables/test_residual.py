"""`gcomp export --residual`: the control holds its part, the machine folder the rest; together they
are the machine.

Models of controls (models.py) read the files as the controls do.
"""

from __future__ import annotations

import re
from pathlib import Path

import models
import models_part2
import numpy as np
import pytest

from postproc import cli
from postproc.commands.reading import with_control_tables
from postproc.machine.file import read_machine

ROOT = Path(__file__).resolve().parents[2]
UM = 1e-3
SIDE = np.array([-1.0, 1.0])


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def exported(place: Path, control: str, *words, machine="example-mill"):
    """The files for the control, and the machine for the rest."""
    out = ("-o", f"{place / 'tables'}/", "--residual", place / "rest")
    assert gcomp("export", "--machine", machine, "--control", control, *out, *words) == 0
    files = {p.name: p.read_bytes() for p in (place / "tables").iterdir()}
    return files, with_control_tables(read_machine(place / "rest"))


def model_of(control: str, files: dict[str, bytes]):
    """(what the control adds to a command, which components it holds)."""
    if control == "linuxcnc":
        return models.linuxcnc(files, "0"), ("EXX", "EYY", "EZZ")
    return models.heidenhain(files), tuple(f"E{a}{m}" for m in "XYZ" for a in "XYZ")


def added(control: str, files, q: np.ndarray, way: np.ndarray) -> np.ndarray:
    """(3, N) mm that the control adds at commands (3, N)."""
    model, names = model_of(control, files)
    total = np.zeros_like(q)
    for name in names:
        i, j = "XYZ".index(name[1]), "XYZ".index(name[2])
        for s in SIDE:
            of = way[j] == s
            total[i, of] += model(name[2], name[1], q[j, of], s)
    return total


@pytest.mark.parametrize("control", ["linuxcnc", "heidenhain"])
def test_the_control_and_the_rest_are_the_machine(tmp_path, capsys, control):
    """At 400 random places and sides: what the machine does with the control's table at work is
    what the rest says, but for one shift of each axis (a control adds nothing at its reference)."""
    files, rest = exported(tmp_path, control)
    whole = read_machine(ROOT / "machines" / "example-mill")
    rng = np.random.default_rng(2)
    q = np.stack([rng.uniform(*whole.axes[x].travel, 400) for x in "XYZ"])
    way = rng.choice(SIDE, (3, 400))
    apart = whole.deviation(q, way) + added(control, files, q, way) - rest.deviation(q, way)
    assert np.ptp(apart, axis=1).max() < 0.3 * UM  # 256 points of a table and its last digit
    assert np.abs(rest.deviation(q, way)[0] - whole.deviation(q, way)[0]).max() > 20 * UM
    assert f"wrote {tmp_path / 'rest'}" in capsys.readouterr().out


def test_a_program_for_the_rest_ends_where_it_belongs_with_the_table_at_work(tmp_path, capsys):
    files, _ = exported(tmp_path, "linuxcnc")
    whole = read_machine(ROOT / "machines" / "example-mill")
    targets = [(-300 + 50 * k, -150 + 25 * k, 10 * k) for k in range(12)]
    lines = [
        "G21 G90 G54",
        "G0 X-320 Y-160 Z-10",
        *(f"G1 X{x} Y{y} Z{z} F1000" for x, y, z in targets),
    ]
    (tmp_path / "a.nc").write_text("\n".join(lines) + "\n")
    assert (
        gcomp(
            tmp_path / "a.nc", "--machine", tmp_path / "rest", "-o", tmp_path / "b.nc", "--verify"
        )
        == 0
    )
    ends, place = [], {}
    for line in (tmp_path / "b.nc").read_text().splitlines():
        place |= {x: float(v) for x, v in re.findall(r"([XYZ])(-?[\d.]+)", line.split("(")[0])}
        ends.append([place.get(x, np.nan) for x in "XYZ"])
    command = np.array(ends).T
    command[2] -= 250.0  # G54 of example-mill
    wanted = np.array(targets, float).T - np.array([[0.0], [0.0], [250.0]])
    near = [int(np.nanargmin(np.abs(command - w[:, None]).max(axis=0))) for w in wanted.T]
    c = command[:, near]
    up = np.ones_like(c)
    slides = c + added("linuxcnc", files, c, up)
    off = slides + whole.deviation(slides, up) - wanted
    assert np.abs(whole.deviation(wanted, up)).max() > 20 * UM
    assert np.abs(off).max() < 1.5 * UM  # the tolerance, and half an increment
    assert "the machine's model" not in capsys.readouterr().err


def test_klipper_is_told_the_diagonals_that_a_caliper_read(tmp_path, capsys):
    """The square of 100 mm of which machines/README.md makes example-printer (141.62 and 141.22)
    comes back in SET_SKEW XY=AC,BD,AD (klippy/extras/skew_correction.py), and the rest of that
    machine has no squareness left."""
    files, rest = exported(tmp_path, "klipper", machine="example-printer")
    found = re.search(r"XY=([\d.]+),([\d.]+),100\b", files["example-printer.gcode"].decode())
    assert [float(v) for v in found.groups()] == pytest.approx([141.62, 141.22], abs=2e-3)
    q = np.array([[50.0, 50.0], [0.0, 200.0], [0.0, 0.0]])
    off = rest.deviation(q, np.zeros_like(q))
    assert off[0, 0] == pytest.approx(off[0, 1], abs=0.01 * UM)


@pytest.mark.parametrize(
    "control, model",
    [
        ("klipper", models_part2.Klipper),
        ("marlin", models_part2.Marlin),
        ("reprapfirmware", models_part2.RepRap),
    ],
)
def test_skew_of_a_machine_whose_other_axes_lean_too(tmp_path, capsys, control, model):
    """example-mill's X leans towards Y and Z, its Y towards Z as well, which a skew factor could
    only take out with the part turned: the program corrects that, and firmware and program are the
    machine. The start position counts as +, so all go up."""
    files, rest = exported(tmp_path, control)
    assert "turned" not in capsys.readouterr().out
    (text,) = (data.decode() for data in files.values())
    firmware = model(text)
    whole = read_machine(ROOT / "machines" / "example-mill")
    rng = np.random.default_rng(2)
    q = np.stack([rng.uniform(*whole.axes[x].travel, 400) for x in "XYZ"])
    way = np.ones_like(q)
    sent = np.array([firmware.sent(p, w) for p, w in zip(q.T, way.T, strict=True)]).T
    apart = whole.deviation(q, way) + (sent - q) - rest.deviation(q, way)
    assert np.ptp(apart, axis=1).max() < 0.3 * UM
    assert np.abs(sent - q).max() > 10 * UM


def test_a_mean_table_leaves_the_reversal_to_the_program(tmp_path, capsys):
    _, rest = exported(tmp_path, "siemens-enc-comp")
    assert "leave the control's own backlash of X, Y, Z as it was" in capsys.readouterr().out
    whole = read_machine(ROOT / "machines" / "example-mill")
    q, up = np.array([[50.0], [60.0], [-90.0]]), np.ones((3, 1))
    reversal = [(m.deviation(q, -up) - m.deviation(q, up))[:, 0] for m in (whole, rest)]
    assert reversal[1] == pytest.approx(reversal[0], abs=1e-6) and (reversal[0] > 5 * UM).all()


@pytest.mark.parametrize(
    "words, says",
    [
        (("--control", "linuxcnc", "--unit", "inch"), "beside what was written"),
        (("--control", "etalon"), "nothing is left for --residual"),
    ],
)
def test_what_would_not_be_read_back_is_refused(tmp_path, capsys, words, says):
    out = ("-o", f"{tmp_path / 'tables'}/", "--residual", tmp_path / "rest")
    assert gcomp("export", "--machine", "example-mill", *words, *out) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "rest").exists() and not (tmp_path / "tables").exists()
