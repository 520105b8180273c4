"""Arcs are judged by few samples and a bound of what can hide between them; here by very many
samples.

Every piece that the fit accepts is drawn as the control draws it, and measured at a thousand
places: nowhere may it be farther from what the slides should do than the proof says it can be,
and where the proof says so it must be near enough. The bound must also be worth something: on
smooth maps it asks for two pieces an arc at most."""

from __future__ import annotations

import math
import sys
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from fuzz.cases import Case, filter_of
from test_arc_words import ZERO, random_arcs

from postproc.compensate import Options, fit, prove, samples, stretches
from postproc.compensate.arcs import direction, height, points, quadrants
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.units import TICKS_PER_MM, UM
from postproc.verify import Verifier
from tests.small_machines import write_mill

pytestmark = pytest.mark.usefixtures("both_ways")
DENSE = 1001


def test_directions_and_heights_are_those_of_the_cosine():
    """By the tangent of half the angle, all around and at the quadrants themselves; a flat arc's
    height keeps its digits, which 1 - cos would lose."""
    angle = np.concatenate([np.linspace(-13.0, 13.0, 100_001), np.arange(-8, 9) * np.pi / 2])
    assert np.abs(direction(angle) - [np.cos(angle), np.sin(angle)]).max() < 4e-16
    sweep = np.array([1e-9, 1e-3, 1.0, np.pi, 2 * np.pi])
    assert height(sweep) == pytest.approx(2 * np.sin(sweep / 4) ** 2, rel=1e-15)


@pytest.mark.parametrize("sweep", [-6.2, -1.0, 0.3, 4.1])
def test_quadrants_come_in_the_order_of_the_way(sweep):
    """All that lie on the arc, of either sense, between two others."""
    one = MagicMock(angle=np.array([0.1, -2.0, 3.0]), sweep=np.array([9.0, sweep, -9.0]))
    one.__len__ = lambda self: 3
    arc, t = quadrants(one)
    for k in range(3):
        turned = np.sin(2 * (one.angle[k] + one.sweep[k] * np.linspace(0.0, 1.0, 100_001)))
        passed = np.flatnonzero(turned[1:] * turned[:-1] <= 0) / 100_000
        assert t[arc == k] == pytest.approx(passed, abs=2e-5)
    assert (np.diff(arc) >= 0).all()


def drawn(f, rows, k, t):
    """(A, K) mm where the control stands at shares t of piece k, its ticks read as a control
    reads them."""
    arcs, arc = f.arcs, rows.arc[k]
    begin, end = rows.begin[:, k] / TICKS_PER_MM, rows.end[:, k] / TICKS_PER_MM
    way = begin[:, None] + (end - begin)[:, None] * t
    axes = [arcs.first[arc], arcs.second[arc]]
    centre = begin[axes] + rows.centre[:, k] / TICKS_PER_MM
    sweep = arcs.sweep[arc] * (rows.t1[k] - rows.t0[k])
    (x0, y0), (x1, y1) = begin[axes] - centre, end[axes] - centre
    turned = (np.arctan2(y1, x1) - np.arctan2(y0, x0) - sweep + np.pi) % (2 * np.pi) - np.pi + sweep
    angle = np.arctan2(y0, x0) + turned * t
    radius = np.hypot(x0, y0) + (np.hypot(x1, y1) - np.hypot(x0, y0)) * t
    way[axes] = centre[:, None] + radius * np.stack([np.cos(angle), np.sin(angle)])
    return way


def judged(f, rows, most):
    """The farthest that any piece is from what the slides should do, as a share of what its proof
    allows."""
    worst = 0.0
    t = np.linspace(0.0, 1.0, DENSE)
    for k in np.flatnonzero(~rows.chord):
        one = rows.pick(np.full(DENSE, k))
        where = rows.t0[k] + (rows.t1[k] - rows.t0[k]) * t
        nominal = points(f.arcs, f.start, f.target, one.arc, where)
        wanted = f.needed(one, np.arange(DENSE), where, nominal)
        there = drawn(f, rows, k, t)
        plane = [f.arcs.first[rows.arc[k]], f.arcs.second[rows.arc[k]]]
        centre = rows.begin[plane, k] / TICKS_PER_MM + rows.centre[:, k] / TICKS_PER_MM
        off = np.hypot(*(wanted[plane] - centre[:, None]))
        off -= np.hypot(*(there[plane] - centre[:, None]))
        across = [a for a in f.machine.corrected if a not in plane]
        beside = np.sqrt(off**2 + ((wanted - there)[across] ** 2).sum(axis=0))
        worst = max(worst, float(beside.max()) / most)
    return worst


@pytest.fixture
def settled(monkeypatch):
    """What is fitted from now on: each fitter with its pieces."""
    found, settle = [], fit.settle

    def seen(f, rows):
        result = settle(f, rows)
        found.append((f, result))
        return result

    monkeypatch.setattr(fit, "settle", seen)
    return found


def nothing_hides(folder, text: str, settled, tolerance: float) -> None:
    machine = read_machine(folder)
    options = Options(tolerance=tolerance)
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine, ZERO), options)
    filter_.feed(text.encode())
    filter_.finish()
    assert settled
    for f, rows in settled:
        half = f.arcs.grid.min() / TICKS_PER_MM / 2
        assert judged(f, rows, f.total + half) <= 1.0


@pytest.mark.parametrize("two_way", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_nothing_hides_between_samples(tmp_path, settled, two_way, seed):
    folder = write_mill(tmp_path / "mill", two_way)
    nothing_hides(folder, random_arcs(seed, 25), settled, 0.001)


@pytest.mark.parametrize("two_way", [False, True])
def test_nothing_hides_between_few_samples(tmp_path, monkeypatch, settled, two_way):
    """Where six times as much may be left to the bound: the tops between samples count."""
    sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
    import files
    import machine as mill

    monkeypatch.setattr(stretches, "SHARE", 0.4)
    mill.write_machine(tmp_path / "mill", two_way)
    nothing_hides(tmp_path / "mill", "\n".join(islice(files.write_c(1000), 124)), settled, 0.0005)


def test_an_axis_beside_the_plane_is_as_far_off_as_the_top_between_samples():
    """By hand: a parabola through 0 1 1 0 rises by an eighth of its second difference, 1, more."""
    value = np.array([0.0, 1.0, 1.0, 0.0])
    bent = samples.bent(value, np.array([0.0, 0.5, 0.5, 0.0]))
    assert bent.tolist() == [0.5, 0.5, 0.5, 0.0]
    s = SimpleNamespace(beside=(2,), across=value[None], turn=bent[None])
    proof = SimpleNamespace(s=s, _bow=lambda axis, command: command)
    (bow,) = prove.Proof._bows.func(proof)
    assert bow.tolist() == [0.0, 1.125, 1.125, 0.0]


def test_a_run_is_proven_the_same_alone_and_among_others(tmp_path, monkeypatch):
    """Where an arc is cut follows from how far its runs were off, which runs beside it must not
    change: a batch may end anywhere."""
    tried, looked, apart = fit.Cutting.tried, 0, []

    def alone(cutting, low, high, which=slice(None)):
        nonlocal looked
        good, proof = tried(cutting, low, high, which)
        rows = np.arange(len(cutting.rows))[which]
        for k in range(0, len(good), 5):
            one = slice(k, k + 1)
            same, by_itself = tried(cutting, low[one], high[one], rows[one])
            looked += 1
            if (same[0], by_itself.excess[0]) != (good[k], proof.excess[k]):
                apart.append((good[k], same[0], proof.excess[k], by_itself.excess[0]))
        return good, proof

    monkeypatch.setattr(fit.Cutting, "tried", alone)
    machine = read_machine(write_mill(tmp_path / "mill", True))
    options = Options(tolerance=0.001)
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine, ZERO), options)
    filter_.feed(random_arcs(1, 60).encode())
    filter_.finish()
    assert looked > 100 and not apart


@pytest.mark.parametrize("seed", [1, 5])
def test_arcs_are_cut_the_same_beside_one_of_two_turns(tmp_path, seed):
    """What hides between samples has a bound of its own on arcs of one turn at most; on others
    samples lie densely. Both kinds in one portion, and line by line."""
    machine = read_machine(write_mill(tmp_path / "mill", False))
    first, rest = random_arcs(seed, 25).split("F1000\n")
    lines = f"{first}F1000\nG2 X100 Y0 Z1 I-20 J0 P2\n{rest}".encode().splitlines(keepends=True)
    made = []
    for portions in ([b"".join(lines)], lines):
        options = Options(tolerance=0.0005)
        filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine, ZERO), options)
        made.append(b"".join([*map(filter_.feed, portions), filter_.finish()]))
    assert made[0] == made[1]


def test_a_smooth_map_asks_for_two_pieces_an_arc(tmp_path):
    """The arcs and the mill of the benchmarks: 200 arcs of 0.5 to 20 mm, 0.35 to 5 rad, and 21
    errors of up to 30 um."""
    sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
    import files
    import machine as mill

    mill.write_machine(tmp_path / "mill")
    machine = read_machine(tmp_path / "mill")
    text = "\n".join(islice(files.write_c(1000), 204)) + "\nM30\n%\n"
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine, ZERO))
    out = filter_.feed(text.encode()) + filter_.finish()
    arcs = sum(line.startswith((b"G2 ", b"G3 ")) for line in text.encode().splitlines())
    assert arcs == 200
    assert out.count(b"\n") - text.count("\n") <= arcs


@pytest.mark.parametrize("sweep", [4.0, -4.0])
@pytest.mark.parametrize("role", [0, 1])
def test_nodes_lie_where_the_command_passes_them(role, sweep):
    """The circle's place there, with the share of the shift that has come by then, is the node; as
    many are found as a thousand steps pass."""
    centre, t0, t1, shift = np.array([10.0, 20.0]), 0.2, 0.9, (0.3, -1.5)
    node = centre[role] + np.arange(-47.0, 48.0, 5.0)
    n = len(node)
    f = SimpleNamespace(
        arcs=SimpleNamespace(
            centre=centre[:, None],
            radius=np.array([50.0]),
            sweep=np.array([sweep]),
            angle=np.array([0.3]),
        )
    )
    rows = SimpleNamespace(arc=np.zeros(n, int), t0=np.full(n, t0), t1=np.full(n, t1))

    def command(t):
        turned = (np.cos, np.sin)[role](0.3 + sweep * t)
        return centre[role] + 50 * turned + np.interp(t, [t0, t1], shift)

    found = stretches._on_circle(f, rows, np.arange(n), node, role, np.outer(shift, np.ones(n)))
    assert command(found[1]) == pytest.approx(node[found[0]], abs=1e-3)
    course = command(np.linspace(t0, t1, 1000))
    passed = np.diff(course[:, None] > node, axis=0).sum(axis=0)
    assert np.bincount(found[0], minlength=n).tolist() == passed.tolist() and passed.sum() > 9


def between(value, h):
    """What is said of values (K, 3) at samples -h, 0, h: how far they can lie from zero there."""
    turn = samples.bent(value, np.array([0.0, samples.BENT, 0.0]))
    return (np.abs(value) + samples.beyond(value, turn)).max(axis=1)


@pytest.mark.parametrize("h", [0.02, 0.2, stretches.WIDEST])
def test_a_wave_of_one_per_turn_needs_no_rest(h):
    """Wherever its top lies, and however large the shift of the centre that makes it; a parabola's
    share of the second difference would not do."""
    top, level = np.linspace(-h, h, 801)[:, None], np.linspace(-2.0, 2.0, 9)[:, None, None]
    wave = level + np.cos(np.array([-h, 0.0, h]) - top)
    dense = level + np.cos(np.linspace(-h, h, 2001) - top)
    said = between(wave.reshape(-1, 3), h).reshape(9, -1)
    assert (np.abs(dense).max(axis=2) <= said * (1 + 1e-12)).all()
    assert said[-1].max() < 3.0 + 0.03 * h**2


@pytest.mark.parametrize("h", [0.1, 0.3, stretches.WIDEST])
def test_a_stretched_circle_leaves_what_is_said_between_samples(h):
    """The image of a circle of 10 mm where X is 100 um/m too long and Y as much too short: what
    waves of one per turn through three samples do not tell."""
    steep, radius, one = 2e-4, 10.0, np.zeros(1, int)
    bounds = SimpleNamespace(even=steep, cells={}, twist=np.zeros((2, 2)))
    f = SimpleNamespace(
        machine=SimpleNamespace(bounds=bounds, letters=("X", "Y")),
        arcs=SimpleNamespace(
            **dict.fromkeys(("radius", "radius_end"), np.array([radius])),
            angle=one, sweep=one + 1, first=one, second=one + 1, centre=np.zeros((2, 1)),
        ),
    )  # fmt: skip
    rows = SimpleNamespace(arc=one, t0=one, t1=one + 1)
    third = stretches._steepness(f, rows, one, one / 2, np.zeros((2, 2, 1)))[1][0]
    rest = stretches.REMAINDER * third * h**3
    missing = []

    def waves(angle):
        return np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=-1)

    for middle in np.arange(0.0, 6.3, 0.1):
        three, dense = middle + np.array([-h, 0.0, h]), middle + np.linspace(-h, h, 401)
        x, y = radius * (1 + steep / 2) * np.cos(dense), radius * (1 - steep / 2) * np.sin(dense)
        off = np.hypot(x, y) - radius
        part = np.linalg.solve(waves(three), off[[0, 200, 400]])
        missing.append(np.abs(off - waves(dense) @ part).max())
    assert 0.93 * rest < max(missing) <= rest


@pytest.mark.parametrize("third", [1e-9, 0.1, 40.0])
def test_what_hides_between_samples_by_hand(monkeypatch, third):
    """An arc of 2 rad without a node on it, of a third derivative (mm per cubic radian): samples
    are h apart, where h^3 third / (9 sqrt 3) is a sixteenth of the tolerance at most and h 0.5 rad;
    that remainder goes off the tolerance, and a quarter of the sixteenth for nodes left out."""
    arcs = SimpleNamespace(sweep=np.array([2.0]), radius=np.ones(1), radius_end=np.ones(1))
    f = SimpleNamespace(
        arcs=arcs, plain=np.ones(1, bool), total=0.001, tolerance=0.0007, tolerance_across=0.0007,
        machine=SimpleNamespace(bounds=SimpleNamespace(kink=1e-6)), beside=np.zeros(1),
    )  # fmt: skip
    one = np.zeros(1)
    rows = type("Rows", (), {"__len__": lambda self: 1})()
    rows.arc, rows.t0, rows.t1 = one.astype(int), one, one + 1
    monkeypatch.setattr(stretches, "_ends", lambda f, rows: one)
    monkeypatch.setattr(stretches, "_crossings", lambda f, rows, shift: [])
    monkeypatch.setattr(stretches, "_steepness", lambda *_: (one, one + third))
    found = stretches.stretches(f, rows)
    widest = min((0.001 / 16 * 9 * math.sqrt(3) / third) ** (1 / 3), 0.5)
    parts = max(math.ceil(2.0 / widest), 2)
    assert found.parts.tolist() == [parts]
    remainder = (2.0 / parts) ** 3 * third / (9 * math.sqrt(3))
    assert found.rest.tolist() == pytest.approx([remainder + 0.001 / 64])


@pytest.mark.parametrize(
    "blocks", ["G3 X97.1945 Y37.5840 Z1.992 I.0221 J.0062", "G2 X97.1945 Y37.5844 Z1.992 R.05"]
)
def test_a_short_arc_of_a_long_way_beside_its_plane_is_no_chord(blocks):
    """0.2 um of an arc, and 13 mm of Z, past a node: it became one straight line (3.3 um left)."""
    text = f"G90 G17 G21\nG0 X97.1945 Y37.5842 Z15.\n{blocks} F50\nG1 X0.\nM30\n".encode()
    filter_ = filter_of(Case(text, "fanuc-mill", "one-way"))
    verifier = Verifier(filter_)
    filter_.feed(text)
    filter_.finish()
    assert verifier.passed and verifier.corrected.deviation < 0.6 * UM, verifier.report()


@pytest.mark.parametrize(
    "blocks",
    [
        "G0 X125.6896 Y-32.9034 Z24.6|G3 X125.6875 Y-32.8888 Z-26. I-1.6662 J-.2325 F60",
        "G0 X80.4264 Y39.9666 Z-27.2|G2 X80.4261 Y39.9163 Z35. I-5.7676 J0. F60",
    ],
)
def test_along_a_steep_helix_the_map_turns_the_axes_of_its_plane_too(blocks):
    """Y goes 15 or 50 um along the arc, and the map by 20 um to and fro along 50 or 60 mm of Z: it
    was led from end to end (4.3 to 4.5 um left)."""
    text = f"G90 G17 G21|{blocks}|G1 X20.|M30|".replace("|", "\n").encode()
    filter_ = filter_of(Case(text, "linuxcnc", "two-way"))
    verifier = Verifier(filter_)
    filter_.feed(text)
    filter_.finish()
    assert verifier.passed and verifier.corrected.deviation < 1.5 * UM, verifier.report()


MM = TICKS_PER_MM
WIDE = [  # centre fitted, um; least radius, mm; inside; found, um, or None
    ((0.0, 0.0), 10.0, True, (0, 0)),
    ((0.4, -2.6), 10.0, True, (0, -3)),  # 0.4 um too narrow at its begin: the next that fits
    ((-2.6, 0.6), 10.0, True, (-3, 0)),  # at its end
    ((1.5, -2.6), 10.0, True, (0, 0)),  # by more than a step: as the nominal one lies
    ((-2.6, 1.5), 10.0, True, (0, 0)),
    ((0.4, -2.6), 9.9, True, (0, -3)),  # there is room: the next on the grid
    ((0.4, 0.4), 10.0, False, None),  # no arc inside compensation
    ((0.0, 0.0), 10.02, True, None),  # nothing near is as wide
]


def test_centres_that_leave_the_tool_room():
    """A quarter of 10 mm about (100, 200) mm, moved by (5, 3) mm, on a grid of 1 um: of the 25
    centres about the fitted one the nearest from which both ends are as far as the least
    radius."""
    about = np.array([[105.0], [203.0]])
    n = len(WIDE)
    begin, end = about + [[10.0], [0.0]] * np.ones(n), about + [[0.0], [10.0]] * np.ones(n)
    ticks = np.full(n, 10.0 * MM)
    own = SimpleNamespace(
        f=SimpleNamespace(
            arcs=SimpleNamespace(radius=ticks / MM, radius_end=ticks / MM),
            inside=np.array([inside for _, _, inside, _ in WIDE]),
        ),
        arc=np.arange(n), grid=np.full((2, n), MM // 1000), begin=begin, end=end,
        unit0=np.array([[1.0], [0.0]]) * np.ones(n),
        _least=lambda: np.array([least * MM - 0.5 for _, least, _, _ in WIDE]),
    )  # fmt: skip
    fitted = about + np.array([c for c, _, _, _ in WIDE]).T / 1000
    found = prove.Proof._as_wide(own, fitted) - about
    wanted = np.array([f or (np.nan, np.nan) for _, _, _, f in WIDE]).T / 1000
    assert found == pytest.approx(wanted, abs=1e-9, nan_ok=True)
