"""The seed's Tables 6.1 and 6.2 by a column mapping: the numbers that are printed, and the golden
E, M and B from them.

Golden values: compensation notes 3.1, computed there from the same tables; formulas of ISO 230-2
for means.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx

from postproc.errors import UsageError
from postproc.recordings import ReadingOptions, RecordingError, Source, contract, read

SEED = Path(__file__).resolve().parents[2] / "proof" / "seed" / "tables"
Z, X = "table_6_1_studer_s36_z_axis.csv", "table_6_2_studer_s36_x_axis.csv"
CASES = {
    "EZZ": (Z, "z_mm", "dzz", {"E": 11.6, "M": 9.55, "B": 5.1}),
    "EXZ": (Z, "z_mm", "dxz", {"E": 6.5, "M": 4.4, "B": 3.8}),
    "EXX": (X, "x_mm", "dxx", {"E": 31.8, "M": 26.25, "B": 9.8}),
    "EZX": (X, "x_mm", "dzx", {"E": 57.5, "M": 54.35, "B": 7.5}),
}


def options(component: str, name: str, unit: str = "mm") -> ReadingOptions:
    axis = component[2]
    columns = {
        f"{axis}_mm": f"{axis.lower()}_mm",
        f"forward_{unit}": f"{name}_forward",
        f"reverse_{unit}": f"{name}_reverse",
    }
    if unit == "mm":
        columns = {
            k: v + ("_mm" if k in ("forward_mm", "reverse_mm") else "") for k, v in columns.items()
        }
    return ReadingOptions(component=component, columns=columns)


@pytest.mark.parametrize("component", CASES)
def test_the_printed_numbers_come_through(component):
    file, place, name, golden = CASES[component]
    recording = read(Source(file, (SEED / file).read_bytes()), "", options(component, name))
    with open(SEED / file, newline="") as lines:
        rows = list(csv.DictReader(lines))
    for sign, word in ((1, "forward"), (-1, "reverse")):
        mine = recording.pick(recording.approach(component[2]) == sign)
        printed = {float(r[place]): float(r[f"{name}_{word}_mm"]) for r in rows}
        assert dict(zip(mine.position(component[2]), mine.reading, strict=True)) == approx(
            printed, abs=1e-9
        )
        line = {float(r[place]): i for i, r in enumerate(rows, 2)}
        assert mine.lines.tolist() == [line[p] for p in mine.position(component[2])]
    # columns of averages do not come in: 18 targets, two runs
    assert len(recording) == 36 and set(recording.columns["run"]) == {1.0, 2.0}
    up, down = (
        recording.pick(recording.approach(component[2]) == s).reading[:: int(s)] * 1e3
        for s in (1, -1)
    )
    both = np.concatenate([up, down])
    assert np.ptp(both) == approx(golden["E"], abs=0.05)
    assert np.ptp((up + down) / 2) == approx(golden["M"], abs=0.05)
    assert np.abs(up - down).max() == approx(golden["B"], abs=0.05)


def test_the_yaw_has_no_unit_and_is_not_given_one():
    file = SEED / Z
    bare = ReadingOptions(
        component="EBZ",
        columns={"Z_mm": "z_mm", "forward": "eyz_forward", "reverse": "eyz_reverse"},
    )
    with pytest.raises(RecordingError, match="does not say in which unit"):
        read(Source(Z, file.read_bytes()), "", bare)
    recording = read(Source(Z, file.read_bytes()), "", options("EBZ", "eyz", "mm/m"))
    assert recording.sensitive == {"Y": 1.0} and recording.columns["reading_urad"].min() == approx(
        -8.7
    )


def test_mm_taken_for_um_are_named():
    """A heading that says mm refuses it; one that says nothing leaves the range to tell."""
    ways = {"forward_um": "dzz_forward_mm", "reverse_um": "dzz_reverse_mm"}
    how = ReadingOptions(component="EZZ", columns={"Z_mm": "z_mm", **ways})
    data = (SEED / Z).read_bytes()
    with pytest.raises(UsageError, match="the heading says mm, and forward_um is um"):
        read(Source(Z, data), "", how)
    ways = {name: heading.removesuffix("_mm") for name, heading in ways.items()}
    for heading in ways.values():
        data = data.replace(f"{heading}_mm".encode(), heading.encode())
    how = ReadingOptions(component="EZZ", columns={"Z_mm": "z_mm", **ways})
    told = next(t for t in read(Source(Z, data), "", how).notices if "range over" in t)
    assert "0.0116 um" in told and "mm read as um? Then they range over 11.6 um" in told


@pytest.mark.parametrize("component", CASES)
def test_written_and_read_again_nothing_is_lost(component):
    file, _, name, _ = CASES[component]
    recording = read(Source(file, (SEED / file).read_bytes()), "", options(component, name))
    again = contract.read(Source("again.csv", contract.write(recording).encode()), ReadingOptions())
    assert again.head["component"] == component and list(again.columns) == list(recording.columns)
    for column, values in recording.columns.items():
        assert_allclose(again.columns[column], values, atol=1e-9)
