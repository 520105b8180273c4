"""gcomp on threads of the S-36, and of the one whose forward is never beyond reverse, judged by a
play operator on each slide. The reference knows no spindle: of a thread it follows the way."""

import re

import pytest

from tests.small_machines import write_lagging

from .lost_motion import follow
from .lost_motion_trial import gcomp
from .machine import UM, Machine
from .samples import SEED

S36 = SEED.parents[2] / "machines" / "studer-s36"
BACK = "G0 X90.\nZ202.\n"
PROGRAMS = {
    "tapers that turn X": "G0 X90. Z202.\nG0 X60.\nZ200.\nG32 X64. Z140. F1.5\n"
    f"{BACK}X59.8 Z200.\nG32 X63.8 Z140. F1.5\n",
    "a taper behind a feed": "G0 X90. Z202.\nG1 X60. Z200. F100.\nG32 X61. Z184. F2.\n",
    "a cylinder": "G0 X60. Z202.\nG0 Z200.\nG32 Z140. F1.5\n",
    "a start at an angle": "G0 X90. Z202.\nG0 X60. Z200.\nG32 X64. Z181. F3. Q180000\n",
}


def way(text):
    """A program of which every thread is a feed, without the angle at which it starts."""
    return re.sub(r" Q\d+", "", text).replace("G32", "G1")


@pytest.fixture(params=["forward beyond reverse", "lagging"])
def folder(request, tmp_path):
    return S36 if request.param != "lagging" else write_lagging(S36, tmp_path / "lagging")


def left_of(folder, tmp_path, text, *options):
    """What is left of a program."""
    source, written = tmp_path / "job.nc", tmp_path / "job_comp.nc"
    source.write_text(f"G21 G90\n{text}{BACK}M2\n")
    status, complaint = gcomp(*options, "--machine", folder, "-o", written, source)
    assert status == 0, complaint
    machine = Machine.load(folder, measured_at="stood")
    one, two = (way(each.read_text()) for each in (source, written))
    return follow(one, two, "fanuc-lathe", machine)


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_thread_begins_on_the_sides_on_which_it_goes_on(folder, tmp_path, name):
    """Lost motion was taken up along it: up to 9 um were left."""
    left = left_of(folder, tmp_path, PROGRAMS[name], "--verify")
    assert left.distances.max() < 1.5 * UM and left.rms < 0.3 * UM


def test_an_axis_that_turns_between_threads_is_over_its_play_in_half_a_millimetre(folder, tmp_path):
    """Nothing is put in between threads in step: 7 um faded over all of the pull-out."""
    left = left_of(
        folder, tmp_path, "G0 X90. Z202.\nG0 X60. Z200.\nG32 X59. Z180. F2.\nX66. Z170.\n"
    )
    assert left.weights[left.distances > 1.5 * UM].sum() <= 0.5
