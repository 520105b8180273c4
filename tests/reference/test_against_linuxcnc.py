"""The reference interpreter against LinuxCNC's own: ends, centres, turns and dwells of what both read."""

import math

import pytest

from .interpreter import NotUnderstood, run

oracle = pytest.importorskip("tests.linuxcnc.oracle")
pytestmark = pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))

CLOSE = 1e-9  # mm; LinuxCNC goes through inches
LETTERS = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
# Rotary axes, G59.1, and G4 beside axis words are not spoken by the reference.
NOT_SPOKEN = {"rotary_axes", "work_offsets_extended", "dwell_and_axis_words"}


def settings_of(keywords):
    parameters = keywords.get("parameters") or {}
    offsets = {
        f"G5{4 + k}": {axis: parameters.get(5221 + 20 * k + i, 0.0) for i, axis in enumerate("XYZ")} for k in range(6)
    }
    return dict(
        axes="XYZ", offsets=offsets, block_delete=keywords.get("block_delete", False), start=dict.fromkeys("XYZ", 0.0)
    ), parameters


@pytest.fixture(scope="module")
def told():
    programs = sorted(oracle.PROGRAMS.glob("*.ngc"))
    loaded = [oracle.load(path) for path in programs]
    return {
        path.stem: (*entry, answer) for path, entry, answer in zip(programs, loaded, oracle.motions_of_many(loaded))
    }


@pytest.mark.parametrize("name", sorted(path.stem for path in oracle.PROGRAMS.glob("*.ngc")))
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
            assert math.copysign(math.ceil(abs(block.sweep) / (2 * math.pi) - 1e-9), block.sweep) == motion.turns
