"""Strokes that are known to need no cut: none of them gets one where all places are looked for, and
what is known of them holds."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from postproc.compensate import Options, turning, uncut
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.units import TICKS_PER_MM
from tests.reference.tool_point import random_truth
from tests.small_machines import write_mill
from tests.stated_machines import machine as stated
from tests.test_cuts import BY, NOTHING, by_two, machine

ROOT = Path(__file__).resolve().parents[1]
WAYS = (0.02, 0.5, 5.0, 80.0)  # mm
FAR = 1e9  # mm
# fmt: off
TILTED = "X_mm,EXX_um,EYX_um,EBX_urad\n-10,0,0,0\n60,3,-1,9\n110,-2,4,0\n400,5,0,3\n"
# fmt: on


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    folder = tmp_path_factory.mktemp("uncut")
    found = {x: read_machine(ROOT / "machines" / x) for x in ("studer-s36", "example-five-axis")}
    for name, both in (("mill", False), ("two-way", True)):
        found[name] = read_machine(write_mill(folder / name, both))
    return found | {"by two": read_machine(by_two(folder / "by", BY))}


def motions(m, rng: np.random.Generator, way: float) -> tuple[np.ndarray, np.ndarray]:
    """(A, N) mm and degrees: where straight motions begin and end, beyond the tables too."""
    low, high = np.array([m.ranges.get(x, (-9.0, 9.0)) for x in m.letters]).T[:, :, None]
    start = low - 5 + (high - low + 10) * rng.random((len(m.letters), 300))
    moves = rng.random(start.shape) < 0.7
    return start, start + way * rng.uniform(-1, 1, start.shape) * moves


@pytest.mark.parametrize("name", ["studer-s36", "mill", "two-way", "by two", "example-five-axis"])
def test_no_deviation_leaves_its_chord_by_more_than_the_bow(machines, name):
    """Straight motions of 0.02 to 80 mm, looked at in 101 places; many come near to the bound."""
    m, rng = machines[name], np.random.default_rng(5)
    t = np.linspace(0, 1, 101)
    nearest = 0.0
    for way in WAYS:
        start, target = motions(m, rng, way)
        side = rng.integers(-1, 2, start.shape)
        places = start[:, :, None] + (target - start)[:, :, None] * t
        off = m.deviation(places.reshape(len(start), -1), np.repeat(side, len(t), axis=1))
        off = off.reshape(places.shape)
        chord = off[:, :, :1] + (off[:, :, -1:] - off[:, :, :1]) * t
        miss = np.linalg.norm(off - chord, axis=0).max(axis=1)
        bow = m.bounds.bow(start, target)
        assert (miss <= bow + 1e-12).all(), way
        near = miss / np.maximum(bow, 1e-7)
        nearest = max(nearest, near.max())
    assert nearest > 0.45


def both_ways(monkeypatch, m, text: str, dialect: str = "linuxcnc", **options) -> tuple[str, int]:
    """The output, which is the same where every stroke is looked at, and how many strokes were
    known to need no cut."""
    known, found = [], []

    def counted(b, chosen):
        known.append(sure := uncut_proven(b, chosen))
        return sure

    uncut_proven = uncut.proven
    for way in (counted, lambda b, chosen: np.zeros(len(chosen), bool)):
        monkeypatch.setattr(uncut, "proven", way)
        setup = setup_of(m, {"H1": {"Z": 80.0}, "T1": {"R": 10.0}, "G54": {}})
        filter_ = Filter(m, dialects.load(dialect), setup, Options(**options))
        found.append((filter_.feed(text.encode()) + filter_.finish()).decode())
    monkeypatch.undo()
    assert found[0] == found[1]
    return found[0], sum(int(sure.sum()) for sure in known)


def test_most_short_strokes_over_nodes_are_known(machines, monkeypatch):
    """Lines of half a millimetre on a mill and on a grinder with lost motion, here and there
    longer ones that are cut."""
    rng = np.random.default_rng(3)
    for name, letters in (("mill", "XYZ"), ("two-way", "XYZ"), ("studer-s36", "XZ")):
        place, lines = np.full(len(letters), 12.0), []
        way = np.full(len(letters), 1.0)
        for k in range(400):
            place += way * rng.uniform(0, 0.6, len(letters)) * (40 if k % 50 == 49 else 1)
            way = np.where(place > 35, -1, np.where(place < 5, 1, way))
            words = zip(letters, np.clip(place, 1.0, 39.0), strict=True)
            lines.append(" ".join(f"{x}{v:.3f}" for x, v in words))
        text = f"G21 G90\nG0 {lines[0]}\nG1 F500\n" + "\n".join(lines[1:]) + "\nM2\n"
        out, known = both_ways(monkeypatch, machines[name], text)
        assert known > 5 and len(out.splitlines()) > len(text.splitlines()) + 1, name


def kinked(folder: Path, x: str, z: str = NOTHING, step: float = 0.00001):
    return read_machine(machine(folder, x, z, step))


def roof(top: float, um: float, lean: float = 0.0, off: float = 0.0) -> str:
    """EXX of a roof with its top at X = `top`, um below it at 10 mm to either side, that leans by
    um/mm."""
    rows = ((x, off + lean * x - um * abs(x - top) / 10) for x in (-10.0, top, 100.0))
    return "X_mm,EXX_um\n" + "".join(f"{x},{value}\n" for x, value in rows) + f"400,{off}\n"


FLAT = "Z_mm,EZZ_um\n-10,1\n5,1\n900,1\n"


def test_the_rounding_at_nodes_counts(tmp_path, monkeypatch):
    """Steps of 1 um: X is 0.3 to 1 um off its chord at one node, of which 0.5 um and the rounding
    are allowed; a chord that ends at another node, which Z passes, is rounded there. Of random ones
    few tell; two of these come first."""
    cases = [
        (0.12760855734, 0.96788355178, 0.00934184337, 95.541816426),
        (0.14778990044, 0.95199940238, 0.00807609530, 96.239600321),
    ]
    rng = np.random.default_rng(2)
    cases += [tuple(rng.uniform((0.06, 0, -0.01, 52), (0.2, 1, 0.01, 99))) for _ in range(60)]
    known = cut = 0
    for k, (um, off, lean, node) in enumerate(cases):
        x, z = roof(50, um, lean, off), f"Z_mm,EZZ_um\n-10,0\n{node},0\n900,0.01\n"
        text = "G21 G90\nG1 X0 Z0 F500\nX100 Z100\nZ50\nM2\n"  # Z50 is known in any case
        m = kinked(tmp_path / str(k), x, z, step=0.001)
        out, sure = both_ways(monkeypatch, m, text, tolerance=0.001)
        known, cut = known + sure, cut + (len(out.splitlines()) > 6)
    assert known > len(cases) + 5 and cut > 5


# EXZ in um
HELD = "Z_mm,EXZ_um\n-10,0\n0,0\n70,{1}\n140,0.1\n900,0\n"
HELD_BEFORE = "Z_mm,EXZ_um\n-10,0\n0,0\n20,{0}\n80,{2}\n140,{0}\n900,0\n"


@pytest.mark.parametrize("z, blocks", [(HELD, "Z140\n"), (HELD_BEFORE, "Z20\nX51 Z140\n")])
def test_what_the_ends_miss_counts(tmp_path, monkeypatch, z, blocks):
    """X rests and is held beside its command by 0.1 um where this stroke ends, or up to 0.15 um
    where the next one begins, on which it leaves its chord by as much or more, where 0.16 and
    0.31 um are allowed."""
    known = cut = 0
    for k in range(40):
        share = k / 39
        table = z.format(0.15 * share, 0.3 * share, 0.15 * share + 0.27)
        m = kinked(tmp_path / str(k), "X_mm,EXX_um\n-10,0\n400,0\n", table)
        text = f"G21 G90\nG1 X50 Z0 F500\n{blocks}M2\n"
        out, sure = both_ways(monkeypatch, m, text, tolerance=0.0005)
        known, cut = known + sure, cut + (len(out.splitlines()) > len(text.splitlines()) + 1)
    assert known > 5 and cut > 5


def test_what_is_found_at_commands_of_a_steep_map_counts(tmp_path, monkeypatch):
    """X leaves its chord by 0.2 to 0.33 um at a node on a slope of 40 um/mm, where 0.31 are
    allowed, and its command by 8 % more."""
    known = cut = 0
    for k in range(40):
        m = kinked(tmp_path / str(k), roof(10, 0.2 + k / 300, lean=-40.0))
        text = "G21 G90\nG1 X0 Z0 F500\nX20 Z90\nM2\n"
        out, sure = both_ways(monkeypatch, m, text, tolerance=0.0005)
        known, cut = known + sure, cut + (len(out.splitlines()) > 5)
    assert known > 5 and cut > 5


def test_a_node_that_only_the_command_passes_counts(tmp_path, monkeypatch):
    """X goes to 99.6 mm and its command to 100.6, beyond a node where its error turns; Z passes one
    at which nothing bends."""
    x = "X_mm,EXX_um\n-10,-1000\n100,-1000\n101,-950\n400,-950\n"
    text = "G21 G90\nG1 X98.9 Z0 F500\nX99.6 Z6\nM2\n"
    out, known = both_ways(monkeypatch, kinked(tmp_path / "m", x, FLAT), text)
    assert known == 0 and len(out.splitlines()) == 6


@pytest.mark.parametrize("way, side, known", [(9, 1, True), (-9, 1, False), (-9, -1, True)])
def test_of_an_axis_that_goes_back_within_its_play_nothing_is_known(way, side, known):
    """By 9 of 10 increments that count, without errors: it is not led along the chord."""
    column = np.zeros((1, 1))
    b = SimpleNamespace(
        inside=False, tip=False, rows=[0], motion=np.zeros(1, int), weight_begin=column + side,
        begin=column.astype(int), end=column.astype(int) + way * TICKS_PER_MM // 10_000,
        begin_nominal=column, end_nominal=column + way / 10_000, travel=column + way,
        c=SimpleNamespace(followed=[0], chord=0.001),
        m=SimpleNamespace(grid=column + TICKS_PER_MM // 10_000),
        machine=SimpleNamespace(
            deviation=lambda place, weight: 0 * place,
            bounds=SimpleNamespace(steepest=0.0, bow=lambda begin, end: 0 * end[0]),
        ),
    )  # fmt: skip
    assert uncut.proven(b, np.zeros(1, int)).tolist() == [known]


def test_a_tool_tip_is_not_led_along_the_slides(tmp_path, monkeypatch):
    """G43.4: no axis of the tip has a table of its own."""
    truth = random_truth(np.random.default_rng(11), "w-C-A-b-X-Y-Z-t")
    m = read_machine(truth.write(tmp_path, "fanuc-mill", ""))
    t = np.linspace(0, 6, 12)
    path = [f"G1 X{40 * np.cos(a):.3f} Y{40 * np.sin(a):.3f} A{5 * a:.3f} C{9 * a:.3f}" for a in t]
    head = "G21 G90 G54\nG0 X40. Y0. Z0. A0. C0.\nG43.4 H1\nG0 X40. Y0. Z0.\nG1 F500.\n"
    text = head + "\n".join(path) + "\nG49\nM30\n"
    out, known = both_ways(monkeypatch, m, text, "fanuc-mill")
    assert known == 0 and len(out.splitlines()) > len(text.splitlines()) + 1


def test_inside_a_contour_the_map_is_read_beside_the_stroke(tmp_path, monkeypatch):
    """G41, a tool of 10 mm: the contour passes a node of X at which nothing bends, and its centre,
    up to Y 22, a roof of Y between 19 and 21."""
    y = "Y_mm,EYY_um\n-500,0\n19,0\n20,2\n21,0\n500,0\n"
    x = "X_mm,EXX_um\n-500,1\n100,1\n500,1\n"
    m = stated(tmp_path / "m", X=x, Y=y, Z="Z_mm,EZZ_um\n-500,0\n500,0\n")
    text = (
        "G21 G90 G17 G54 T1 M6\nG0 X-50 Y0 Z0\nG41 G1 X0 Y8 F500\nX200 Y12\nX290\nG40 X350 Y0\nM2\n"
    )
    out, known = both_ways(monkeypatch, m, text)
    assert known == 0 and len(out.splitlines()) > len(text.splitlines()) + 1, out


@pytest.mark.parametrize("side", [1, -1])
def test_what_bends_by_no_more_than_it_may_turn_back_is_not_divided(tmp_path, monkeypatch, side):
    """X rests, and the straightness of Z leads it by 0.3 to 0.7 um to a roof and back, where from
    0.5 um on it turns: the motions that are looked at are those that are divided, and one that
    nearly is."""
    looked, divided = [], []
    turns = turning._turns

    def counted(owner, *rest):
        looked.append(len(set(owner.tolist())))
        found = turns(owner, *rest)
        divided.append(len(found[0]))
        return found

    monkeypatch.setattr(turning, "_turns", counted)
    for k in range(41):
        um = side * (0.3 + k / 100)
        z = f"Z_mm,EXZ_um\n-10,0\n70,{um}\n150,0\n600,0\n700,9\n900,9\n"
        m = kinked(tmp_path / str(k), "X_mm,EXX_um_fwd,EXX_um_rev\n-10,-3,3\n400,-3,3\n", z)
        text = "G21 G90\nG1 X50 Z-10 F500\nX60\nZ150\nM2\n"
        filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.0002))
        assert filter_.feed(text.encode()) + filter_.finish()
    assert sum(divided) == 20 and sum(looked) == 21
