"""The compiled kernel gives the bits that numpy gives: on tables, on random arcs of all kinds, and
so the same bytes. It is built here, in a folder of its own."""

from __future__ import annotations

import ctypes
import math
import os
import random
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from postproc import kernel
from postproc.compensate import Options, compiled, fit
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.records import names, replace
from tests.small_machines import write_mill

COMPILER = shlex.split(os.environ.get("CC", "cc"))[0]
needs_compiler = pytest.mark.skipif(
    not shutil.which(COMPILER), reason=f"there is no C compiler {COMPILER} here"
)
ZERO = {"G54": {"X": 0.0, "Y": 0.0, "Z": 0.0}}
SIDES = pytest.mark.parametrize("two_way", [False, True])


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    target = tmp_path_factory.mktemp("kernel") / "kernel-built.so"
    assert kernel.build(str(target)) == ""
    return target


@pytest.fixture(scope="module")
def library(built) -> ctypes.CDLL:
    return ctypes.CDLL(str(built))


def use(monkeypatch, library: ctypes.CDLL | None) -> None:
    monkeypatch.setattr(kernel, "library", lambda: library)


# ---- tables --------------------------------------------------------------------------------------

NODES = {
    "even": np.linspace(-5.0, 45.0, 11),
    "a shorter last interval": np.append(np.arange(-5.0, 41.0, 5.0), 43.0),
    "thirds": np.append(np.arange(-2, 38) / 3.0, 12.5),
    "one interval": np.array([-5.0, 45.0]),
    "uneven": np.array([-5.0, 1.0, 3.0, 20.0, 45.0]),
}


@needs_compiler
@pytest.mark.parametrize("nodes", NODES.values(), ids=NODES)
@pytest.mark.parametrize("stride", [1, 3])
def test_a_table_has_the_same_bits(monkeypatch, library, nodes, stride):
    """At random places, at nodes and beside them, and beyond the ends; of tables and of places that
    do not lie in one piece."""
    rng = np.random.default_rng(len(nodes))
    near = np.concatenate([nodes, np.nextafter(nodes, 99.0), np.nextafter(nodes, -99.0)])
    places = np.concatenate([rng.uniform(-9.0, 49.0, 3 * 997 - 2 * len(near)), near, near])
    position, approach = places[::stride], rng.choice([-1.0, 0.0, 1.0], len(places[::stride]))
    forward, reverse = rng.normal(size=(2, len(nodes), 6))
    forward[:, 2] = reverse[:, 2] = 0.0
    table = AxisTable("X", np.repeat(nodes, 2)[::2], forward.T, reverse.T)
    seen = []
    counted = type("Counted", (), {"look": lambda self, *a: (seen.append(1), library.look(*a))})()
    for along in (None, 0, 1, 2):
        use(monkeypatch, None)
        plain = table.evaluate(position, approach, along)
        use(monkeypatch, counted)
        for one, other in zip(plain, table.evaluate(position, approach, along), strict=True):
            assert (one is None and other is None) or one.tobytes() == other.tobytes()
    assert bool(seen) == (nodes is not NODES["uneven"])


@needs_compiler
@pytest.mark.parametrize("kind", [np.int64, np.int32, np.float32])
def test_places_of_any_kind_of_number_are_looked_up(monkeypatch, library, kind):
    rng = np.random.default_rng(1)
    places = rng.uniform(-9, 49, 200).astype(kind)
    table = AxisTable("X", NODES["even"], *rng.normal(size=(2, 6, len(NODES["even"]))))
    use(monkeypatch, None)
    plain = table.evaluate(places, np.ones(200))
    use(monkeypatch, library)
    for one, other in zip(plain, table.evaluate(places, np.ones(200)), strict=True):
        assert one.tobytes() == other.tobytes()


# ---- arcs ----------------------------------------------------------------------------------------


class Lines:
    """Random arcs on the mill of small_machines.py, in one plane."""

    def __init__(self, seed: int, plane: str = "XY"):
        self.rng, self.axes = random.Random(seed), plane
        self.third = (set("XYZ") - set(plane)).pop()
        code = {"XY": "G17", "ZX": "G18", "YZ": "G19"}[plane]
        self.words = dict(zip("XYZ", "IJK", strict=True))
        self.at = {"X": 100.0, "Y": 0.0, "Z": 0.0}
        self.text = [f"G21 G90 {code} G54", "G0 X100 Y0 Z0", "F1000"]

    def arc(self, radius: float, sweep: float, rise: float = 0.0, by_radius: bool = False) -> bool:
        """Whether an arc of mm and rad stayed on the machine."""
        first, second = self.axes
        begin, code = self.rng.uniform(0, math.tau), self.rng.choice([2, 3])
        centre = {
            first: self.at[first] - radius * math.cos(begin),
            second: self.at[second] - radius * math.sin(begin),
        }
        end = begin + (sweep if code == 3 else -sweep)
        to = {
            first: round(centre[first] + radius * math.cos(end), 3),
            second: round(centre[second] + radius * math.sin(end), 3),
            self.third: round(self.at[self.third] + rise, 3),
        }
        if not all(low < to[x] < high for x, low, high in BOX) or not all(
            low < centre[x] - radius and centre[x] + radius < high
            for x, low, high in BOX
            if x in centre and radius < 60
        ):
            return False
        words = " ".join(f"{x}{to[x]:.3f}" for x in sorted(to) if rise or x != self.third)
        middle = [f"{self.words[x]}{centre[x] - self.at[x]:.4f}" for x in sorted(centre)]
        if by_radius:
            middle = [f"R{radius if sweep < math.pi else -radius:.3f}"]
        self.text.append(f"G{code} {words} {' '.join(middle)}")
        self.at |= to
        return True

    def many(self, count: int, *arguments) -> Lines:
        """`count` arcs whose radius and sweep lie between pairs of numbers."""
        made = 0
        while made < count:
            made += self.arc(*(self.rng.uniform(*a) if isinstance(a, tuple) else a
                               for a in arguments))  # fmt: skip
        return self

    def __str__(self) -> str:
        return "\n".join([*self.text, "M2", ""])


BOX = ("X", 1.0, 199.0), ("Y", -59.0, 59.0), ("Z", -39.0, 39.0)
KINDS = {
    "arcs": lambda seed: Lines(seed).many(60, (1.0, 20.0), (0.2, 6.0)),
    "small": lambda seed: Lines(seed).many(60, (0.002, 0.5), (0.05, 6.1)),
    "smallest": lambda seed: Lines(seed).many(60, (0.0018, 0.0026), (3.0, 6.1)),
    "tiny": lambda seed: Lines(seed).many(60, (0.005, 0.03), (0.3, 6.1)),
    "wide": lambda seed: Lines(seed).many(40, (20.0, 55.0), (0.3, 3.0)),
    "flat": lambda seed: Lines(seed).many(40, (100.0, 9000.0), (0.00002, 0.01)),
    "nearly straight": lambda seed: Lines(seed).many(40, (5e5, 9e5), (2e-9, 9e-9)),
    "nearly a turn": lambda seed: Lines(seed).many(20, (1.0, 20.0), (6.15, 6.2831)),
    "turns": lambda seed: Lines(seed).many(20, (1.0, 20.0), math.tau),
    "helices": lambda seed: Lines(seed).many(40, (1.0, 20.0), (0.2, 6.0), (-1.0, 1.0)),
    "by R": lambda seed: Lines(seed).many(40, (1.0, 20.0), (0.2, 6.0), 0.0, True),
    "other planes": lambda seed: Lines(seed, "ZX").many(30, (1.0, 20.0), (0.2, 6.0)),
    "the third plane": lambda seed: Lines(seed, "YZ").many(30, (1.0, 20.0), (0.2, 6.0)),
}


def settled(monkeypatch, library, folder: Path, text: str, dialect: str = "linuxcnc", **options):
    """The bytes that are made of a program, what was fitted, in order, and how many rows the
    kernel cut and left."""
    use(monkeypatch, library)
    found, rows, real, tried = [], [0, 0], fit.settle, compiled.settle

    def seen(f, these):
        result = real(f, these)
        found.append(result.pick(np.lexsort((result.t0, result.stroke))))
        return result

    def counted(f, these, samples):
        pieces, left = tried(f, these, samples)
        rows[0] += len(these) - len(left)
        rows[1] += len(left)
        return pieces, left

    with monkeypatch.context() as m:
        m.setattr(fit, "settle", seen)
        m.setattr(compiled, "settle", counted)
        machine = read_machine(folder)
        filter_ = Filter(
            machine, dialects.load(dialect), setup_of(machine, ZERO), Options(**options)
        )
        out = filter_.feed(text.encode()) + filter_.finish()
    return out, found, rows


def same(monkeypatch, library, folder: Path, text: str, *dialect: str, **options) -> list[int]:
    """How many rows the kernel cut and left; all that is fitted has the same bits."""
    plain, rows, none = settled(monkeypatch, None, folder, text, *dialect, **options)
    out, others, count = settled(monkeypatch, library, folder, text, *dialect, **options)
    assert none[0] == 0
    assert len(rows) == len(others) > 0
    for one, other in zip(rows, others, strict=True):
        for name in names(type(one)):
            assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name
    assert out == plain
    return count


def rough(folder: Path, two_way: bool) -> Path:
    """That mill with a node every quarter of a millimetre, the tables bent at each of them."""
    write_mill(folder, two_way)
    for path in folder.glob("?.csv"):
        head, *lines = path.read_text().split()
        rows = np.array([[float(v) for v in line.split(",")] for line in lines])
        nodes = np.arange(rows[0, 0], rows[-1, 0] + 0.1, 0.25)
        rng = np.random.default_rng(ord(path.stem))
        columns = [np.interp(nodes, rows[:, 0], column) for column in rows.T[1:]]
        noise = rng.uniform(-0.3, 0.3, len(nodes))
        values = np.stack([nodes, *(column + noise for column in columns)], axis=1)
        text = [head, *(",".join(f"{v:.4f}" for v in row) for row in values)]
        path.write_text("\n".join(text) + "\n")
    return folder


@needs_compiler
@SIDES
@pytest.mark.parametrize("tolerance", [0.0003, 0.001, 0.005])
def test_arcs_of_many_samples_and_many_pieces_are_cut_the_same(
    tmp_path, monkeypatch, library, two_way, tolerance
):
    """More than the kernel holds of either, and intervals of two samples that are too long."""
    folder = rough(tmp_path / "mill", two_way)
    # of what it leaves altogether two arcs take every branch that twelve do, in a tenth of the time
    arcs = 12 if two_way or tolerance > 0.0003 else 2
    for seed, radii in (1, (0.3, 45.0)), (2, (20.0, 50.0)):
        text = str(Lines(seed).many(arcs, radii, (0.2, 6.0)))
        done, left = same(monkeypatch, library, folder, text, tolerance=tolerance)
        assert (done or tolerance < 0.001) and (left or seed == 2)


@needs_compiler
@pytest.mark.parametrize("kind", ["arcs", "wide"])
def test_arcs_in_coarse_increments_are_cut_the_same(tmp_path, monkeypatch, library, kind):
    """Of 0.01 mm, of a control that lets both radii differ by 0.005 mm: rounding moves the centre
    by more."""
    folder = write_mill(tmp_path / "mill", False)
    toml = folder / "machine.toml"
    toml.write_text(toml.read_text().replace("least_increment = 0.0001", "least_increment = 0.01"))
    for seed in range(2):
        text = str(KINDS[kind](seed)).replace("M2", "M30")
        done, _ = same(monkeypatch, library, folder, text, "grbl", tolerance=0.02)
        assert done


STEPS = "".join(
    f"G3 X{x + 10} Y{y + 10} I0 J10\nG2 X{x + 20} Y{y + 20} I10 J0\n"
    for x, y in zip(range(20, 120, 20), range(-50, 50, 20), strict=True)
)
INSIDE = f"""G21 G90 G17 G54
T1 M6
G0 X5 Y-50 Z0
F500
G41 D1 G1 X20 Y-50
{STEPS}G1 X130
G40 G1 X140
G2 X150 Y40 I0 J-10
G3 X160 Y30 I10 J0
M2
"""


@needs_compiler
@SIDES
def test_arcs_inside_cutter_radius_compensation_are_left(tmp_path, monkeypatch, library, two_way):
    folder = write_mill(tmp_path / "mill", two_way)
    done, left = same(monkeypatch, library, folder, INSIDE)
    assert done >= 2 and left >= 2


@needs_compiler
@SIDES
@pytest.mark.parametrize("tolerance", [0.0002, 0.001, 0.1])
@pytest.mark.parametrize("kind", KINDS)
def test_arcs_are_cut_the_same(tmp_path, monkeypatch, library, two_way, kind, tolerance):
    folder = write_mill(tmp_path / "mill", two_way)
    for seed in range(2):
        done, left = same(monkeypatch, library, folder, str(KINDS[kind](seed)), tolerance=tolerance)
        if kind in ("turns", "helices", "by R"):
            assert not done or (two_way and kind == "turns")  # reversals cut a turn in four
        if kind in ("arcs", "wide", "other planes", "the third plane"):
            assert done > 3 * left


@needs_compiler
@SIDES
def test_arcs_of_two_planes_and_of_more_than_a_turn_by_turns_are_cut_the_same(
    tmp_path, monkeypatch, library, two_way
):
    """Samples of a plane are laid together, of rows that do not stand side by side; those of arcs
    that are looked at densely, by numpy."""
    folder = write_mill(tmp_path / "mill", two_way)
    text = ["G21 G90 G54 F1000"]
    for seed in range(6):
        for plane, code in ("XY", "G17"), ("ZX", "G18"), ("YZ", "G19"):
            text += [f"{code} G0 X100 Y0 Z0", "G2 I5 J0 P2" if plane == "XY" else "G4 P1"]
            text += Lines(seed, plane).many(4, (1.0, 20.0), (0.2, 6.0)).text[3:]
    done, left = same(monkeypatch, library, folder, "\n".join([*text, "M2", ""]), tolerance=0.001)
    assert done > 3 * left


@needs_compiler
def test_where_reversals_fade_arcs_are_looked_at_by_numpy(tmp_path, monkeypatch, library):
    folder = write_mill(tmp_path / "mill", True)
    text = str(KINDS["arcs"](1))
    done, left = same(monkeypatch, library, folder, text, tolerance=0.001, reversal="off")
    assert left and not done


@needs_compiler
def test_a_computer_that_numbers_by_32_bits_cuts_them_the_same(tmp_path, monkeypatch, library):
    folder = write_mill(tmp_path / "mill", False)
    text, tried = str(KINDS["arcs"](1)), compiled.settle
    plain = settled(monkeypatch, None, folder, text)[0]

    def narrow(f, rows, samples):
        numbers = {name: getattr(samples, name).astype(np.int32) for name in ("begin", "last")}
        return tried(f, rows, replace(samples, **numbers))

    monkeypatch.setattr(compiled, "settle", narrow)
    out, _, (done, _) = settled(monkeypatch, library, folder, text)
    assert done and out == plain
