"""LinuxCNC itself, headless, as the receiver of corrected programs (A21 of the streaming page).

gcomp corrects a program for `example-mill` (all 21 components); LinuxCNC runs the result in auto
mode, planner, joints and all. At every M0 its joints are read and laid against what
tests/reference, which shares nothing with gcomp, asks for: the slide positions at which the
machine's tool point lies on the nominal one. Coordinates have 0.001 mm, so rounding alone may take
0.5 um an axis.
"""

import math
import random
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from tests.linuxcnc import headless
from tests.reference.evaluate import KINDS, Judge
from tests.reference.interpreter import run
from tests.reference.machine import Machine

ROOT = Path(__file__).resolve().parents[2]
MISSING = headless.available()
pytestmark = [pytest.mark.real, pytest.mark.skipif(MISSING is not None, reason=str(MISSING))]

MACHINE = "example-mill"
OFFSETS = {"G54": {"X": 0, "Y": 0, "Z": -250}}
PARAMETERS = {5223: -250.0}  # the same, as LinuxCNC keeps it: Z of G54
TOOLS = {1: 0.0, 3: 0.0}  # number: length, mm
UM = 1e-3
NANOMETRE = 1e-6
AXES = "XYZ"


@pytest.fixture(scope="module")
def linuxcnc():
    with headless.Controller(PARAMETERS, TOOLS) as controller:
        yield controller


@pytest.fixture(scope="module")
def mill():
    return Machine.load(ROOT / "machines" / MACHINE)


def interpreted(text):
    return run(text, "linuxcnc", axes=AXES, offsets=OFFSETS)


def with_stops(text):
    """The program with an M0 behind every motion whose end is known in all axes."""
    stops = {
        b.line
        for b in interpreted(text)
        if b.kind in KINDS and None not in b.end.values() and b.length != 0
    }
    return "".join(
        f"{line}\nM0\n" if number in stops else f"{line}\n"
        for number, line in enumerate(text.splitlines(), 1)
    )


def any_motions(seed, n=60, path="G61"):
    """Rapids, feeds, arcs, a helix, increments and dwells all over the travel; ends in M2."""
    r = random.Random(seed)
    place = lambda: f"X{r.uniform(-300, 300):.3f} Y{r.uniform(-150, 150):.3f}"
    rows = [f"G21 G17 G90 G94 G40 G54 {path}", f"G0 {place()} Z5"]
    while len(rows) < n:
        kind = r.choice(["feed", "feed", "rapid", "arc", "helix", "steps", "dwell"])
        if kind == "feed":
            rows.append(f"G1 {place()} Z{r.uniform(-120, 20):.3f} F{r.choice((4000, 6000))}")
        elif kind == "rapid":
            rows.append(f"G0 {place()}")
        elif kind == "dwell":
            rows.append("G4 P0.02")
        elif kind == "steps":
            rows += ["G91", *(f"G1 {a}{r.uniform(-4, 4):.3f} F3000" for a in "XYZX"), "G90"]
        else:
            way, radius = r.choice(("G2", "G3")), round(r.uniform(5, 40), 3)
            down = f" Z{r.uniform(-60, 0):.3f}" if kind == "helix" else ""
            rows += [f"G1 X{r.uniform(-200, 200):.3f} Y{r.uniform(-100, 100):.3f} F6000"]
            x, y = (float(word[1:]) for word in rows[-1].split()[1:3])
            rows.append(f"{way} X{x + radius:.3f} Y{y + radius:.3f}{down} I{radius:.3f} J0 F5000")
    return "\n".join([*rows, "G0 Z50", "M2", ""])


def sample_program(name):
    """One of ours, in exact path mode: see the test of G64 below."""
    return (ROOT / "sample_programs" / name).read_text().replace(" G54\n", " G54 G61\n", 1)


# name: text, limit in um; an inch program has 0.0001 in, so half of 2.54 um is lost by rounding
# alone
PROGRAMS = {
    "three axes, ramps, arcs": (lambda: sample_program("pocket_mill.ngc"), 1.0),
    "inches, increments, arcs by R": (lambda: sample_program("inch_plate.ngc"), 1.4),
    "anything": (lambda: any_motions(5, n=50), 1.0),
}


def corrected(folder, text):
    """By the command, as a user has it."""
    source = folder / "job.ngc"
    source.write_text(text)
    command = [
        sys.executable,
        "-m",
        "postproc",
        "--machine",
        MACHINE,
        "--dialect",
        "linuxcnc",
        str(source),
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


def samples(text, written, machine):
    """[(nominal tool point, approach, nominal slides)] at every M0 of a program; mm.

    written: what was run for it; the approach is the direction in which that last commanded each
    slide.
    """
    judge = Judge(machine, samples_per_mm=1.0, clamp=False, take_up=0.1, near=0.1)
    run_blocks = interpreted(written)
    judge.execute(run_blocks)
    approaches = [judge.approach(block) for block in before_stops(run_blocks)]
    ends = [
        {axis: float(block.end[axis]) for axis in AXES} for block in before_stops(interpreted(text))
    ]
    assert len(ends) == len(approaches)
    return [
        (machine.nominal(end), approach, np.array([end[axis] for axis in AXES]))
        for end, approach in zip(ends, approaches)
    ]


def before_stops(blocks):
    """The last motion before every M0."""
    last, found = None, []
    for block in blocks:
        if block.kind in KINDS:
            last = block
        elif "M0" in block.codes:
            found.append(last)
    return found


def slides_for(machine, point, approach, first):
    """(3,) mm: where the slides must stand for the tool point to lie on `point`."""
    slides = first
    for _ in range(8):
        slides = slides - (machine.actual(dict(zip(AXES, slides)), approach) - point)
    assert np.abs(machine.actual(dict(zip(AXES, slides)), approach) - point).max() < NANOMETRE
    return slides


def judged(machine, expected, reached):
    """(largest miss of an axis, largest distance of the tool point from the nominal one); mm."""
    assert len(reached) == len(expected)
    axis = tool = 0.0
    for (point, approach, nominal), joints in zip(expected, reached):
        axis = max(
            axis,
            float(np.abs(np.array(joints) - slides_for(machine, point, approach, nominal)).max()),
        )
        tool = max(tool, math.dist(machine.actual(dict(zip(AXES, joints)), approach), point))
    return axis, tool


@pytest.mark.parametrize("name", PROGRAMS)
def test_A21_joints_at_the_sample_points_of_a_corrected_program_in_auto_mode(
    linuxcnc, mill, tmp_path, name
):
    make, limit = PROGRAMS[name]
    text = with_stops(make())
    written = corrected(tmp_path, text)
    expected = samples(text, written, mill)
    stops, _ = linuxcnc.run(written)
    axis, tool = judged(mill, expected, [joints for _, joints in stops])
    print(
        f"{name}: {len(stops)} points, {axis / UM:.2f} um an axis, {tool / UM:.2f} um of the tool"
        " point"
    )
    # A slide may be held within the hysteresis (1 um) of its wanted place.
    assert len(stops) > 35 and axis < (limit + 1.0) * UM
    assert tool < (limit * math.sqrt(3 if limit > 1 else 1) + math.sqrt(3)) * UM


def test_A21_without_correction_the_same_points_are_missed(linuxcnc, mill):
    """The control: LinuxCNC goes where the reference says that the nominal program goes, and there
    the tool is wrong."""
    text = with_stops(any_motions(5, n=25))
    expected = samples(text, text, mill)
    reached = [joints for _, joints in linuxcnc.run(text)[0]]
    assert (
        max(math.dist(joints, slides) for joints, (_, _, slides) in zip(reached, expected))
        < NANOMETRE
    )
    axis, tool = judged(mill, expected, reached)
    print(f"uncorrected: {axis / UM:.2f} um an axis, {tool / UM:.2f} um of the tool point")
    assert axis > 20 * UM and tool > 20 * UM


def test_A21_line_by_line_through_mdi(linuxcnc, mill):
    """Each nominal line goes into the filter alone; what comes out is given to MDI before the next
    one goes in."""
    text = with_stops(any_motions(6, n=25))
    machine = places.load(MACHINE)
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine))
    reached, joints, written = [], None, ""
    for line in text.splitlines():
        out = filter_.feed(line.encode() + b"\n").decode()
        written += out
        if line == "M0":
            reached.append(joints)
        elif line != "M2" and (commands := out.splitlines()):
            joints = linuxcnc.mdi(commands)[-1]
    axis, tool = judged(mill, samples(text, written, mill), reached)
    print(
        f"MDI: {len(reached)} points, {axis / UM:.2f} um an axis, {tool / UM:.2f} um of the tool"
        " point"
    )
    assert len(reached) > 15 and axis < 1.0 * UM and tool < 1.0 * UM


def test_A21_four_hundred_lines_without_a_stop(linuxcnc, mill, tmp_path):
    """Read ahead and blended as in a shop; where it ends is judged, and that the whole of it was
    run."""
    r = random.Random(7)
    rows = ["G21 G17 G90 G94 G40 G54 G64 P0.01", "G0 X0 Y0 Z5"]
    rows += [
        f"G1 X{100 + r.uniform(0, 2):.3f} Y{50 + r.uniform(0, 2):.3f} Z{r.uniform(-1, 0):.3f} F9000"
        for _ in range(400)
    ]
    text = "\n".join([*rows, "G1 X-123.456 Y77.7 Z-20.5", "M0", "M2", ""])
    written = corrected(tmp_path, text)
    stops, end = linuxcnc.run(written)
    [(_, joints)] = stops
    axis, tool = judged(mill, samples(text, written, mill), [joints])
    print(f"without a stop: {axis / UM:.2f} um an axis, {tool / UM:.2f} um of the tool point")
    assert axis < 1.0 * UM and tool < 1.0 * UM and math.dist(joints, end) < NANOMETRE


@pytest.mark.parametrize("path, beside", [("G61", 0.0), ("G64", 3.0), ("G64 P0.01", 0.0)])
def test_A21_why_exact_path(linuxcnc, path, beside):
    """LinuxCNC's own habit: blending a line of 6 um, as a take-up is, into a corner ends half of it
    beside the programmed point.

    Seen: half of a short line, at most a quarter of acceleration times servo period squared: 5 um
    at the 20 m/s² of this machine, 1 um at 4 m/s². So these programs are run in exact path mode; a
    slow machine would hide it. It blends with what it has read by then: on a busy system the short
    line can be done before the next is there, and is not blended. So it is run until it was.
    """
    text = f"G21 G90 G94 G54 {path}\nG1 X0 Y0 Z0 F6000\nM0\nG1 X0.006 F600\nX5 Y1\nM0\nM2\n"
    seen = []
    while beside not in seen and len(seen) < 8:
        [(_, before), (_, joints)], _ = linuxcnc.run(text)
        assert math.dist(before, (0, 0, -250)) < NANOMETRE
        off = joints[0] - 5
        assert math.dist(joints, (5 + off, 1, -250)) < 0.1 * UM
        assert min(abs(off), abs(off - beside * UM)) < 0.1 * UM
        seen.append(beside if abs(off - beside * UM) < 0.1 * UM else 0.0)
    assert beside in seen


def test_A21_a_refusal_is_heard_and_the_next_program_runs(linuxcnc):
    """What the other tests call reached is no silence of the host."""
    with pytest.raises(headless.Refused, match="exceed"):
        linuxcnc.run("G21 G90 G54 G1 X5000 F6000\nM0\nM2\n")
    [(_, joints)], _ = linuxcnc.run("G21 G90 G54 G1 X5 Y6 Z7 F6000\nM0\nM2\n")
    assert math.dist(joints, (5, 6, -243)) < NANOMETRE
