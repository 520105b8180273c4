"""The reference interpreter against LinuxCNC's own: ends, centres, turns and dwells of what both
read."""

import math

import pytest

from .interpreter import NotUnderstood, run

oracle = pytest.importorskip("tests.linuxcnc.oracle")
pytestmark = pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))

CLOSE = 1e-9  # mm; LinuxCNC goes through inches
LETTERS = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
# Rotary axes, G59.1, and G4 beside axis words are not spoken by the reference.
# Shifts set by the program, cycles and languages are not spoken either: other tests look at those.
OTHERS = tuple(
    "oword_ turn_ sync_ cycle_ rotate_ cutter_ spline_ probe_ unknown_ g10_ g52_ g92_ tool_ rotary_"
    " reference_ spindle_words digital_output".split()
)
# Rotary words, M and T words, blank lines and tolerances that it does not know.
OTHER_FORMS = set(
    """
    machine_coordinates_g52_g92_tool machine_coordinates_rotary arc_radii_differ_large
    arc_with_rotary_words dwell_forms feed_inverse_time_rapid feed_override_words
    modes_many_lines_of_words modes_work_offset_partial text_case text_g_numbers
    text_percent_blank_lines
    """.split()
)
SPOKEN = sorted(
    path.stem
    for path in oracle.PROGRAMS.glob("*.ngc")
    if not path.stem.startswith(OTHERS) and path.stem not in OTHER_FORMS
)
NOT_SPOKEN = {"rotary_axes", "work_offsets_extended", "dwell_and_axis_words"}


def settings_of(keywords):
    parameters = keywords.get("parameters") or {}
    offsets = {
        f"G5{4 + k}": {axis: parameters.get(5221 + 20 * k + i, 0.0) for i, axis in enumerate("XYZ")}
        for k in range(6)
    }
    return (
        dict(
            axes="XYZ",
            offsets=offsets,
            block_delete=keywords.get("block_delete", False),
            start=dict.fromkeys("XYZ", 0.0),
        ),
        parameters,
    )


@pytest.fixture(scope="module")
def told():
    programs = [oracle.PROGRAMS / f"{name}.ngc" for name in SPOKEN]
    loaded = [oracle.load(path) for path in programs]
    return {
        path.stem: (*entry, answer)
        for path, entry, answer in zip(programs, loaded, oracle.motions_of_many(loaded))
    }


@pytest.mark.parametrize("name", SPOKEN)
def test_the_same_motions(told, name):
    text, keywords, theirs = told[name]
    settings, parameters = settings_of(keywords)
    if name in NOT_SPOKEN:
        with pytest.raises(NotUnderstood):
            run(text, "linuxcnc", **settings)
        return
    if "G28" in text.upper() or "G30" in text.upper() or 5220 in parameters:
        pytest.skip("where home is, and another offset at the start, the reference is not told")
    ours = [
        block
        for block in run(text, "linuxcnc", **settings)
        if block.kind == "dwell" or block.kind != "none" and block.length > 0
    ]
    theirs = [m for m in theirs if m.kind in ("arc", "dwell") or math.dist(m.start, m.end) > 0]
    # LinuxCNC counts lines from the first %.
    ahead = 2 if name == "percent_after_blank_lines" else 0
    assert [block.line for block in ours] == [motion.line + ahead for motion in theirs]
    for block, motion in zip(ours, theirs):
        assert block.kind in (motion.kind, "machine")
        if block.kind == "dwell":
            assert block.dwell == pytest.approx(motion.seconds)
            continue
        assert math.dist([block.end[axis] for axis in "XYZ"], motion.end[:3]) < CLOSE
        assert math.dist([block.start[axis] for axis in "XYZ"], motion.start[:3]) < CLOSE
        if block.kind == "arc":
            assert LETTERS[block.plane] == motion.plane
            assert math.dist(block.centre, motion.centre) < 1e-6
            assert (
                math.copysign(math.ceil(abs(block.sweep) / (2 * math.pi) - 1e-9), block.sweep)
                == motion.turns
            )
