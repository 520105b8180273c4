"""The seed's tables 6.1 and 6.2, evaluated: the values that design notes computed from the same
tables by hand-written sums."""

from __future__ import annotations

import pytest
from iso_made import UM, along, runs_of, seed

from postproc.iso import Options, choose
from postproc.iso.positioning import evaluate

GOLDEN = {  # um, means only
    "dzz": {"E": 11.6, "E+": 10.3, "E-": 10.0, "M": 9.55, "B": 5.1},
    "dxz": {"E": 6.5, "M": 4.4, "B": 3.8},
    "dxx": {"E": 31.8, "M": 26.25, "B": 9.8},
    "dzx": {"E": 57.5, "E+": 51.2, "M": 54.35, "B": 7.5},
}


@pytest.mark.parametrize(("column", "name"), [(c, n) for c, row in GOLDEN.items() for n in row])
def test_means_of_the_seed(column, name):
    position, means = seed(column)
    assert evaluate(*runs_of(position, means)).values[name] == pytest.approx(
        GOLDEN[column][name] * UM, abs=0.05 * UM
    )


@pytest.mark.parametrize("column", GOLDEN)
def test_single_runs_define_no_scatter(column):
    values = evaluate(*runs_of(*seed(column))).values
    assert {n for n, v in values.items() if v is None} == {"R", "R+", "R-", "A", "A+", "A-"}


@pytest.mark.parametrize(
    ("column", "test", "subject", "sensitive"),
    [("dzz", "positioning", "EZZ", {"Z": 1.0}), ("dxz", "straightness", "EXZ", {"X": 1.0}),
     ("dxx", "positioning", "EXX", {"X": 1.0}), ("dzx", "straightness", "EZX", {"Z": 1.0})],
)  # fmt: skip
def test_the_same_values_from_a_recording(column, test, subject, sensitive):
    position, means = seed(column)
    quantity = "straightness" if test == "straightness" else "displacement"
    recording = along(column[-1].upper(), position, means / UM, sensitive, quantity, axes="XZ")
    (result,), left = choose.results([recording], Options())
    assert (result.test, result.subject.split(",")[0], left) == (test, subject, [])
    for name, value in GOLDEN[column].items():
        assert result[name].value == pytest.approx(value * UM, abs=0.05 * UM)
    assert all(result[n].value is None and result[n].U is None for n in ("R", "A", "A+"))
    assert any("one run" in n for n in result.notices)
