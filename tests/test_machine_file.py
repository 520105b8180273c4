"""A machine folder is trusted with somebody's part: what is wrong in it is refused with file, line
and the way out."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc.errors import MachineError, UsageError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.units import UM, URAD

ROOT = Path(__file__).resolve().parents[1]
SEED = ROOT / "proof" / "seed" / "tables"
NANOMETRE = 1e-6  # mm

TOML = """\
format  = "gcomp-machine/1"
name    = "example-grinder"
title   = "Two-axis cylindrical grinder"
control = "fanuc-lathe"            # dialect
chain   = "w-b-Z-X-t"              # workpiece, bed, then who carries whom, to the tool
diameter = ["X"]
source  = "where the numbers come from"

[axes.Z]
travel = [-5.0, 520.0]             # mm, slide positions
least_increment = 0.0001
table  = "Z.csv"
measured_at = { X = 0.0 }
max_velocity = 10000.0             # mm/min
max_acceleration = 1500.0          # mm/s2

[axes.X]
travel = [-5.0, 175.0]
least_increment = 0.0001
table  = "X.csv"

[squareness]
B0X = -382.352941                  # urad

[tool]
X = 0.0
Z = 0.0

[offsets]
G54 = { X = 0.0, Z = 0.0 }

[limits]
max_correction = 0.5               # mm
max_slope = 0.005                  # mm per mm
outside = "error"

[[effect]]
name = "backlash"
axis = "X"
size_um = 9.0
source = "diagnosed from a recording on 2026-11-30"
"""
Z_CSV = """\
# made up
Z_mm,EZZ_um_fwd,EZZ_um_rev,EXZ_um,EBZ_urad
0,1,-1,2,10
100,3,0,1,20
250,2,1,0,-5
"""
X_CSV = """\
X_mm,EXX_um,EZX_um
0,0,0
50,5,-1
170,2,3
"""


def folder(path: Path, toml=TOML, z=Z_CSV, x=X_CSV) -> Path:
    """A machine folder of these texts (str or bytes; None: no such file)."""
    for name, text in (("machine.toml", toml), ("Z.csv", z), ("X.csv", x)):
        if text is not None:
            (path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def swap(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
    return text.replace(old, new)


def refusal(path: Path) -> MachineError:
    with pytest.raises(MachineError) as caught:
        read_machine(path)
    return caught.value


def line_of(text: str, part: str) -> int:
    """Line, from 1, in which `part` ends: with `part` = a key, that of the key."""
    assert text.count(part) == 1, f"{part!r} stands {text.count(part)} times"
    return text.count("\n", 0, text.index(part) + len(part.rstrip("\n"))) + 1


def check(error: MachineError, file: Path, line: int, says: tuple[str, ...]) -> None:
    assert error.place is not None
    assert (error.place.file, error.place.line) == (str(file), line), str(error)
    assert str(error).startswith(f"{file}:{line}: ")
    for part in says:
        assert part in str(error)
    assert "None" not in str(error), "a key that is missing is called so"


# -- what is accepted ------------------------------------------------------------------------------


def test_the_example_of_the_format_is_a_machine(tmp_path):
    machine = read_machine(folder(tmp_path))
    assert (machine.name, machine.control, machine.letters) == (
        "example-grinder",
        "fanuc-lathe",
        ("X", "Z"),
    )
    assert machine.chain.axes == ("Z", "X")
    assert machine.chain.workpiece_side == 0
    assert machine.diameter == ("X",)
    assert machine.axes["Z"].travel == (-5.0, 520.0)
    assert machine.axes["X"].least_increment == 0.0001
    assert machine.square["X"] == approx([0, -382.352941 * URAD, 0])
    assert machine.offsets == {"G54": {"X": 0.0, "Z": 0.0}}
    assert (machine.limits.max_correction, machine.limits.max_slope, machine.limits.outside) == (
        0.5,
        0.005,
        "error",
    )
    assert [(e.name, e.axis, e.parameters) for e in machine.effects] == [
        ("backlash", "X", {"size_um": 9.0, "play_mm": 0.0})
    ]
    table = machine.tables["Z"]
    assert table.nodes == approx([0, 100, 250])
    assert table.forward[2] == approx(np.array([1, 3, 2]) * UM)
    assert table.reverse[2] == approx(np.array([-1, 0, 1]) * UM)
    assert table.forward[0] == approx(np.array([2, 1, 0]) * UM)
    assert (table.forward[4] == table.reverse[4]).all()
    assert table.forward[4] == approx(np.array([10, 20, -5]) * URAD)
    assert not table.forward[[1, 3, 5]].any()


@pytest.mark.parametrize(
    "dress",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: "# first\n\n" + text.replace("\n0,", "\n  # in between\n\n0,") + "# last",
        lambda text: text.replace(",", " , "),
        lambda text: text.rstrip("\n"),
    ],
    ids=["CRLF", "BOM", "comments and empty lines", "blanks", "no last newline"],
)
def test_the_dress_of_a_table_does_not_matter(tmp_path, dress):
    plain, dressed = (tmp_path / name for name in ("plain", "dressed"))
    plain.mkdir(), dressed.mkdir()
    a = read_machine(folder(plain)).tables["Z"]
    b = read_machine(folder(dressed, z=dress(Z_CSV))).tables["Z"]
    assert (a.nodes == b.nodes).all()
    assert (a.forward == b.forward).all()
    assert (a.reverse == b.reverse).all()


def test_the_map_has_a_digest_of_all_its_files(tmp_path):
    digests = []
    for i, files in enumerate(
        [{}, {"toml": TOML + "\n"}, {"z": Z_CSV + "\n"}, {"x": X_CSV + "\n"}, {}]
    ):
        path = tmp_path / str(i)
        path.mkdir()
        digests.append(read_machine(folder(path, **files)).digest)
    assert digests[0] == digests[-1]
    assert len(set(digests)) == 4


def test_sections_that_are_not_needed_may_be_missing(tmp_path):
    short = """\
format = "gcomp-machine/1"
name = "short"
control = "linuxcnc"
chain = "w-X-b-Z-t"
[axes.X]
travel = [0, 10]
least_increment = 0.001
[axes.Z]
travel = [0, 10]
least_increment = 0.001
"""
    machine = read_machine(folder(tmp_path, toml=short))
    assert machine.is_zero
    assert machine.chain.workpiece_side == 1


# -- machine.toml ----------------------------------------------------------------------------------

# old, new, what stands in the line that is named, what is said
REFUSED = {
    "another format": (
        "gcomp-machine/1",
        "gcomp-machine/2",
        "format ",
        ("'gcomp-machine/2'", "'gcomp-machine/1'"),
    ),
    "no control": (
        'control = "fanuc-lathe"            # dialect\n',
        "",
        "format ",
        ("control is missing",),
    ),
    "control no text": ('"fanuc-lathe"', "7", "control =", ("control = 7 is not a text",)),
    "unknown key": ("title   =", "titel =", "titel", ("'titel'", "title", "source")),
    "unknown section": ("[tool]", "[tools]", "[tools]", ("'tools'", "tool")),
    "unknown key of an axis": (
        "measured_at",
        "measuredat",
        "measuredat",
        ("'measuredat'", "[axes.Z]", "measured_at"),
    ),
    "unknown key of limits": (
        "max_slope",
        "slope_max",
        "slope_max",
        ("'slope_max'", "[limits]", "max_slope"),
    ),
    "unknown key of tool": ("[tool]\nX", "[tool]\nR", "[tool]\nR", ("'R'", "[tool]", "X, Y, Z")),
    "unknown key of an effect": (
        "size_um",
        "size_mm",
        "size_mm",
        ("'size_mm'", "[effect]", "size_um"),
    ),
    "no travel": (
        "travel = [-5.0, 520.0]             # mm, slide positions\n",
        "",
        "[axes.Z]",
        ("travel",),
    ),
    "travel no list": (
        "[-5.0, 520.0]",
        "520.0",
        "travel = 520.0",
        ("520.0", "two ascending numbers, mm"),
    ),
    "travel descending": (
        "[-5.0, 520.0]",
        "[520.0, -5.0]",
        "travel = [520.0",
        ("two ascending numbers, mm",),
    ),
    "travel of one": (
        "[-5.0, 520.0]",
        "[520.0]",
        "travel = [520.0]",
        ("two ascending numbers, mm",),
    ),
    "travel not finite": (
        "[-5.0, 520.0]",
        "[-inf, 520.0]",
        "travel = [-inf",
        ("two ascending numbers, mm",),
    ),
    "travel of truths": (
        "[-5.0, 520.0]",
        "[false, true]",
        "travel = [false",
        ("two ascending numbers, mm",),
    ),
    "no least increment": (
        'least_increment = 0.0001\ntable  = "Z',
        'table  = "Z',
        "[axes.Z]",
        ("least_increment",),
    ),
    "least increment no number": (
        'least_increment = 0.0001\ntable  = "Z',
        'least_increment = "fine"\ntable  = "Z',
        '"fine"',
        ("'fine' is not a number",),
    ),
    "least increment no power of ten": (
        'least_increment = 0.0001\ntable  = "Z',
        'least_increment = 0.0005\ntable  = "Z',
        "= 0.0005",
        ("0.0005", "power of ten"),
    ),
    "table no text": ('"Z.csv"', "1", "table  = 1", ("table = 1 is not a text",)),
    "table missing": ('"Z.csv"', '"ZZ.csv"', "ZZ.csv", ("there is no table", "ZZ.csv")),
    "measured at no table": (
        "{ X = 0.0 }",
        "0.0",
        "measured_at",
        ("measured_at = 0.0", "{ X = 0.0 }"),
    ),
    "measured at nowhere": (
        "measured_at = { X",
        "measured_at = { A",
        "measured_at",
        ("'A'", "no linear axis"),
    ),
    "measured at no number": (
        "measured_at = { X = 0.0 }",
        'measured_at = { X = "home" }',
        "measured_at",
        ("'home' is not a number",),
    ),
    "velocity no number": ("10000.0", '"fast"', '"fast"', ("'fast' is not a number",)),
    "axis of no machine": ("[axes.X]", "[axes.D]", "[axes.D]", ("X Y Z A B C",)),
    "diameter no list": ('["X"]', '"X"', "diameter", ("list axes",)),
    "diameter of no axis": ('["X"]', '["Y"]', "diameter", ("'Y'", "axes of the machine")),
    "diameter of a list": ('["X"]', '[["X"]]', "diameter", ("axes of the machine",)),
    "squareness of itself": ("B0X", "A0X", "A0X", ("'A0X'", "B0X, C0Y, A0Z")),
    "squareness of no axis": ("B0X", "A0Y", "A0Y", ("'A0Y'", "B0X, C0Y, A0Z")),
    "squareness with a wrong name": ("B0X", "XZ", "XZ", ("'XZ'", "B0X, C0Y, A0Z")),
    "squareness no number": ("-382.352941", '"-0.4 mrad"', "B0X", ("'-0.4 mrad' is not a number",)),
    "tool no number": (
        "[tool]\nX = 0.0",
        "[tool]\nX = true",
        "X = true",
        ("True is not a number",),
    ),
    "offset of no name": ("G54", "G60", "G60", ("'G60'", "G54 = { X = 0.0, Z = 0.0 }")),
    "offset of three digits": ("G54", "T101", "T101", ("'T101'",)),
    "offset no place": (
        "G54 = { X = 0.0, Z = 0.0 }",
        "G54 = 0.0",
        "G54",
        ("'G54'", "{ X = 0.0, Z = 0.0 }"),
    ),
    "offset of no axis": (
        "{ X = 0.0, Z = 0.0 }",
        "{ X = 0.0, Y = 0.0 }",
        "G54",
        ("'Y'", "no axis of the machine"),
    ),
    "offset no number": (
        "{ X = 0.0, Z = 0.0 }",
        '{ X = 0.0, Z = "far" }',
        "G54",
        ("'far' is not a number",),
    ),
    "limit no number": (
        "0.5               #",
        '"0.5"  #',
        "max_correction",
        ("'0.5' is not a number",),
    ),
    "outside no choice": ('"error"', '"hold"', '"hold"', ("'hold'", '"error" or "clamp"')),
    "slope accepted by a text": (
        "max_slope = 0.005",
        'accept_slope = "yes"',
        "accept_slope",
        ("'yes'",),
    ),
    "reversal no choice": (
        "diameter",
        'reversal = "jump"\ndiameter',
        '"jump"',
        ("'jump'", "mean, step, ramp, off"),
    ),
    "effect unknown": (
        '"backlash"',
        '"backlsh"',
        '"backlsh"',
        ("there is no effect 'backlsh'", "backlash"),
    ),
    "effect without a name": ('name = "backlash"\n', "", "[[effect]]", ("name",)),
    "effect of no axis": ('axis = "X"', 'axis = "Y"', 'axis = "Y"', ("'Y'", "axis of the machine")),
    "effect of a list": ('axis = "X"', 'axis = ["X"]', "axis = [", ("['X']",)),
    "effect without its parameter": ("size_um = 9.0\n", "", "[[effect]]", ("size_um",)),
    "effect's parameter no number": (
        "9.0\nsource",
        '"9 um"\nsource',
        "size_um",
        ("'9 um' is not a number",),
    ),
    "effect as a plain table": ("[[effect]]", "[effect]", "[effect]", ("[[effect]]",)),
    "chain without workpiece": (
        '"w-b-Z-X-t"',
        '"b-Z-X-t"',
        "chain ",
        ("'b-Z-X-t'", "like w-b-Z-X-t"),
    ),
    "chain without bed": ('"w-b-Z-X-t"', '"w-Z-X-t"', "chain ", ("'w-Z-X-t'", "hold one b")),
    "chain without tool": ('"w-b-Z-X-t"', '"w-b-Z-X"', "chain ", ("end with t",)),
    "chain with an axis twice": ('"w-b-Z-X-t"', '"w-Z-b-Z-X-t"', "chain ", ("an axis twice",)),
    "chain with a stranger": ('"w-b-Z-X-t"', '"w-b-Z-Q-t"', "chain ", ("'Q' is not one of X Y Z",)),
    "chain with a rotary axis": (
        '"w-b-Z-X-t"',
        '"w-C-b-Z-X-t"',
        "chain ",
        ("the chain names C, and there is no [axes.C]",),
    ),
    "chain no text": ('"w-b-Z-X-t"', "1", "chain ", ("chain = 1 is not a text",)),
    "axis in the chain without section": (
        '"w-b-Z-X-t"',
        '"w-Y-b-Z-X-t"',
        "chain ",
        ("Y", "there is no [axes.Y]"),
    ),
    "axis not in the chain": (
        '"w-b-Z-X-t"',
        '"w-b-X-t"',
        "travel = [-5.0, 520.0]",
        ("axis Z", "w-b-X-t"),
    ),
    "no TOML": ("[-5.0, 175.0]", "[-5.0, 175.0]]", "175.0]]", ("not valid TOML",)),
    "a key twice": ("title   =", 'name = "b"\ntitle =', 'name = "b"', ("not valid TOML",)),
}


@pytest.mark.parametrize("name", REFUSED)
def test_machine_toml_is_refused_with_its_line(tmp_path, name):
    old, new, where, says = REFUSED[name]
    toml = swap(TOML, old, new)
    error = refusal(folder(tmp_path, toml=toml))
    check(error, tmp_path / "machine.toml", line_of(toml, where), says)


@pytest.mark.parametrize("section", ["tool", "limits", "squareness", "offsets", "axes", "effect"])
def test_a_section_that_is_a_number_is_refused(tmp_path, section):
    lines = TOML.splitlines(keepends=True)
    kept, mine = [], False
    for line in lines:
        mine = (
            line.lstrip("[").startswith((section + "]", section + "."))
            if line.startswith("[")
            else mine
        )
        kept += [] if mine else [line]
    toml = f"{section} = 3\n" + "".join(kept)
    error = refusal(folder(tmp_path, toml=toml))
    check(error, tmp_path / "machine.toml", 1, (section,))


@pytest.mark.parametrize("key", ["format", "chain"])
def test_a_missing_key_is_named(tmp_path, key):
    toml = "".join(line for line in TOML.splitlines(keepends=True) if not line.startswith(key))
    check(refusal(folder(tmp_path, toml=toml)), tmp_path / "machine.toml", 1, (key,))


def test_the_second_of_two_effects_is_refused_in_its_own_line(tmp_path):
    second = '\n[[effect]]\nname = "backlash"\naxis = "Z"\nsize_um = "7"\n'
    error = refusal(folder(tmp_path, toml=TOML + second))
    check(error, tmp_path / "machine.toml", line_of(TOML + second, '"7"'), ("'7' is not a number",))


def test_backlash_of_an_axis_that_turns_is_refused(tmp_path):
    turning = "\n[axes.C]\ntravel = [-360.0, 360.0]\nleast_increment = 0.001\n"
    toml = swap(TOML, 'axis = "X"', 'axis = "C"') + turning
    check(
        refusal(folder(tmp_path, toml=toml)),
        tmp_path / "machine.toml",
        line_of(toml, 'axis = "C"'),
        ("C",),
    )


def test_a_table_of_an_axis_that_turns_is_refused_or_harmless(tmp_path):
    turning = '\n[axes.C]\ntravel = [-360.0, 360.0]\nleast_increment = 0.001\ntable = "C.csv"\n'
    (tmp_path / "C.csv").write_text("C_mm,EXC_um\n-360,1\n360,2\n")
    try:
        machine = read_machine(folder(tmp_path, toml=TOML + turning))
    except MachineError as error:
        assert "C" in str(error)
        return
    correct(machine, b"G0 X20. Z10. C5.\nG1 X40. Z50. C9. F100\n")


def test_text_that_is_not_utf8_is_refused_in_its_line(tmp_path):
    toml = TOML.encode().replace(b"a recording", b"une mesure r\xe9p\xe9t\xe9e")
    check(
        refusal(folder(tmp_path, toml=toml)),
        tmp_path / "machine.toml",
        line_of(TOML, "a recording"),
        ("UTF-8",),
    )


def test_a_folder_without_machine_toml_says_what_a_machine_is(tmp_path):
    error = refusal(tmp_path)
    assert str(tmp_path) in str(error)
    assert "machine.toml" in str(error)
    assert "CSV" in str(error)


def test_names_that_there_are_not_are_answered_with_those_that_there_are():
    with pytest.raises(UsageError, match="no machine 'studer'") as caught:
        places.load("studer")
    assert "studer-s36" in str(caught.value)
    with pytest.raises(UsageError, match="no machine folder machines/studer"):
        places.load("machines/studer")


# -- tables ----------------------------------------------------------------------------------------

BAD_TABLES = {
    "wrong unit of a translation": ("EXZ_um", "EXZ_mm", 2, ("'EXZ_mm'", "EXZ_um")),
    "wrong unit of a rotation": ("EBZ_urad", "EBZ_um", 2, ("'EBZ_um'", "EBZ_urad")),
    "no unit": ("EXZ_um", "EXZ", 2, ("'EXZ'", "EXZ_um")),
    "unknown component": (
        "EXZ_um",
        "EQZ_um",
        2,
        ("'EQZ_um'", "axis Z", "EXZ_um, EYZ_um, EZZ_um, EAZ_urad"),
    ),
    "component of another axis": ("EXZ_um", "EXX_um", 2, ("'EXX_um'", "axis Z")),
    "column without a name": ("EXZ_um", "", 2, ("''",)),
    "first column of another axis": ("Z_mm", "X_mm", 2, ("'X_mm'", "'Z_mm'")),
    "first column without a unit": ("Z_mm", "Z", 2, ("'Z'", "'Z_mm'")),
    "first column missing": ("Z_mm,", "", 2, ("'EZZ_um_fwd'", "'Z_mm'")),
    "only forward": ("EZZ_um_rev", "EYZ_um", 2, ("EZZ", "_fwd", "_rev")),
    "forward and both": ("EZZ_um_rev", "EZZ_um", 2, ("EZZ", "_fwd", "_rev")),
    "a column twice": ("EBZ_urad", "EXZ_um", 2, ("'EXZ_um' stands twice",)),
    "nodes that go back": ("100,3", "300,3", 5, ("Z_mm = 250", "does not ascend", "300")),
    "a node twice": ("100,3", "250,3", 5, ("Z_mm = 250", "does not ascend")),
    "a value missing at the end": ("100,3,0,1,20", "100,3,0,1", 4, ("4 values", "5 columns")),
    "a value missing within": (
        "100,3,0,1,20",
        "100,3,,1,20",
        4,
        ("'' is not a number", "every node"),
    ),
    "a value too many": ("100,3,0,1,20", "100,3,0,1,20,", 4, ("6 values", "5 columns")),
    "a comma for a point": ("100,3", "100,3,5", 4, ("6 values", "5 columns")),
    "not a number": ("100,3", "100,nan", 4, ("NaN",)),
    "infinity": ("100,3", "100,-inf", 4, ("infinity",)),
    "a node at infinity": ("250,2", "inf,2", 5, ("infinity",)),
    "a text": ("100,3", "100,3um", 4, ("'3um' is not a number",)),
    "a number that no table has": ("100,3", "1_00,3", 4, ("'1_00' is not a number",)),
    "a comment behind a value": ("20\n", "20 # again\n", 4, ("'20 # again' is not a number",)),
    "too steep": (
        "100,3",
        "0.1,3",
        4,
        ("20.00 um/mm", "Z = 0 and 0.1", "limit 5 um/mm", "max_slope", "accept_slope = true"),
    ),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_a_table_is_refused_with_its_line(tmp_path, name):
    old, new, line, says = BAD_TABLES[name]
    z = swap(Z_CSV, old, new)
    error = refusal(folder(tmp_path, z=z))
    check(error, tmp_path / "Z.csv", line, says)
    assert z.splitlines()[line - 1] in str(error) or "steep" in name


@pytest.mark.parametrize("rows", [0, 1])
def test_a_table_needs_two_nodes(tmp_path, rows):
    z = "".join(Z_CSV.splitlines(keepends=True)[: 2 + rows])
    assert f"{rows} nodes" in str(refusal(folder(tmp_path, z=z)))


@pytest.mark.parametrize("text", ["", "# nothing\n", b"\xef\xbb\xbf"])
def test_an_empty_table_is_refused(tmp_path, text):
    check(refusal(folder(tmp_path, z=text)), tmp_path / "Z.csv", 1, ("0 nodes",))


def test_a_table_that_is_not_utf8_is_refused(tmp_path):
    error = refusal(folder(tmp_path, z=b"# mesur\xe9\n" + Z_CSV.encode()))
    check(error, tmp_path / "Z.csv", 1, ("UTF-8",))


def test_a_table_of_another_kind_is_refused(tmp_path):
    error = refusal(folder(tmp_path, z="Z_mm,EZZ_um\n0," + "3" * 200_000 + "\n"))
    assert (error.place.file, error.place.line) == (str(tmp_path / "Z.csv"), 2)


@pytest.mark.parametrize("limit", ["max_slope = 0.021", "max_slope = 0.005\naccept_slope = true"])
def test_a_steep_table_is_accepted_where_somebody_says_so(tmp_path, limit):
    toml = swap(TOML, "max_slope = 0.005", limit)
    machine = read_machine(folder(tmp_path, toml=toml, z=swap(Z_CSV, "100,3", "0.1,3")))
    assert machine.tables["Z"].nodes[1] == 0.1


def test_accepting_a_slope_must_be_said_with_true(tmp_path):
    toml = swap(TOML, "max_slope = 0.005", "max_slope = 0.005\naccept_slope = false")
    assert "20.00 um/mm" in str(
        refusal(folder(tmp_path, toml=toml, z=swap(Z_CSV, "100,3", "0.1,3")))
    )


# -- what the numbers mean -------------------------------------------------------------------------


def columns(path: Path) -> dict[str, list[float]]:
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def between(nodes: list[float], values: list[float], at: float) -> float:
    """The straight line between two nodes, by hand."""
    for a, b, u, v in zip(nodes, nodes[1:], values, values[1:]):
        if a <= at <= b:
            return u + (v - u) * (at - a) / (b - a)
    raise AssertionError(f"{at} lies outside")


def test_the_grinder_has_the_measured_values():
    """M. Asad Ullah, NUST 2013, tables 6.1 and 6.2; the yaw in mm/m is 1000 urad."""
    machine = read_machine(ROOT / "machines" / "studer-s36")
    for letter, file, parts in (
        (
            "Z",
            "table_6_1_studer_s36_z_axis.csv",
            {2: ("dzz", 1.0), 0: ("dxz", 1.0), 4: ("eyz", 1e-3)},
        ),
        ("X", "table_6_2_studer_s36_x_axis.csv", {0: ("dxx", 1.0), 2: ("dzx", 1.0)}),
    ):
        seed, table = columns(SEED / file), machine.tables[letter]
        assert table.nodes == approx(seed[f"{letter.lower()}_mm"], abs=0)
        for row in range(6):
            name, scale = parts.get(row, (None, 0.0))
            for way, mine in (("forward", table.forward[row]), ("reverse", table.reverse[row])):
                ending = f"_{way}_mm" if scale == 1.0 else f"_{way}"
                theirs = (
                    np.array(seed[name + ending]) * scale if name else np.zeros(len(table.nodes))
                )
                assert mine == approx(theirs, abs=1e-12)
    assert machine.square["X"][1] == approx(-0.065 / 170, abs=1e-12)


POINTS = [
    (0.0, 0.0),
    (10.0, 30.0),
    (4.0, 17.0),
    (85.5, 255.25),
    (170.0, 510.0),
    (123.456, 7.89),
    (0.001, 509.999),
]


@pytest.mark.parametrize("x, z", POINTS)
@pytest.mark.parametrize("way_x", [1, 0, -1])
@pytest.mark.parametrize("way_z", [1, 0, -1])
def test_the_grinders_deviation_is_the_formula_of_the_format(x, z, way_x, way_z):
    """e_Z = EZZ + EZX - S x - b x, e_X = EXX + EXZ (tool and place of measurement are zero); 0 is
    the mean."""
    machine = read_machine(ROOT / "machines" / "studer-s36")
    on_z, on_x = (
        columns(SEED / "table_6_1_studer_s36_z_axis.csv"),
        columns(SEED / "table_6_2_studer_s36_x_axis.csv"),
    )

    def value(seed, nodes, name, at, way, unit):
        forward, reverse = (
            between(seed[nodes], seed[f"{name}_{w}{unit}"], at) for w in ("forward", "reverse")
        )
        return {1: forward, -1: reverse, 0: (forward + reverse) / 2}[way]

    yaw = value(on_z, "z_mm", "eyz", z, way_z, "") * 1e-3
    lean = -382.352941e-6
    e_z = (
        value(on_z, "z_mm", "dzz", z, way_z, "_mm")
        + value(on_x, "x_mm", "dzx", x, way_x, "_mm")
        - lean * x
        - yaw * x
    )
    e_x = value(on_x, "x_mm", "dxx", x, way_x, "_mm") + value(on_z, "z_mm", "dxz", z, way_z, "_mm")
    found = machine.deviation(np.array([[x], [z]]), np.array([[float(way_x)], [float(way_z)]]))
    assert found[:, 0] == approx([e_x, e_z], abs=NANOMETRE)


def test_the_arm_is_counted_from_where_it_was_measured(tmp_path):
    """e_Z gets -b (x + tool.X - measured_at.X), e_X gets b tool.Z: at z = 50 the yaw is 15 urad, by
    hand."""
    toml = swap(TOML, "[tool]\nX = 0.0\nZ = 0.0", "[tool]\nX = 30.0\nZ = 200.0")
    toml = swap(
        swap(toml, "measured_at = { X = 0.0 }", "measured_at = { X = 12.0 }"),
        "size_um = 9.0",
        "size_um = 0.0",
    )
    machine = read_machine(folder(tmp_path, toml=toml))
    found = machine.deviation(np.array([[50.0], [50.0]]), np.array([[0.0], [1.0]]))[:, 0]
    arm = 50.0 + 30.0 - 12.0
    e_z = 2 * UM + -1 * UM + 382.352941e-6 * 50 - 15e-6 * arm
    e_x = 5 * UM + 1.5 * UM + 15e-6 * 200
    assert found == approx([e_x, e_z], abs=NANOMETRE)


@pytest.mark.parametrize("way, part", [(1.0, -4.5), (-1.0, 4.5), (0.0, 0.0)])
def test_backlash_lags_behind_by_half_on_either_side(tmp_path, way, part):
    """9 um of lost motion in X: 4.5 um short of the target, from wherever it came."""
    machine = read_machine(folder(tmp_path))
    without = read_machine(folder(tmp_path, toml=swap(TOML, "size_um = 9.0", "size_um = 0.0")))
    place, approach = np.array([[20.0], [60.0]]), np.array([[way], [1.0]])
    difference = machine.deviation(place, approach) - without.deviation(place, approach)
    assert difference[:, 0] == approx([part * UM, 0.0], abs=NANOMETRE)


def correct(machine, program: bytes) -> bytes:
    filter_ = Filter(machine, dialects.load(machine.control), setup_of(machine))
    return filter_.feed(program) + filter_.finish()


def test_before_an_axis_has_moved_the_mean_of_both_ways_holds():
    """X20 (radius 10) Z10 on the grinder, from nowhere. e_X = (7.6 - 0.6) / 2 + mean EXZ(10), e_Z =
    EZZ + EZX - S x - b x."""
    third = 10.0 / 30.0
    exz = -0.25 + (-0.2 + 0.25) * third
    ezz = 1.35 + (0.5 - 1.35) * third
    yaw = 2.65 + (0.45 - 2.65) * third
    e_x = 3.5 + exz
    e_z = ezz - 3.6 + 382.352941e-3 * 10 - yaw * 1e-3 * 10
    text = (
        correct(read_machine(ROOT / "machines" / "studer-s36"), b"G0 X20. Z10.\n")
        .split(b"\n")[1]
        .decode()
    )
    x, z = (float(word[1:]) for word in text.split()[1:])
    assert x == approx(20.0 - 2 * e_x * UM, abs=0.00006)
    assert z == approx(10.0 - e_z * UM, abs=0.00006)


def test_a_machine_without_squareness_cuts_arcs(tmp_path):
    machine = read_machine(
        folder(
            tmp_path, toml=swap(TOML, "[squareness]\nB0X = -382.352941                  # urad", "")
        )
    )
    out = correct(machine, b"G0 X20. Z10.\nG1 X30. F100\nG3 X40. Z15. R5.\nG2 X50. Z20. K5.\n")
    assert b"\nG3" in out
    assert b"\nG2" in out


def test_a_reversal_is_the_difference_of_the_two_ways(tmp_path):
    """EZZ at 100 mm is 3 um from below and 0 um from above, and nothing else: 3 um between the two
    commands."""
    z = "Z_mm,EZZ_um_fwd,EZZ_um_rev\n0,3,0\n250,3,0\n"
    toml = swap(swap(TOML, "size_um = 9.0", "size_um = 0.0"), "B0X = -382.352941", "B0X = 0.0")
    machine = read_machine(folder(tmp_path, toml=toml, z=z, x="X_mm,EXX_um\n0,0\n170,0\n"))
    out = correct(machine, b"G0 X20. Z10.\nG1 Z100. F100\nZ150.\nZ100.\n").decode().split("\n")
    ends = [
        float(line.split("Z")[1].split()[0])
        for line in out
        if "Z" in line and not line.startswith("(")
    ]
    assert 99.997 in ends
    assert ends[-1] == 100.0
