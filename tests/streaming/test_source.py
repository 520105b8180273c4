"""Lines for the wire: the filter's own bytes, each with its source line, block and correction (A1,
A7, A17, A18, A19)."""

from __future__ import annotations

import math
import random
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.streaming.compact import Compact, number
from postproc.streaming.lines import WireLine
from postproc.streaming.protocols.grbl import Grbl
from postproc.streaming.protocols.marlin import Marlin
from postproc.streaming.rates import Load
from postproc.streaming.source import Source
from tests.streaming.bench import new_sender, run
from tests.streaming.grbl_model import GrblModel

OFFSETS = {"G54": {"X": 0.0, "Y": 0.0, "Z": -200.0}}
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*")


def filter_(machine: str = "example-mill", dialect: str = "grbl", **how) -> Filter:
    loaded = places.load(machine)
    return Filter(
        loaded, dialects.load(dialect), setup_of(loaded, how.pop("offsets", OFFSETS), **how)
    )


def program(n: int, seed: int = 1, comments: bool = True) -> bytes:
    """Straight moves and arcs, long enough that the map cuts them, with comments, blank lines and
    CRLF here and there."""
    r = random.Random(seed)
    rows = ["%", "(a part)", "G21 G90 G94 G17", "G54", "G0 X0 Y0 Z20", "M3 S1000", "G1 Z10 F300"]
    x = y = 0.0
    for _ in range(n):
        what = r.random()
        if what < 0.1:
            i, j = r.uniform(-8, 8), r.uniform(-8, 8)
            x, y = round(x + 2 * i, 3), round(y + 2 * j, 3)
            x, y = (x, y) if abs(x) < 150 and abs(y) < 120 else (0.0, 0.0)
            rows.append(
                f"G1 X{x} Y{y}"
                if (x, y) == (0.0, 0.0)
                else f"G2 X{x} Y{y} R{math.hypot(i, j) * 1.4:.3f}"
            )
        else:
            x, y = round(r.uniform(-150, 150), 3), round(r.uniform(-120, 120), 3)
            rows.append(
                f"{r.choice(('G1 ', 'G0 ', 'G1'))}X{x} Y{y}" + r.choice(("", " F900", " F1200.5"))
            )
        if comments and r.random() < 0.1:
            rows += [r.choice(("", "(note! ok?)", " ; all of it", "G4 P0.01"))]
    rows += ["M5", "M30", "%"]
    return b"".join(row.encode() + r.choice((b"\n", b"\r\n")) for row in rows)


def wire_form(text: bytes) -> list[bytes]:
    """What GRBL must get of a program text: no comments, blank lines, % or blanks at the ends."""
    rows = [COMMENT.sub(b"", row).strip() for row in text.split(b"\n")]
    return [row for row in rows if row and row != b"%"]


def lines_of(text: bytes, cut=None, **how) -> list[WireLine]:
    source = Source(filter_(), Grbl().prepare, **how)
    result, at = [], 0
    for size in cut or [len(text)]:
        result += source.feed(text[at : at + size])
        at += size
    return result + source.feed(text[at:]) + source.finish()


@pytest.mark.parametrize("seed", range(4))
def test_A1_A17_the_wire_carries_the_files_bytes_and_every_line_knows_its_source(seed):
    text = program(300, seed)
    whole = filter_()
    output = whole.feed(text) + whole.finish()
    lines = lines_of(text)
    assert [line.text for line in lines] == wire_form(output)
    assert [line.number for line in lines] == list(range(1, len(lines) + 1))
    # One source line at a time, through a filter of its own: the slow way to know which line
    # belongs to which.
    single = filter_()
    owner = []
    for k, row in enumerate(text.splitlines(keepends=True), 1):
        owner += [k] * len(wire_form(single.feed(row)))
    assert [line.source for line in lines] == owner
    assert len(lines) > 400  # the map cut moves, so that pieces stand behind their blocks
    assert max(line.piece for line in lines) > 1


def test_A1_any_cut_of_the_input_gives_the_same_lines():
    text = program(150, 9)
    r = random.Random(3)
    cut = [r.randint(1, 400) for _ in range(40)]
    assert lines_of(text, cut) == lines_of(text)


def test_A1_a_line_whose_comment_names_gcomp_is_sent():
    """gcomp's own mark is what leaves again, and not the first line with that word in it."""
    text = b"G21 G90 G17 G94 G54%s\nG0 X10 Y20 Z5\nG1 X10 Y80 F500\nG1 X-60\n"
    told, plain = lines_of(text % b" (FOR GCOMP USE)"), lines_of(text % b"")
    assert [(x.text, x.source, x.end) for x in told] == [(x.text, x.source, x.end) for x in plain]


def test_A17_end_and_correction_are_those_of_the_line():
    """The end of a line, less its correction, is the nominal place of its block: G54 lies at Z
    -200."""
    text = b"G21 G90 G17 G94 G54\nG0 X10 Y20 Z5\nG1 X10 Y80 F500\nG1 X-60\n"
    lines = lines_of(text)
    machine = places.load("example-mill")
    for source, nominal in ((2, (10, 20, -195)), (3, (10, 80, -195)), (4, (-60, 80, -195))):
        line = [x for x in lines if x.source == source][-1]
        assert np.allclose(np.array(line.end) - line.correction, nominal, atol=1e-9)
        deviation = machine.deviation(np.array([nominal], float).T, np.zeros((3, 1)))[:, 0]
        assert np.allclose(line.correction, -deviation, atol=0.02)
    assert any(abs(c) > 1e-3 for line in lines for c in line.correction)


def test_A17_length_and_time_of_lines():
    """60 mm at 500 mm/min are 7.2 s; a quarter circle of 20 mm radius is 31.416 mm; 2 s of
    dwell."""
    text = (
        b"G21 G90 G17 G94 G54\nG0 X0 Y0 Z5\nG1 Y60 F500\nG2 X20 Y80 I20 J0 F1000\nG4 P2\nG20\nG1 X1"
        b" F10\n"
    )
    lines = lines_of(text)
    total = {k: sum(x.seconds for x in lines if x.source == k) for k in range(1, 8)}
    assert total[3] == pytest.approx(7.2, rel=1e-3)
    assert sum(x.length for x in lines if x.source == 4) == pytest.approx(math.pi * 10, rel=1e-3)
    assert total[5] == 2.0
    # from X 20 mm to 1 inch at 10 inch/min
    assert total[7] == pytest.approx(5.4 / 254 * 60, rel=1e-2)


def test_lines_behind_the_end_of_the_program_are_not_sent():
    source = Source(filter_(), Grbl().prepare)
    lines = source.feed(b"G21 G90 G54\nG0 X1 Y1 Z5\nM30\nG0 Z-100\n(x)\n\n%\n")
    assert lines[-1].text == b"M30" and source.dropped == 1


def test_a_feed_from_nowhere_is_judged_by_all_that_follows():
    """A feed from a place that is not known is refused where no later one is corrected: that is
    not decided at the end of its line, nor where the program ends in the same batch."""
    text = b"G21 G91 G54\nG1 X1 F100\nG90 G0 X1 Y1 Z5\nG1 X2 F100\nM30\n"
    sent = [line.text for line in lines_of(text)]
    assert sent[:2] == [b"G21 G91 G54", b"G1 X1 F100"] and sent[-1] == b"M30"


@pytest.mark.parametrize("end", [b"", b"M30\n", b"%\n"])
def test_the_lines_before_a_fault_are_kept(end):
    good = program(100, 2).replace(b"M30", b"M0").replace(b"%", b"")
    source = Source(filter_(), Grbl().prepare)
    with pytest.raises(ProgramError) as error:
        source.feed(good + b"G0 X9999\nG0 X1\n" + end)
    assert error.value.place.line == good.count(b"\n") + 1
    assert [x.text for x in source.delivered] == [x.text for x in lines_of(good)]


def test_block_delete_is_obeyed_here_because_grbl_does_not():
    text = b"G21 G90 G54\nG0 X1 Y1 Z5\n/G0 X50\n"
    assert [x.source for x in Source(filter_(block_delete=True), Grbl().prepare).feed(text)] == [
        1,
        2,
    ]
    assert Source(filter_(), Grbl().prepare).feed(text)[-1].text.startswith(b"G0 X")


def test_A7_what_can_not_be_sent_is_refused_with_its_line():
    text = b"G21 G90 G54\nG0 X1 Y1 Z5\nG1 X" + b"1." + b"0" * 80 + b"\n"
    source = Source(filter_("perfect"), Grbl().prepare)
    with pytest.raises(ProgramError) as error:
        source.feed(text)
    assert error.value.place.line == 3


def test_A1_compensated_lines_arrive_as_the_file_has_them():
    text = program(250, 5)
    whole = filter_()
    output = whole.feed(text) + whole.finish()
    for counting in (True, False):
        model = GrblModel(baud=0)
        model.stored["G54"] = [0.0, 0.0, -200.0]
        model.settings["110"] = "300000"
        lines = [
            line for line in lines_of(text.replace(b"F", b"F9")) if not line.text.startswith(b"G2")
        ]
        sender = new_sender(model, counting)
        run(sender, model, lines, tick=0.02, limit=1e5)
        assert sender.outcome.kind == "done", sender.outcome
        assert model.received == [x.text.replace(b" ", b"").decode() for x in lines]
    assert [x.text for x in lines_of(text)] == wire_form(output)


# -- A19 -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("long", "short"),
    [
        ("10.500", "10.5"),
        ("0.5", ".5"),
        ("-0.50", "-.5"),
        ("+007", "7"),
        ("5.", "5"),
        ("0.000", "0"),
        ("-0", "0"),
        ("100", "100"),
    ],
)
def test_numbers_in_fewer_digits(long, short):
    assert number(long.encode()) == short.encode()


def test_A19_compact_leaves_out_what_is_in_force():
    rows = [
        "G90 G94 G21",
        "N10 G01 X10.000 Y5.0 F500.0",
        "N20 G01 X10.000 Y6.500 F500",
        "G2 X1 Y1 I0.50 J0",
        "G2 X2 Y1 I1 J0",
        "G1 X2 Y5",
        "G91 G1 X2 Y0",
        "G90 X2 Y5",
        "G92 X0",
        "G1 X2 Y5 F500",
        "G93 G1 X1 Y5 F2",
        "G1 X2 Y5 F2",
        "$H",
        "G1 X1",
    ]
    compact = Compact()
    assert [compact.line(row.encode()).decode() for row in rows] == [
        "G90G94G21",
        "G1X10Y5F500",
        "Y6.5",
        "G2X1Y1I.5J0",
        "X2Y1I1J0",
        "G1Y5",
        "G91G1X2Y0",
        "G90X2Y5",
        "G92X0",
        "G1X2Y5F500",
        "G93G1X1Y5F2",
        "G1X2Y5F2",
        "$H",
        "G1X1",
    ]


@pytest.mark.parametrize("word", ["T2 M6", "M0", "M1", "M98 P5", "M101"])
def test_A19_compact_says_every_axis_again_where_something_else_may_have_moved_it(word):
    """A change of tools on LinuxCNC ends at its own place: X left out would stay there."""
    compact = Compact(absolute=True)
    for row in ("G0 X10. Y20.", word):
        compact.line(row.encode())
    assert compact.line(b"G0 X10. Y30.") == b"G0X10Y30"
    quiet = Compact(absolute=True)
    for row in ("G0 X10. Y20.", "M3 S100", "M8", "M9", "M5"):
        quiet.line(row.encode())
    assert quiet.line(b"G0 X10. Y30.") == b"Y30"


@pytest.mark.parametrize("seed", range(6))
def test_A19_compact_halves_the_bytes_and_moves_no_coordinate(seed):
    """Judge: the model, told both, ends every line at the same place."""
    r = random.Random(seed)
    rows = ["G21 G90 G94 G17"]
    x = y = 0.0
    for i in range(400):
        x, y = (x, y + 0.25) if r.random() < 0.5 else (x + 0.5, y)
        rows.append(f"N{10 * i} G01 X{x:.4f} Y{y:.4f} Z-0.5000 F1200.0")
        if r.random() < 0.05:
            rows.append(
                r.choice(
                    ("G91", "G90", "G0 Z5.000", "G54", "G55", "G4 P0.1", "G20", "G21", "M3 S1000")
                )
            )
    compact = Compact(absolute=False)
    places_of = []
    sizes = []
    for shorten in (lambda t: t, compact.line):
        wire = [shorten(row.encode()) for row in rows]
        sizes.append(sum(len(w) + 1 for w in wire))
        model = GrblModel(baud=0, blocks=10_000)
        model.stored["G55"] = [1.0, 2.0, 3.0]
        ends = []
        for w in wire:
            model._execute(w.decode().replace(" ", ""))
            model._pending = None
            ends.append(list(model.target))
        places_of.append(ends)
    assert places_of[0] == places_of[1]
    assert sizes[1] < 0.5 * sizes[0]


def test_A19_a_link_that_is_too_slow_is_reported_with_numbers():
    """0.1 mm at 6000 mm/min are 1000 lines/s; 20 bytes a line at 115200 baud are 576 a second."""
    load = Load(11520.0)
    for i in range(100):
        load.add(WireLine(i + 1, i + 1, 0, b"G" * 19, seconds=0.001))
    said = load.warning()
    assert "1000 lines/s of 20 bytes" in said and "carries 576" in said
    slow = Load(11520.0)
    for i in range(100):
        slow.add(WireLine(i + 1, i + 1, 0, b"G" * 19, seconds=0.01))
    assert slow.warning() == ""


@pytest.mark.parametrize("feed", [300, 6000])
def test_A18_the_expected_time_is_within_20_per_cent_on_a_paced_model(feed):
    r = random.Random(4)
    rows = ["G21G90G94"] + [
        f"G1X{r.uniform(0, 2):.4f}Y{r.uniform(0, 2):.4f}F{feed}" for _ in range(300)
    ]
    source = Source(filter_("perfect"), Grbl().prepare)
    lines = source.feed("\n".join(rows).encode() + b"\n")
    load = Load(11520.0)
    for line in lines:
        load.add(line)
    model = GrblModel()
    sender = new_sender(model)
    seconds = run(sender, model, lines)
    assert sender.outcome.kind == "done"
    assert load.expected == pytest.approx(seconds - 0.4, rel=0.2)


@pytest.mark.parametrize(
    ("dialect", "block", "seconds"),
    [
        ("grbl", b"G4 P0.5", 0.5),
        ("marlin", b"G4 P500", 0.5),
        ("marlin", b"G4 S2", 2.0),
        ("grbl", b"G40", 0.0),
    ],
)
def test_a_dwell_rests_as_long_as_its_dialect_says(dialect, block, seconds):
    prepare = {"grbl": Grbl, "marlin": Marlin}[dialect]().prepare
    source = Source(filter_(dialect=dialect), prepare)
    lines = source.feed(b"G21\nG90\n" + block + b"\n") + source.finish()
    assert lines[-1].seconds == pytest.approx(seconds)
