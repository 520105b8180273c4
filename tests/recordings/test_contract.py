"""The contract's own reader and writer: every shared recording reads, and what is written reads
back the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from postproc.recordings import ReadingOptions, Recording, Source, contract, names, read
from tests.recordings import samples

SHARED = Path(__file__).resolve().parents[3] / "shared" / "recordings"
FILES = (
    sorted(p for p in SHARED.rglob("*.csv") if p.parent.name != "machine")
    if SHARED.is_dir()
    else []
)


def again(recording: Recording) -> Recording:
    return contract.read(Source("again.csv", contract.write(recording).encode()), ReadingOptions())


@pytest.mark.skipif(not FILES, reason="the shared recordings are not here")
@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}-{p.stem}")
def test_every_shared_recording_reads(path):
    data = path.read_bytes()
    recording = read(Source(path.name, data))
    rows = [line for line in data.splitlines() if line.strip() and not line.startswith(b"#")]
    assert len(recording) == len(rows) - 1 and not recording.faults and not recording.notices
    assert list(recording.columns) == rows[0].decode().split(",")
    assert data.splitlines()[recording.lines[-1] - 1] == rows[-1]


@pytest.mark.parametrize(
    "recording",
    [
        samples.taken(
            "z.rtl",
            samples.renishaw(samples.readings(), environment=("Air temp : 20.5",)),
            others={"X": 12.5},
        ),
        samples.taken(
            "b.rta",
            samples.renishaw(samples.readings() / 1000),
            component="EBZ",
            head={"u_um": 0.2},
        ),
        samples.taken("z.csv", samples.interleaved(samples.readings()), machine='5" "mill"\\7'),
        samples.taken("z.csv", samples.canonical({"EXZ": (samples.readings(), "um")})),
        samples.taken(
            "x.rtx",
            samples.dynamic(np.linspace(0, 3, 500), 2500.0),
            unit="mm",
            extra={"command": "still"},
        ),
        samples.taken(
            "c.csv",
            "a;d;s\n0;1;ccw\n90;2;ccw\n",
            columns={"angle_deg": "a", "radial_um": "d", "sense": "s"},
            head={"radius_mm": 100.0, "centre": {"X": 0.0, "Y": 5.0}},
        ),
        samples.taken(
            "f.csv",
            'n,k,a,m,i\n"a, b",step,X,1.5,1.4\n',
            columns={
                "feature": "n",
                "kind": "k",
                "axis": "a",
                "nominal_mm": "i",
                "measured_mm": "m",
            },
        ),
    ],
    ids=["linear", "angular", "sheet", "long", "dynamic", "circle", "features"],
)
def test_written_and_read_again_it_is_the_same(recording):
    back = again(recording)
    assert back.kind == recording.kind and back.quantity == recording.quantity
    assert (
        back.sensitive == recording.sensitive
        and back.machine == recording.machine
        and back.u == recording.u
    )
    assert list(back.columns) == list(recording.columns)
    for name, column in recording.columns.items():
        if column.dtype == object:
            assert back.columns[name].tolist() == column.tolist()
        else:
            assert_allclose(back.columns[name], column, atol=5.1e-5)


HEAD = '# format = "gcomp-recording/1"\n# kind = "targets"\n# sensitive = { Z = 1.0 }\n'


def test_unknown_columns_are_kept_and_empty_optional_ones_are_not_numbers():
    text = (
        HEAD
        + "run,t_s,Z_mm,reading_um,T_air_C,remark,shift\n1,0,0,1.5,,hello,3\n1,1,10,2.5,20.5,,4\n"
    )
    recording = samples.taken("a.csv", text)
    assert recording.columns["remark"].tolist() == ["hello", ""]
    assert_allclose(recording.columns["shift"], [3, 4])
    assert np.isnan(recording.columns["T_air_C"][0]) and recording.columns["T_air_C"][1] == 20.5
    back = again(recording)
    assert back.columns["remark"].tolist() == ["hello", ""] and np.isnan(back.columns["T_air_C"][0])


def test_lines_are_counted_as_an_editor_does():
    """A form feed or a Unicode line separator in a word ends no line."""
    text = HEAD + "run,t_s,Z_mm,reading_um,remark\n1,0,0,1.5,a\x0cb\u2028c\x85d\n1,1,10,2.5,x\n"
    assert samples.taken("a.csv", text).lines.tolist() == [5, 6]


def test_what_a_format_does_not_heed_is_said():
    recording = samples.taken(
        "a.csv", HEAD + "run,t_s,Z_mm,reading_um\n1,0,0,1.5\n", unit="mm", layout="", first=1
    )
    assert any("--unit, --first were not used" in t for t in recording.notices)


def test_formats_are_the_modules_without_the_shared_ones():
    assert (
        "contract" in names()
        and "renishaw-dynamic" in names()
        and not any(n.startswith(("_", "-")) for n in names())
    )
