"""A six-degree-of-freedom file: six recordings of one axis, and columns that would be lost."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from postproc import recordings
from postproc.volumetric import written
from tests.api import schemas
from tests.volumetric.readings import MILL, gcomp


def test_a_six_degree_of_freedom_file_is_six_recordings(tmp_path, capsys):
    """X of example-mill, all six read at once: the map holds each of them, straightness without its
    slope."""
    x = np.linspace(-300, 300, 13)
    q = np.zeros((3, 13))
    q[0] = x
    table = MILL.tables["X"]
    alone = replace(written.without_errors(MILL), tool=np.zeros(3))
    alone = replace(
        alone,
        axes={
            **alone.axes,
            "X": replace(alone.axes["X"], table=replace(table, reverse=table.forward)),
        },
    )
    six = np.array([np.interp(x, table.nodes, table.forward[k]) for k in range(6)])
    # lengths are read where the tool is: with the axis' own arm
    truth, six[:3] = six.copy(), alone.deviation(q, q * 0)
    head = "X_mm,EXX_um,EYX_um,EZX_um,EAX_urad,EBX_arcsec,ECX_urad,approach,Y_mm,Z_mm"
    unit = np.array([1e3, 1e3, 1e3, 1e6, 1e6 * 0.2062648, 1e6])
    rows = [",".join(f"{v:.6f}" for v in (x[i], *(six[:, i] * unit), 1, 0, 0)) for i in range(13)]
    (tmp_path / "x.csv").write_text("\n".join([head, *rows]) + "\n")
    read = recordings.read_all(recordings.Source("x.csv", (tmp_path / "x.csv").read_bytes()))
    assert [r.quantity for r in read] == [
        "displacement",
        "straightness",
        "straightness",
        "angle",
        "angle",
        "angle",
    ]
    assert read[4].reading == pytest.approx(six[4], abs=1e-11)
    words = (
        "--like",
        "example-mill",
        "--json",
        tmp_path / "j.json",
        "--head",
        "u_um=0.1",
        "--head",
        "tool={Z=60}",
    )
    assert gcomp("volumetric", tmp_path / "x.csv", *words) == 0
    document = json.loads((tmp_path / "j.json").read_text())
    schemas.held(document)
    found = document["errors"]
    for name, row in (("EXX", 0), ("EAX", 3), ("EBX", 4), ("ECX", 5)):
        wanted = (truth[row] - truth[row][6]) * (1e3 if row < 3 else 1e6)
        assert found[name]["value"] == pytest.approx(wanted, abs=0.05), name
    bent = truth[1] - np.polyval(np.polyfit(x, truth[1], 1), x)
    assert found["EYX"]["value"] == pytest.approx((bent - bent[6]) * 1e3, abs=0.05)
    capsys.readouterr()


SIX = "X_mm,EXX_um,EYX_um,EZX_um"


@pytest.mark.parametrize(
    ("columns", "says", "line"),
    [
        (f"{SIX},EAX_deg,EBX_deg", "EAX_deg is no column of a six-degree-of-freedom table", 4),
        (f"{SIX},EZX_um", "the column 'EZX_um' stands twice", 4),
        (f"{SIX},EXY_um", "EXY_um is no error of X, which moves", 4),
        (f"{SIX},EAX", "EAX is no column", 4),
    ],
)
def test_a_column_that_would_be_lost_or_read_twice_is_refused(columns, says, line):
    """Comments below the head do not move the line that is named."""
    number = len(columns.split(","))
    rows = [",".join(["1"] * number), "# between", ",".join(["2"] * number)]
    text = "\n".join(["# a", "# b", "# c", columns, "# below", "# and below", *rows]) + "\n"
    with pytest.raises(recordings.RecordingError, match=says) as error:
        recordings.read_all(recordings.Source("x.csv", text.encode()))
    assert error.value.place.line == line


def test_a_column_that_nothing_reads_is_named():
    text = f"{SIX},humidity,T_air_C\n1,0,0,0,50,20\n2,0,0,0,50,20\n"
    for read in recordings.read_all(recordings.Source("x.csv", text.encode())):
        assert read.notices == ("columns that nothing here reads: humidity",)
