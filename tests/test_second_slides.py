"""U V W, second slides along X Y Z (a quill on a boring mill's head): where the tip is by exact
transforms, programs through the filter, and that a block takes the time that it took on a control
that takes F along X Y Z where any of them moves."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc.commands import machine_facts
from postproc.compensate import Options
from postproc.errors import GcompError, ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import along, parse
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.pages import machine as machine_page
from postproc.verify import Verifier
from tests.reference.kinematics import Link, tip
from tests.test_machine_kinds import HEAD, machine

LETTERS = "XYZUVW"
MACHINES = Path(__file__).resolve().parents[1] / "machines"
CHAINS = (
    "w-X-Y-b-Z-W-t",
    "w-b-X-Y-W-Z-t",
    "w-W-X-b-Y-Z-t",
    "w-U-Y-X-b-Z-V-W-t",
    "w-Z-b-X-U-Y-t",
    "w-V-b-Y-t",
    "w-W-Z-b-X-t",
)


def random_machine(rng, text):
    """Flat tables, so that the errors at a pose are plain numbers, and the links of the same for
    the transforms."""
    chain = parse(text)
    axes, square, links = {}, {}, []
    tool = rng.uniform(-150, 150, 3)
    for letter in sorted(chain.axes, key=LETTERS.index):
        errors = np.concatenate([rng.uniform(-0.05, 0.05, 3), rng.uniform(-60e-6, 60e-6, 3)])
        lean = np.where(np.arange(3) == along(letter), 0.0, rng.uniform(-100e-6, 100e-6, 3))
        measured, optic = rng.uniform(-200, 200, 3), str(rng.choice(["", "tool", "workpiece"]))
        flat = np.repeat(errors[:, None], 2, axis=1)
        table = AxisTable(letter, np.array([-400.0, 400.0]), flat, flat)
        axes[letter] = Axis(letter, (-400.0, 400.0), 1e-4, measured, table, optic)
        square[letter] = lean
        carried = chain.axes[chain.axes.index(letter) + 1 :]
        counts = np.where([any(along(x) == i for x in carried) for i in range(3)], measured, 0.0)
        one = Link(
            "XYZ"[along(letter)],
            chain.side(letter),
            float(rng.uniform(-300, 300)),
            errors[:3],
            errors[3:],
            np.zeros(3),
            lean,
            counts,
            np.zeros(3),
            optic,
        )
        links.append((letter, one))
    links.sort(key=lambda pair: chain.axes.index(pair[0]))
    return Machine("m", "", "linuxcnc", chain, axes, square=square, tool=tool), dict(links)


@pytest.mark.parametrize("chain", CHAINS)
def test_first_order_terms_are_those_of_the_transforms(chain):
    rng = np.random.default_rng(list(chain.encode()))
    for _ in range(6):
        m, links = random_machine(rng, chain)
        order = list(links.values())
        slope = (tip(order, m.tool, 1e-3) - tip(order, m.tool, -1e-3)) / 2e-3
        place = np.array([[links[x].q] for x in m.letters])
        e = dict(zip(m.letters, m.deviation(place, np.zeros_like(place))[:, 0], strict=True))
        for i, x in enumerate("XYZ"):
            if x in e:
                assert e[x] == pytest.approx(slope[i], abs=1e-9), (chain, x)
        assert not any(e[x] for x in e if x in "UVW")  # what they miss is made up for by X Y Z


def test_where_the_others_stood_counts_by_slide(tmp_path):
    """An angle of X turns the arm of Z and W together; W alone is what W carries of them:
    nothing."""
    axes = "".join(f"[axes.{x}]\ntravel = [-200.0, 200.0]\nleast_increment = 0.001\n" for x in "ZW")
    text = (
        HEAD.format(chain="w-X-b-Z-W-t")
        + axes
        + "[axes.X]\ntravel = [-9.0, 9.0]\nleast_increment = 0.001\n"
    )
    text += 'table = "X.csv"\nmeasured_at = { Z = 30.0, W = -10.0 }\n'
    m = machine(tmp_path, text, X="X_mm,EBX_urad\n-9,100\n9,100\n")
    place = {"X": 0.0, "Z": 50.0, "W": 25.0}
    e = m.deviation(np.array([[place[x]] for x in m.letters]), np.zeros((3, 1)))[:, 0]
    assert e[m.letters.index("X")] == pytest.approx(100e-6 * (50 + 25 - 20), abs=1e-12)


def test_a_second_slide_is_reported_in_mm_and_over_its_travel(tmp_path):
    """In the facts for programs and on the page; the volume reaches as far as W does."""
    text = HEAD.format(chain="w-X-b-Z-W-t")
    for x in "XZW":
        text += f"[axes.{x}]\ntravel = [-400.0, 500.0]\nleast_increment = 0.001\n"
        text += f'table = "{x}.csv"\n'
    flat = {x: f"{x}_mm,E{along}{x}_um\n-400,0\n500,0\n" for x, along in ("XX", "ZZ")}
    m = machine(tmp_path, text, **flat, W="W_mm,EZW_um\n-400,0\n0,0\n500,50\n")
    assert machine_facts.of(m)["axes"]["W"]["unit"] == "mm"
    page = machine_page.page(m).html()
    assert "travel of W, mm" in page and "W, mm" in page and "degrees" not in page
    assert "deviations of up to 50.0 um" in page
    drawn = [b["figure"] for b in machine_page.page(m).blocks if b["kind"] == "figure"]
    shown = [f["layout"]["xaxis"]["range"] for f in drawn if f["id"].startswith("axis-W")]
    assert shown == [[-400.0, 500.0]]


# -- through the filter ----------------------------------------------------------------------------


def quill(folder, rng):
    """A mill with a quill: tables in one and in both directions, angles and squareness, also of
    W."""
    text, files = (
        HEAD.format(chain="w-X-Y-b-Z-W-t").replace(
            "G54 = {}", "G54 = { X = 0, Y = 0, Z = 0, W = 0 }"
        ),
        {},
    )
    for x in "XYZW":
        text += (
            f'[axes.{x}]\ntravel = [-210.0, 210.0]\nleast_increment = 0.0001\ntable = "{x}.csv"\n'
        )
        own = "XYZ"[along(x)]
        names = [f"E{c}{x}_um{d}" for c in "XYZ" for d in (("_fwd", "_rev") if c == own else ("",))]
        names += [f"E{c}{x}_urad" for c in "ABC"]
        nodes = np.linspace(-210, 210, 6)
        table = {n: np.cumsum(rng.normal(size=6)) * 5 for n in names}
        table[f"E{own}{x}_um_rev"] = table[f"E{own}{x}_um_fwd"] + (4.0 if x != "W" else 0.0)
        rows = (
            ",".join(f"{v:.3f}" for v in (node, *(table[n][k] for n in names)))
            for k, node in enumerate(nodes)
        )
        files[x] = f"{x}_mm," + ",".join(names) + "\n" + "\n".join(rows) + "\n"
    text += "[squareness]\nB0W = 40.0\nA0Z = -30.0\n[tool]\nZ = -80.0\n"
    return machine(folder, text, **files)


def program(rng: random.Random) -> str:
    lines = ["G21 G90 G94 G54", "G0 X0 Y0 Z0 W0"]
    for _ in range(14):
        some = rng.choice(("W", "W", "X", "Z", "XY", "XW", "XYZW", "ZW"))
        words = " ".join(f"{x}{rng.uniform(-150, 150):.{rng.choice((0, 1, 3))}f}" for x in some)
        lines.append(
            f"{rng.choice(('G1', 'G1', 'G1', 'G0'))} {words}{rng.choice(('', ' F200', ' F55.5'))}"
        )
    lines.insert(2, "F300")
    return "\n".join(lines) + "\nM2\n"


@pytest.mark.parametrize("seed", range(12))
def test_programs_keep_the_tolerance_and_the_batch_law(tmp_path, seed):
    m = quill(tmp_path, np.random.default_rng(seed))
    text = program(random.Random(seed)).encode()
    filters = [
        Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
        for _ in range(2)
    ]
    verifier = Verifier(filters[0])
    whole = filters[0].feed(text) + filters[0].finish()
    assert (
        max(verifier.corrected.deviation, verifier.corrected.slide)
        <= 0.001 + 1.5 * 0.001 * np.sqrt(3) + 1e-4
    )
    assert verifier.uncorrected.deviation > 0.004
    cut = random.Random(seed).randrange(len(text))
    assert filters[1].feed(text[:cut]) + filters[1].feed(text[cut:]) + filters[1].finish() == whole


def arcs(rng: random.Random) -> str:
    lines, x, y = ["G21 G90 G94 G54 F300", "G0 X0 Y0 Z0 W0"], 0.0, 0.0
    for _ in range(8):
        to, up = (round(rng.uniform(-100, 100), 2) for _ in range(2))
        radius = np.hypot(to - x, up - y) / 2 * rng.uniform(1.05, 2)
        more = "".join(
            f" {letter}{rng.uniform(-150, 150):.2f}" for letter in rng.choice(("", "W", "ZW"))
        )
        lines.append(f"{rng.choice(('G2', 'G3'))} X{to} Y{up} R{radius:.3f}{more}")
        x, y = to, up
    return "\n".join(lines) + "\nM2\n"


@pytest.mark.parametrize("seed", range(12))
def test_arcs_keep_the_tolerance(tmp_path, seed):
    m = quill(tmp_path, np.random.default_rng(seed))
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
    verifier = Verifier(filter_)
    filter_.feed(arcs(random.Random(seed)).encode())
    filter_.finish()
    assert max(verifier.corrected.deviation, verifier.corrected.slide) <= 0.001 + 0.0015
    assert verifier.uncorrected.deviation > 0.01


# -- F ---------------------------------------------------------------------------------------------


def minutes(way: dict[str, float], feed: float) -> float:
    """LinuxCNC, src/emc/task/emccanon.cc, getStraightVelocity: along X Y Z where any of them moves,
    else U V W, else A B C."""
    for group in ("XYZ", "UVW", "ABC"):
        length = float(np.sqrt(sum(way.get(x, 0.0) ** 2 for x in group)))
        if length > 1e-9:
            return length / feed
    return 0.0


def times(text: bytes, letters: str) -> list[float]:
    """Minutes that each feed takes, by its block; nothing but G0 G1 G20 G21 and words, absolute."""
    place, feed, code, unit, result = dict.fromkeys(letters, 0.0), 0.0, 0, 1.0, []
    for line in text.decode().splitlines():
        values = {}
        for letter, value in re.findall(r"([A-Z]) *([-+.0-9]+)", line.split("(")[0]):
            value = float(value)
            if letter == "G" and value in (0, 1):
                code = int(value)
            unit = 25.4 if letter == "G" and value == 20 else unit
            values[letter] = value
        feed = values.get("F", feed)
        way = {x: values[x] - place[x] for x in letters if x in values}
        place.update({x: values[x] for x in letters if x in values})
        if way and code == 1:
            result.append(minutes(way, feed))
    return result


def lasts(m, text: str, offsets=None) -> tuple[float, float, bytes]:
    filter_ = Filter(
        m, dialects.load("linuxcnc"), setup_of(m, offsets or {}), Options(tolerance=0.001)
    )
    out = filter_.feed(text.encode()) + filter_.finish()
    letters = "".join(m.letters)
    return sum(times(text.encode(), letters)), sum(times(out, letters)), out


@pytest.mark.parametrize("seed", range(6))
def test_a_quill_takes_the_time_that_it_took(tmp_path, seed):
    m = quill(tmp_path, np.random.default_rng(seed))
    before, after, out = lasts(m, program(random.Random(seed)))
    assert after == pytest.approx(before, rel=0.01)
    assert out.count(b"F") > program(random.Random(seed)).count("F")


@pytest.mark.parametrize("inch", [False, True])
def test_a_turn_takes_the_time_that_it_took(inch):
    """A feed of degrees alone, in which 9 um of correction would have been all the way that F is
    along: 0.25 minutes for 90 degrees at F360, and not the fastest that the table can turn."""
    m = read_machine(MACHINES / "example-five-axis")
    one = "X3.9 Y3.9 Z1.9" if inch else "X100 Y100 Z40"
    text = (
        f"G{20 if inch else 21} G90 G94\nG0 {one} A0 C0\nG1 C90 F360\nC180\nG1"
        f" X{4.2 if inch else 120} F200\nC190\nC200 F100\nM2\n"
    )
    before, after, out = lasts(replace(m, offsets={"G54": dict.fromkeys("XYZAC", 0.0)}), text)
    assert after == pytest.approx(before, rel=0.01)
    lines = out.decode().splitlines()
    assert any("F0.0" in line for line in lines)


def test_a_feed_that_only_the_machine_knows_is_refused_there():
    m = read_machine(MACHINES / "example-five-axis")
    m = replace(m, offsets={"G54": dict.fromkeys("XYZAC", 0.0)})
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
    with pytest.raises(ProgramError, match="F is not known as a number"):
        filter_.feed(b"G21 G90\nG0 X100 Y100 Z50 A0 C0\nF100\nG1 C90 F#<_hal[feed]>\nM2\n")
        filter_.finish()


def five_axes(**axes):
    m = read_machine(MACHINES / "example-five-axis")
    m = replace(m, offsets={"G54": dict.fromkeys("XYZAC", 0.0)})
    return replace(m, axes={**m.axes, **axes})


def test_an_axis_that_no_block_names_takes_no_part_in_it():
    """Without B the turn of 37 degrees is written with an F of its own, and with B too."""
    text = "G21 G90 G94\nG0 X10 Y10 Z10 A0 C0\nG1 C90 F360\nC37\nM2\n"
    still = Axis("B", (-1e9, 1e9), 1e-4, np.zeros(3), None, "")
    for m in (five_axes(), five_axes(B=still)):
        before, after, out = lasts(m, text)
        assert after == pytest.approx(before, rel=0.01)
        assert b"F0." in out


@pytest.mark.parametrize("start", [{}, {"C": 0.0}])
def test_a_turn_from_nobody_knows_where_is_refused(start):
    """X Y Z have a correction for C90, and F360 would be along that: in a blink."""
    m = five_axes()
    filter_ = Filter(
        m,
        dialects.load("linuxcnc"),
        replace(setup_of(m, {}), start=start),
        Options(tolerance=0.001),
    )
    text = b"G21 G90 G94\nG0 X10 Y10 Z10 A0\nG1 C90 F360\nM2\n"
    if start:
        assert b"F0." in filter_.feed(text) + filter_.finish()
        return
    with pytest.raises(ProgramError, match="where C stands before this feed is not known"):
        filter_.feed(text)
        filter_.finish()


@pytest.mark.parametrize("stated", ["F50", "G0 Z11 F50", "F50 M8 (set)"])
@pytest.mark.parametrize("cut", [0, 4, 5, 6])
def test_an_f_of_the_program_between_two_feeds_is_in_force(tmp_path, stated, cut):
    """X follows W by 1 and then by 2 um a mm, so that F0.1 and F50 times 0.002 are nearly alike."""
    m = quill(tmp_path, np.random.default_rng(0))
    deviation = np.zeros((6, 3))
    deviation[0] = 0.0, 0.01, 0.03
    leans = AxisTable("W", np.array([0.0, 10.0, 20.0]), deviation, deviation)
    axes = {x: replace(a, table=leans if x == "W" else None) for x, a in m.axes.items()}
    m = replace(m, axes=axes, square={})
    text = f"G21 G90 G94\nG0 X10 Y10 Z10 W0\nG1 W10 F100\n{stated}\nG1 W20\nM2\n"
    text = text.splitlines(True)
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
    out = b"".join(filter_.feed("".join(x).encode()) for x in (text[:cut], text[cut:]))
    out += filter_.finish()
    before, after = (sum(times(x, "".join(m.letters))) for x in ("".join(text).encode(), out))
    assert after == pytest.approx(before, rel=0.02), out.decode()


@pytest.mark.parametrize("name", ["fanuc-lathe", "haas-lathe"])
def test_a_letter_that_is_an_increment_on_that_control_is_no_slide_there(tmp_path, name):
    m = quill(tmp_path, np.random.default_rng(0))
    with pytest.raises(GcompError, match="an axis W, and W is an increment of Z"):
        Filter(m, dialects.load(name), setup_of(m, {}), Options(tolerance=0.001))
