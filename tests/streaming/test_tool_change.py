"""Tool changes with lines of the user's: park, change, touch off, and on with the map where the
zero is then."""

from __future__ import annotations

import argparse
import json
import re

import numpy as np
import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc.commands.stream import tools  # noqa: E402
from postproc.errors import GcompError, ProgramError  # noqa: E402
from postproc.streaming import changes, journal  # noqa: E402
from postproc.streaming.lines import Unsendable  # noqa: E402
from postproc.streaming.protocols.grbl import Grbl  # noqa: E402
from tests.streaming.models_marlin import MarlinModel  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import model, sent_rows, stream, wire_rows  # noqa: E402

MILL = ("--machine", "example-mill", "--dialect", "grbl")
RAW = ("--machine", "perfect", "--dialect", "grbl")
FIRST = [
    "G21 G90 G94 G17 G54",
    "T1 M6",
    "M3 S9000",
    "G0 X10 Y10",
    "G0 Z15",
    "G1 Z-2 F300",
    "X60 F900",
    "G0 Z15",
    "M5",
]
SECOND = ["M3 S5000", "G1 Z-3 F200", "Y90 F700", "X10", "G0 Z15", "M5", "M30"]
JOB = "\n".join([*FIRST, "N90 T2 M6", *SECOND, ""])
PARK = "(to the front)\nG53 G0 Z-10\nG53 G0 X5 Y5\n"
TOUCH = "G38.2 Z-400 F80\nG10 L20 P1 Z20 ; the plate\nG91\nG0 Z30\n"
PLATES = (-180.0, -171.5)  # mm: where each tool touches


def prepared(tools=PLATES, **how):
    """A GRBL in which somebody changes the tool at each pause, which then touches elsewhere, and
    goes on."""
    made = model(**how)
    plates, held, advance = list(tools), [], made.advance

    def person(now: float) -> None:
        advance(now)
        if made.state != "Hold":
            held.clear()
        elif not held:
            held.append(now)
        elif now > held[0] + 40.0:
            made.plate = plates.pop(0) if plates else made.plate
            made.write(b"~", now)
            held[:] = [now + 1e9]

    made.advance = person
    return made


def job(
    folder,
    host: PtyHost,
    *options: str,
    text: str = JOB,
    park: str = PARK,
    touch: str = TOUCH,
    machine=MILL,
):
    (folder / "job.nc").write_text(text)
    (folder / "park.nc").write_text(park)
    (folder / "touch.nc").write_text(touch)
    status, out, err = stream(
        folder,
        host,
        "job.nc",
        "--park",
        "park.nc",
        "--touch-off",
        "touch.nc",
        *options,
        machine=machine,
    )
    return status, out, err


def test_park_change_touch_off_and_on(place):
    with PtyHost(prepared(), speed=60.0) as host:
        status, out, err = job(place, host)
    assert status == 0, err
    rows = sent_rows(host)
    change = rows.index("N90T2M0")
    assert rows[change - 5 : change] == ["M5", "M9", "G21G90G94", "G53G0Z-10", "G53G0X5Y5"]
    assert rows[change + 1 : change + 6] == [
        "G38.2Z-400F80",
        "G10L20P1Z20",
        "G91",
        "G0Z30",
        "G4P0.01",
    ]
    assert host.model.stored["G54"][2] == PLATES[1] - 20.0
    back = rows[change + 6 :]
    assert back[0] == "G21G90G17G94" and back[1] == "G54" and back[2] == "G53G0Z-141.5000", back
    # What the second tool does is what a program of its own does with that zero: the map lies where
    # the part is.
    (place / "rest.nc").write_text(
        "\n".join([*FIRST[:1], "G0 X60 Y10", "G0 Z15", *SECOND[:1], "G90", *SECOND[1:], ""])
    )
    alone = wire_rows(place, "rest.nc", "--offset", f"G54=X0,Y0,Z{PLATES[1] - 20:g}")
    found, wanted = _ends(back), _ends(alone)
    assert len(wanted) > 2 and all(
        np.abs(found - end).max(axis=1).min() < 0.0015 for end in wanted[1:]
    ), (
        found,
        wanted,
    )
    past = journal.read((place / "job.nc.journal").read_bytes(), "j")
    assert past.head["offsets"]["G54"]["Z"] == PLATES[1] - 20.0 and past.outcome == "done"
    last = [json.loads(row) for row in out.splitlines()][-1]
    assert last["outcome"] == "done"
    assert (
        "the program stops here, source line 10, sent as wire line" in err
        and ": N90 T2 M0: r" in err
    )


def _ends(rows: list[str]) -> np.ndarray:
    """Where the motions from the second tool's first cut on end."""
    at, found, cuts = dict.fromkeys("XYZ", np.nan), [], False
    for row in rows:
        cuts = cuts or "F700" in row
        words = dict(re.findall(r"([XYZ])(-?[0-9.]+)", row))
        at |= {axis: float(value) for axis, value in words.items()}
        found += [list(at.values())] if cuts and words else []
    return np.array(found)


def test_nothing_moved_yet_so_nothing_is_gone_back_to(place):
    """T1 M6 at the top of a program: its own first motion leads on, and only modes come back."""
    with PtyHost(prepared(), speed=60.0) as host:
        status, _, err = job(place, host, text="\n".join([*FIRST, "M30", ""]), machine=RAW)
    rows = sent_rows(host)
    assert status == 0, err
    at = rows.index("G4P0.01")
    assert rows[at + 1 : at + 6] == ["G21G90G17G94", "G54", "T1", "G17G21G90G94", "G0"], rows[at:]
    assert rows[at + 6] == "M3S9000"


def test_longer_tools_by_what_the_probe_says(place):
    touch = "G38.2 Z-400 F80\nG43.1 Z{longer}\nG53 G0 Z-10\n"
    with PtyHost(prepared(), speed=60.0) as host:
        status, _, err = job(place, host, touch=touch, machine=RAW)
    assert status == 0, err
    lengths = [row for row in sent_rows(host) if row.startswith("G43.1")]
    assert lengths == ["G43.1Z0.000", "G43.1Z8.500", "G43.1Z8.5000"] and host.model.length == 8.5
    down = [end for end in host.model.ends if end[:2] == [60.0, 90.0]]
    assert down[-1][2] == pytest.approx(-200.0 + 8.5 - 3.0)


def test_a_zero_that_leads_out_of_reach_stops_in_the_change(place):
    """The second tool's zero lies so low that the program would leave the travel: known before it
    goes back."""
    limits = {"20": "1", "130": "200.000", "131": "200.000", "132": "230.000"}
    made = prepared((-180.0, -211.0), settings=limits)
    made.stored["G54"] = [-150.0, -150.0, -200.0]
    with PtyHost(made, speed=60.0) as host:
        status, _, err = job(place, host, park="G53 G0 Z-10\n", machine=RAW)
    assert status == 2, err
    said = (
        "nothing more was sent behind this tool change: Z -234.000 (machine coordinates) is beyond"
        " the controller's travel"
    )
    assert f"job.nc:12: {said}" in err, err
    rows = sent_rows(host)
    assert rows[rows.index("N90T2M0") :][-2:] == ["G0Z30", "G4P0.01"] and host.model.state == "Idle"
    assert journal.read((place / "job.nc.journal").read_bytes(), "j").outcome == "error"


def test_a_tool_that_does_not_touch_is_an_alarm(place):
    made = prepared()
    with PtyHost(made, speed=60.0) as host:
        status, _, err = job(place, host, touch="G38.2 Z40 F80\n", machine=RAW)
    assert status == 11 and "ALARM:5" in err and "touch.nc" in err, err


@pytest.mark.parametrize(
    ("text", "park", "options", "says"),
    [
        (JOB, "G0 X1\nM30\n", (), "park.nc:2: lines of a tool change move, probe"),
        (
            JOB.replace("N90 T2 M6", "T2 M6 G0 X5"),
            PARK,
            (),
            "job.nc:10: a motion stands in the block of the tool change",
        ),
        (
            JOB.replace("M5\nN90", "G43.1 Z5\nN90"),
            PARK,
            (),
            "line 10 changes the tool, and the program has set a tool length",
        ),
        (JOB, PARK, ("--tool-change", "ignore"), "are for --tool-change pause, not for ignore"),
        (
            JOB,
            PARK,
            ("--expand",),
            "need the program as a file in which every line is executed once",
        ),
    ],
)
def test_what_can_not_be_is_refused_before_the_first_byte(place, text, park, options, says):
    with PtyHost(model(), speed=60.0) as host:
        status, _, err = job(place, host, *options, text=text, park=park, machine=RAW)
    assert status == 2 and says in err, err
    assert not sent_rows(host)


def test_who_changes_tools_by_itself_needs_none(place):
    with PtyHost(MarlinModel(), speed=4.0) as host:
        status, _, err = job(place, host, machine=("--machine", "perfect", "--dialect", "marlin"))
    assert status == 2 and "--park and --touch-off are for GRBL and its kin" in err, err


def test_a_job_that_begins_again_does_not_know_the_first_tool(tmp_path):
    (tmp_path / "touch.nc").write_text("G38.2 Z-5 F9\nG43.1 Z{longer}\n")
    options = argparse.Namespace(park=None, touch_off=str(tmp_path / "touch.nc"), resume_from="9")
    with pytest.raises(GcompError, match="compares each tool with the first one"):
        tools.read(options, Grbl())


def test_macros_and_blocks_of_changes():
    found = changes.macro(b"(a) G0 X1 ; b\n\nM0\n%\n", "m.nc", Grbl().prepare)
    assert found.rows == ((1, b"G0 X1"), (3, b"M0"))
    with pytest.raises(ProgramError, match="is an order to the controller"):
        changes.macro(b"$H\n", "m.nc", Grbl().prepare)
    with pytest.raises(ProgramError, match="would obey at once"):
        changes.macro(b"G0 X1 !\n", "m.nc", Grbl().prepare)
    assert changes.split(b"N5 T2 M06") == b"N5 T2 M0"
    with pytest.raises(Unsendable):
        changes.split(b"T2 M6 X5")
    longer = changes.Longer()
    with pytest.raises(GcompError, match="nothing was probed"):
        longer.put(b"G43.1 Z{longer}", ["[TLO:0.000]", "[PRB:0.000,0.000,0.000:0]"])
    assert longer.put(b"G43.1 Z{longer}", ["[PRB:1.000,2.000,-30.000:1]"]) == b"G43.1 Z0.000"
    assert longer.put(b"G43.1 Z{longer}", ["[PRB:1.000,2.000,-31.250:1]"]) == b"G43.1 Z-1.250"


def test_an_axis_that_the_program_never_names_comes_back_to_where_it_stood(place):
    """Y stands at 150 when the job begins, and at 5 when it was parked: all cuts are at 150."""
    first = [row for row in FIRST if row not in ("T1 M6", "G0 X10 Y10")]
    second = [row.replace("Y90", "X90") for row in SECOND]
    text = "\n".join([*first, "N90 T2 M6", *second, ""])
    made = prepared()
    made.place[1] = made.target[1] = 150.0
    with PtyHost(made, speed=60.0) as host:
        status, _, err = job(place, host, text=text)
    assert status == 0, err
    rows = sent_rows(host)
    back = next(r for r in rows[rows.index("N90T2M0") :] if r.startswith("G0X60"))
    assert float(re.search(r"Y([\d.]+)", back)[1]) == pytest.approx(150.0, abs=0.05)
    assert made.place[1] == pytest.approx(150.0, abs=0.05)
