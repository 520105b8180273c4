"""The oracle itself, against values worked out by hand: does it translate LinuxCNC's calls
correctly?

What LinuxCNC says is not judged here; that its 4-decimal printout (`rs274 -g`) agrees was checked
once, README.md.
"""

import re

import pytest

from .oracle import HERE, Motion, ProgramError, available, load, motions, motions_of_many

pytestmark = pytest.mark.skipif(available() is not None, reason=str(available()))

ROUNDING = 1e-9  # mm; the oracle's numbers have passed through inches


def near(values):
    return pytest.approx(values, abs=ROUNDING)


def ends(text, **keywords):
    return [motion.end[:3] for motion in motions(text, **keywords)]


def test_a_feed_in_inches_is_reported_in_millimetres():
    [rapid, feed] = motions("G20 G0 X1 Y2\nG1 Z-.5 A30 F10\nM2\n")
    assert (rapid.line, rapid.kind, feed.line, feed.kind) == (1, "rapid", 2, "feed")
    assert rapid.start == near((0, 0, 0, 0, 0, 0)) and rapid.end == feed.start
    assert feed.end == near((25.4, 50.8, -12.7, 30, 0, 0))


def test_lines_are_counted_in_the_source_whatever_n_says():
    assert [motion.line for motion in motions("%\n\n(c)\nN90 G0 X1\n\r\nN7 Y2\n%\n")] == [4, 6]


def test_an_arc_in_zx_names_z_first():
    """From X10 Z0 a quarter turn clockwise about X10 Z-10, seen from +Y: to X0 Z-10 is the ccw
    three quarters."""
    [_, arc] = motions("G18 G0 X10 Z0\nG3 X0 Z-10 K-10 Y3 P2 F100\nM2\n")
    assert (arc.kind, arc.plane, arc.turns) == ("arc", "ZX", 2)
    assert arc.centre == near((-10, 10)) and arc.end[:3] == near((0, 3, -10))


def test_diameters_halve_x_but_not_i():
    [_, arc] = motions("G7 G18 G0 X20 Z0\nG2 X40 Z-10 I10 F100\nM2\n")
    assert (
        arc.start[:3] == near((10, 0, 0))
        and arc.end[:3] == near((20, 0, -10))
        and arc.centre == near((0, 20))
    )


def test_work_offsets_are_added_and_move_nothing_by_themselves():
    offsets = {5221: 1.0, 5222: 2.0, 5241: 100.0}
    assert ends("G0 X1\nG55 G91 X1\nG90 X0\nM2\n", parameters=offsets) == [
        near((2, 0, 0)),
        near((3, 0, 0)),
        near((100, 0, 0)),
    ]


def test_the_machine_starts_at_machine_zero():
    [motion] = motions("G0 X1\nM2\n", parameters={5221: 100.0, 5222: 200.0})
    assert motion.start[:3] == near((0, 0, 0)) and motion.end[:3] == near((101, 0, 0))


def test_an_arc_centre_is_in_machine_coordinates_too():
    [_, arc] = motions("G0 X0 Y0\nG2 X10 I5 F100\nM2\n", parameters={5221: 50.0, 5222: -7.0})
    assert arc.centre == near((55, -7)) and arc.end[:3] == near((60, -7, 0))


def test_machine_coordinates_ignore_every_offset():
    assert ends("G92 X3\nG53 G0 X4\nG0 X0\nM2\n", parameters={5221: 10.0}) == [
        near((4, 0, 0)),
        near((-3, 0, 0)),
    ]


def test_g92_shifts_what_follows():
    assert ends("G0 X10\nG92 X0\nX1\nG92.1\nX1\nM2\n") == [
        near((10, 0, 0)),
        near((11, 0, 0)),
        near((1, 0, 0)),
    ]


def test_rotation_turns_about_the_work_zero():
    [line, arc] = motions("G10 L2 P1 X10 R90\nG0 X2 Y1\nG3 X2 Y1 I-1 F10\nM2\n")
    assert line.end[:3] == near((9, 2, 0)) and arc.centre == near((9, 1))


def test_tool_length_is_added():
    assert ends("T1 M6\nG43 H1\nG0 Z0\nG49\nZ0\nM2\n", tools={1: {"Z": 10.0, "D": 6.0}}) == [
        near((0, 0, 10)),
        near((0, 0, 0)),
    ]


def test_references_are_machine_coordinates():
    stored = {5161: 1.0, 5162: 2.0, 5163: 3.0, 5183: -3.0, 5221: 100.0}
    assert ends("G0 X1 Y1 Z1\nG28 Z5\nG30 Z6\nG28\nM2\n", parameters=stored) == [
        near((101, 1, 1)),
        near((101, 1, 5)),
        near((101, 1, 3)),
        near((101, 1, 6)),
        near((101, 1, -3)),
        near((101, 1, -3)),
        near((1, 2, 3)),
    ]


def test_a_dwell_stays_where_it_is():
    [_, dwell] = motions("G0 X5\nG20 G4 P1.5\nM2\n")
    assert dwell == Motion(2, "dwell", dwell.start, dwell.start, seconds=1.5) and dwell.end[
        0
    ] == near(5)


def test_a_probe_goes_to_its_end():
    [probe, _] = motions("G92 Z5\nG38.2 Z2 F100\nG0 X#5063\nM2\n")
    assert (probe.kind, probe.line) == ("probe", 2) and probe.end[:3] == near((0, 0, -3))


def test_a_rigid_tap_comes_back():
    """To where the machine stood, whatever zero has been moved since."""
    made = motions("S100 M3\nG0 X5 A3\nG92 X0 A1\nG33.1 X3 Z-5 K1\nG0 Y1\nM2\n")
    assert [(motion.line, motion.kind) for motion in made] == [
        (2, "rapid"),
        (4, "feed"),
        (4, "feed"),
        (5, "rapid"),
    ]
    assert [motion.end[:4] for motion in made] == [
        near((5, 0, 0, 3)),
        near((8, 0, -5, 3)),
        near((5, 0, 0, 3)),
        near((5, 1, 0, 3)),
    ]


def test_what_a_turning_cycle_does_has_the_line_of_its_word():
    made = motions("O1 sub\nG0 X10 Z0\nG1 Z-10\nO1 endsub\nG18 G0 X25 Z5\nG70 Q1 F100\nM2\n")
    assert [motion.line for motion in made if motion.kind == "feed"] == [6]
    assert {motion.line for motion in made} == {5, 6}


def test_a_tilted_arc_is_not_reported():
    with pytest.raises(ProgramError, match="not covered") as caught:
        motions("G10 L2 P1 R90\nG18 G0 X10\nG2 X10 Z10 K5 F100\nG0 X1\nM2\n")
    assert caught.value.line == 3 and len(caught.value.before) == 1


def test_a_program_without_end_is_stopped():
    with pytest.raises(ProgramError, match="died"):
        motions("O1 while [1]\nG0 X1\nO1 endwhile\nM2\n")


def test_the_block_delete_switch():
    assert len(motions("G0 X1\n/X2\nM2\n")) == 2
    assert len(motions("G0 X1\n/X2\nM2\n", block_delete=True)) == 1


def test_an_error_has_its_line_and_what_was_done_before():
    with pytest.raises(ProgramError) as caught:
        motions("G0 X1\n\nG0 X1 X2\nM2\n")
    assert (
        caught.value.line == 3
        and "Multiple x words" in str(caught.value)
        and len(caught.value.before) == 1
    )


def test_a_feed_move_needs_a_feed():
    with pytest.raises(ProgramError, match="zero feed rate"):
        motions("G1 X1\nM2\n")


def test_programs_of_a_batch_do_not_touch_each_other():
    modes = (
        "G20 G91 G18 G7 G90.1 G55 G92 X5\nT1 M6\nG43\nG1 F1\nM2\n",
        dict(parameters={5241: 7.0}, tools={1: {"Z": 3.0}}),
    )
    plain = ("G0 X1 Z2\nM2\n", {})
    [_, first, broken, second] = motions_of_many([modes, plain, ("G0 X\nM2\n", {}), plain])
    assert isinstance(broken, ProgramError)
    assert first == second == motions(plain[0])


def test_every_program_is_accepted_and_its_motions_join():
    paths = sorted(HERE.glob("programs*/*.ngc"))
    results = motions_of_many([load(path) for path in paths])
    assert {
        path.stem: str(result)
        for path, result in zip(paths, results)
        if isinstance(result, ProgramError)
    } == {}
    for path, made in zip(paths, results):
        assert made, f"{path.stem} makes no motion"
        assert all(before.end == after.start for before, after in zip(made, made[1:])), path.stem


def test_every_refused_program_is_refused_at_the_line_it_names():
    paths = sorted(HERE.glob("refused*/*.ngc"))
    for path, result in zip(paths, motions_of_many([load(path) for path in paths])):
        assert isinstance(result, ProgramError), f"{path.stem} is accepted"
        assert result.line == int(re.search(r"line (\d+)", path.read_text())[1]), (
            f"{path.stem}: {result}"
        )
