"""Sections added to a machine.toml: what stands there stays byte for byte and is read as before."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import pytest

from postproc import ports
from postproc.machine import write
from postproc.machine.edit import with_sections
from postproc.machine.file import read_machine

ROOT = Path(__file__).resolve().parents[1]
OLD = {"name": "backlash", "axis": "X", "size_um": 9.0}
NEW = {"name": "backlash", "axis": "Y", "size_um": 3.0, "u_size_um": 0.5}
INLINE = '{ name = "backlash", axis = "X", size_um = 9.0 }'
LISTS = {
    "one line": f"effect = [ {INLINE} ] # made in May\n",
    "lines": f"effect = [ # two\n  {INLINE} # of the shop\n  # no more\n]\n",
    "comma": f"effect = [\n  {INLINE},\n]\n",
    "tables": '[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 9.0 # of May\n',
}


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("form", LISTS)
def test_entries_that_stand_there_stay(form, end):
    """In each way to write them, in front of a table and with three empty lines in between."""
    text = 'name = "a"  # mine\n' + LISTS[form] + "\n\n\n[[other]]\nx = 1\n"
    text = text.replace("\n", end)
    made = with_sections(text, "b", "effect", [(NEW, "by hand"), ({"name": "q"}, "")], "note")
    read = tomllib.loads(made)
    assert read["effect"] == [OLD, NEW, {"name": "q"}]
    assert read["other"] == [{"x": 1}] and read["name"] == "b"
    assert "# note" in made and "# by hand" in made
    assert made.count("\n") == made.count(end)
    stood = [line for line in text.replace('"a"', '"b"').split(end) if "effect" not in line]
    rest = iter(made.replace("},", "}").split(end))  # a comma comes behind what was the last
    assert all(any(line.replace("},", "}") == new for new in rest) for line in stood)


def test_an_empty_list_is_filled_and_an_absent_one_made():
    for text in ('name = "a"\neffect = []\n', 'name = "a"\n', 'name = "a"'):
        read = tomllib.loads(with_sections(text, "b", "effect", [(NEW, "")]))
        assert read == {"name": "b", "effect": [NEW]}


def test_without_sections_the_name_alone_changes():
    text = 'name = "a"\r\n\r\n\r\n\r\n[axes.X]   # slide\r\ntravel = [0, 1]\r\n\r\n'
    assert with_sections(text, "b", "effect", []) == text.replace('"a"', '"b"')


def test_a_machine_with_a_list_of_effects_is_copied_with_all_of_them(tmp_path):
    """Lines ended with CR LF, as an editor of Windows leaves them; the reader takes both forms."""
    old = tmp_path / "old"
    shutil.copytree(ROOT / "machines" / "perfect", old)
    toml = old / "machine.toml"
    text = toml.read_text().replace("\n[axes.X]", f"\neffect = [ {INLINE} ]\n[axes.X]", 1)
    toml.write_bytes(text.replace("\n", "\r\n").encode())
    assert [(t.name, t.axis) for t in read_machine(old).effects] == [("backlash", "X")]

    def change(text):
        return with_sections(text, "new", "effect", [(NEW, "")])

    ports.copy_folder(old, tmp_path / "new", False, change)
    read = read_machine(tmp_path / "new").effects
    assert [(t.name, t.axis) for t in read] == [("backlash", "X"), ("backlash", "Y")]
    assert b"\n" not in (tmp_path / "new" / "machine.toml").read_bytes().replace(b"\r\n", b"")


def test_a_table_of_the_runs_has_a_cell_for_what_is_known_alone():
    """Places to 1e-6 mm, values to 1e-4; what is not a number, and what is none, stays empty."""
    row = {"Z_mm": 12.3456789, "component": "EZZ", "runs": 5, "mean": 1.23456, "s": float("nan")}
    text = write.runs_table("Z", [row | {"u": None}])
    assert text.splitlines()[-1] == "12.345679,EZZ,,,5,1.2346,,,,"
