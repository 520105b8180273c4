"""The text of a machine folder is read back as what was written."""

from __future__ import annotations

import tomllib

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from postproc.machine.axis_file import read_table
from postproc.machine.write import axis_table, machine_toml, number, runs_table

texts = st.text(max_size=20)
numbers = st.floats(-1e6, 1e6, allow_nan=False)
plain = st.one_of(
    texts, st.booleans(), st.integers(-1000, 1000), numbers, st.lists(numbers, max_size=3)
)
sections = st.dictionaries(st.text("abcXYZ_059 .\"'", min_size=1, max_size=6), plain, max_size=4)


@settings(max_examples=30, deadline=None)
@given(
    st.fixed_dictionaries({"name": texts, "title": texts}),
    st.dictionaries(st.sampled_from("XYZ"), sections, min_size=1),
    sections,
    st.lists(sections, max_size=2),
    texts,
)
def test_what_is_written_is_what_toml_reads(head, axes, limits, effects, comment):
    data = head | {"axes": axes, "limits": limits} | ({"effect": effects} if effects else {})
    comments = {"": comment, "name": comment} | {
        f"axes.{x}.{k}": comment for x in axes for k in axes[x]
    }
    assert tomllib.loads(machine_toml(data, comments)) == data


def test_the_order_is_that_of_the_format():
    data = {
        "limits": {"outside": "error"},
        "source": "s",
        "axes": {"Z": {"travel": [0.0, 1.0]}},
        "name": "n",
        "format": "f",
    }
    text = machine_toml(data, {"": "top\nof it", "axes.Z.travel": "mm"})
    assert text.splitlines() == [
        "# top",
        "# of it",
        'format = "f"',
        'name = "n"',
        'source = "s"',
        "",
        "[axes.Z]",
        "travel = [0.0, 1.0]                    # mm",
        "",
        "[limits]",
        'outside = "error"',
    ]


def test_a_table_is_read_back_to_a_tenth_of_a_nanometre(tmp_path):
    rng = np.random.default_rng(1)
    nodes, forward, reverse, angle = (
        np.sort(rng.uniform(-100, 500, 30)),
        *rng.normal(0, 0.5, (3, 30)),
    )
    columns = {"EZZ_um_fwd": forward, "EZZ_um_rev": reverse, "EBZ_urad": angle}
    (tmp_path / "Z.csv").write_text(axis_table("Z", nodes, columns, ["made up"]))
    table = read_table(tmp_path / "Z.csv", "Z", 1.0)
    assert table.nodes == approx(nodes, abs=1e-6)
    assert table.forward[2] * 1e3 == approx(forward, abs=6e-5)
    assert table.reverse[2] * 1e3 == approx(reverse, abs=6e-5)
    assert table.forward[4] * 1e6 == approx(angle, abs=6e-5)
    assert (table.forward[4] == table.reverse[4]).all()


def test_what_is_not_known_is_left_empty():
    row = {
        "Z_mm": 0.0,
        "component": "EZZ",
        "approach": "+",
        "unit": "um",
        "runs": 1,
        "mean": 2.5,
        "s": float("nan"),
    }
    assert runs_table("Z", [row], ["c"]).splitlines() == [
        "# c", "Z_mm,component,approach,unit,runs,mean,s,value,u,U95", "0,EZZ,+,um,1,2.5,,,,",
    ]  # fmt: skip


def test_numbers_have_no_zeros_that_say_nothing():
    assert [number(v, 4) for v in (1.5, -0.00001, 100.0, 0.12345, -3.0)] == [
        "1.5",
        "0",
        "100",
        "0.1235",
        "-3",
    ]
    assert number(100.0, 0) == "100"


def test_a_file_name_can_not_break_out_of_its_comment(tmp_path):
    text = axis_table(
        "Z", np.array([0.0, 1.0]), {"EZZ_um": np.array([1.0, 2.0])}, ["a\nZ_mm\r\udcff.csv: x"]
    )
    (tmp_path / "Z.csv").write_bytes(text.encode())
    assert read_table(tmp_path / "Z.csv", "Z", 1.0).forward[2] == approx([1e-3, 2e-3])
    assert tomllib.loads(machine_toml({"name": "\udcff"}, {"name": "b\n[x]", "": "c\r[y]"})) == {
        "name": "?"
    }
