"""A machine folder is trusted with somebody's part: what is wrong in machine.toml is refused with
file, line and the way out."""

from __future__ import annotations

import pytest

from postproc import intake
from postproc.errors import GcompError, MachineError, UsageError
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.machine.toml_file import TomlFile
from tests.machine_folders import TOML, check, correct, folder, line_of, refusal, swap

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
    "one axis of an effect of two": (
        'name = "backlash"\naxis = "X"\nsize_um = 9.0',
        'name = "squareness"\naxis = "X"\nurad = 9.0',
        'axis = "X"',
        ("'X' is not a pair of linear axes, like XZ, of the machine",),
    ),
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
    "effect's number of an axis": (
        'name = "backlash"\naxis = "X"\nsize_um = 9.0',
        'name = "bow"\naxis = "X"\nsize_um = 9.0\nacross = 1.5',
        "across",
        ("across = 1.5 is no number of an axis", "0, 1, 2: X, Y, Z"),
    ),
    "effect's degree above the highest": (
        'name = "backlash"\naxis = "X"\nsize_um = 9.0',
        'name = "pitch_shape"\naxis = "X"\nc2_um = 9.0\ndegree = -12',
        "degree",
        ("degree = -12 is above 9, the highest",),
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
    "no velocity": (
        "max_velocity = 10000.0",
        "max_velocity = 0.0",
        "max_velocity",
        ("max_velocity = 0.0 is not above zero",),
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


@pytest.mark.parametrize("least", [0.000001, 0.1])
def test_the_finest_and_the_coarsest_increment_are_taken(tmp_path, least):
    text = TOML.replace("0.0001", f"{least:f}")
    assert read_machine(folder(tmp_path, text)).axes["X"].least_increment == least


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


def test_what_force_has_left_of_a_machine_is_not_offered(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("mine", "mine.bak", "mine.bak2"):
        (tmp_path / "machines" / name).mkdir(parents=True)
        (tmp_path / "machines" / name / "machine.toml").write_text("")
    with pytest.raises(UsageError) as caught:
        places.folder_of("mien")
    assert "did you mean mine? machines: mine, example" in caught.value.advice
    assert places.folder_of("mine.bak").name == "mine.bak"


def test_the_byte_that_is_no_text_is_named_behind_a_byte_order_mark_too():
    assert intake.decoded(b"\xef\xbb\xbfname\n", "a.toml", GcompError) == "name\n"
    with pytest.raises(GcompError, match="a.toml:2: byte 254 is not UTF-8"):
        intake.decoded(b"\xef\xbb\xbfname\n\xfe\xff", "a.toml", GcompError)


@pytest.mark.parametrize(
    "written, line",
    [
        ("axes.Z.least_increment = 0.0005\naxes.Z.travel = [0.0, 1.0]\n", 1),
        ('axes.Z.travel = [0.0, 1.0]\naxes . "Z" . least_increment = 0.0005\n', 2),
        ("[axes]\nZ.travel = [0.0, 1.0]\nZ.least_increment = 0.0005\n", 3),
        ("[axes]\nZ = { travel = [0.0, 1.0], least_increment = 0.0005 }\n", 2),
        ("[axes.Z]\ntravel = [0.0, 1.0]\n", 1),
        ("title = 'T'\naxes.Z.travel = [0.0, 1.0]\n", 2),
    ],
)
def test_a_key_is_found_however_its_section_is_written(written, line, tmp_path):
    """The line of the key, and of its section where the key is missing."""
    (tmp_path / "machine.toml").write_text(written)
    toml = TomlFile(tmp_path / "machine.toml")
    assert toml.line("axes.Z", "least_increment") == line


def test_keys_with_dots_of_their_own_and_keys_of_keys(tmp_path):
    text = '[offsets]\n"G54.1" = { X = 0.0 }\nG54.X = 1.0\n[[effect]]\nname = "a"\n[[effect]]\n'
    (tmp_path / "machine.toml").write_text(text + 'name = "b"\n')
    toml = TomlFile(tmp_path / "machine.toml")
    assert [toml.line("offsets", name) for name in ("G54.1", "G54")] == [2, 3]
    assert [toml.line("effect", "name", k) for k in (0, 1)] == [5, 7]
    assert [toml.line("effect", "axis", k) for k in (0, 1)] == [4, 6]


def test_an_axis_that_is_no_section_is_called_so(tmp_path):
    (tmp_path / "machine.toml").write_text(
        'format = "gcomp-machine/1"\nname = "m"\ncontrol = "grbl"\nchain = "w-b-X-t"\naxes.X = 5\n'
    )
    with pytest.raises(MachineError, match=r"axes.X = 5 must be a section \[axes.X\]") as said:
        read_machine(tmp_path)
    assert said.value.place.line == 5
