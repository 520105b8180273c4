"""A machine folder as a whole and its tables: the example of the format is accepted, and a faulty
table is refused with file, line and the way out."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from postproc.machine.file import read_machine
from postproc.units import UM, URAD
from tests.machine_folders import TOML, X_CSV, Z_CSV, check, folder, refusal, swap

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
        ("backlash", "X", {"size_um": 9.0, "play_mm": 0.0, "around": 0.0, "pushed": 0.0})
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
