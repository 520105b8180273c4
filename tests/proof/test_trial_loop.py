"""The loop and the baselines: laws by hand, and the tool's correction on the generator's own lost
motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from proof import baselines, loop
from proof.generator import cases, files, physics
from proof.generator.cases import Hidden
from proof.generator.streams import stream


@pytest.fixture(scope="module")
def drawn():
    """A two-axis machine with its map, nothing hidden."""
    for number in range(20):
        found = cases.draw("loop", "null", number)
        if found.scene.machine.form != "mill" and found.scene.machine.axes["X"].least < 5e-4:
            return found
    raise AssertionError("no such machine in twenty")


@pytest.fixture(scope="module")
def folder(drawn, tmp_path_factory):
    place = tmp_path_factory.mktemp("machine")
    for name, text in files.machine_files(drawn.scene.machine).items():
        path = place / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return place / "machine"


def test_a_slide_with_dead_travel_rests_until_its_command_has_taken_it_up(drawn):
    """A gap of 10 um: behind by 5 going up; back by 4 um of the command the slide rests, 1 um
    behind; a mm back it is 5 um off to the other side. Beside the true geometry."""
    effect = physics.names()["backlash"](drawn.scene, "X", stream("loop"))
    wrong = replace(drawn, hidden=[Hidden(effect, 10.0, [])])
    axis = drawn.scene.machine.axes["X"]
    points = np.tile([axis.share(0.4), 0.0, drawn.scene.machine.axes["Z"].share(0.4)], (4, 1))
    points[:, 0] += [0.0, 1.0, 0.996, 0.0]
    side = np.ones((4, 3))
    more = loop.deviation(wrong, points, side) - drawn.scene.machine.deviation(points, side)
    assert more == pytest.approx(np.array([[-5.0, 0, 0], [-5.0, 0, 0], [-1.0, 0, 0], [5.0, 0, 0]]))


def test_a_program_on_a_machine_without_errors_has_none(drawn, monkeypatch):
    text, nominal = loop.program(drawn.scene.machine)
    monkeypatch.setattr(loop, "deviation", lambda d, points, direction: np.zeros_like(points))
    assert loop.path_error(drawn, text, nominal) < 0.06  # words have 0.1 um
    monkeypatch.setattr(loop, "deviation", lambda d, points, direction: np.full_like(points, 7.0))
    assert loop.path_error(drawn, text, nominal) < 0.06  # the same everywhere: the zero of the part


def test_a_line_that_leans_is_seen_across_it(drawn, monkeypatch):
    """1 um of Z for every mm of X: at the ends of X it is off by what X is off its mean."""
    text, nominal = loop.program(drawn.scene.machine)

    def lean(d, points, direction):
        return np.c_[np.zeros((len(points), 2)), points[:, 0]]

    monkeypatch.setattr(loop, "deviation", lean)
    ends = nominal[loop.SETTLING :, 0]
    assert loop.path_error(drawn, text, nominal) == pytest.approx(
        np.abs(ends - ends.mean()).max(), rel=1e-3
    )


def test_the_true_machine_told_to_the_tool_closes_the_loop(drawn, folder, tmp_path):
    """Backlash of 9 um: the map alone leaves it, the machine that knows it does not, with nothing
    left but the map's error."""
    effect = physics.names()["backlash"](drawn.scene, "X", stream("loop"))
    wrong = replace(drawn, hidden=[Hidden(effect, 9.0, [])])
    text, nominal = loop.program(drawn.scene.machine)
    first, said = loop.corrected(text, folder)
    assert first, said
    known = tmp_path / "known"
    known.mkdir()
    for path in folder.iterdir():
        known.joinpath(path.name).write_bytes(path.read_bytes())
    with (known / "machine.toml").open("a") as file:
        file.write('\n[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 9.0\nsource = "told"\n')
    second, said = loop.corrected(text, known)
    assert second, said
    limit = loop.path_error(drawn, first, nominal)
    geometry, diagnosed = (
        loop.path_error(wrong, first, nominal),
        loop.path_error(wrong, second, nominal),
    )
    assert geometry > 5.0 and diagnosed < limit + 1.0 and diagnosed < 0.6 * geometry


def test_the_loop_is_closed_where_places_decide_and_something_shows():
    one = {"effect": "backlash", "visible": True}
    assert loop.wanted([one]) and not loop.wanted([])
    assert not loop.wanted([{"effect": "screw_heat", "visible": True}]) and not loop.wanted(
        [one | {"visible": False}]
    )


# -- baselines -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def backlash(tmp_path_factory):
    """A case whose one effect is a large backlash that nothing else explains: the 65th of its
    seed."""
    place = tmp_path_factory.mktemp("case")
    case = cases.make("baseline", "single", 64)
    (hidden,) = case.truth
    assert hidden["effect"] == "backlash" and hidden["peak_um"] > 5 and not hidden["twins"]
    for name, text in case.files.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(text)
    return place, f"backlash:{hidden['axis']}"


def test_every_baseline_finds_what_it_is_made_for(backlash):
    place, name = backlash
    problem = baselines.problem(place)
    assert problem.train.any() and not problem.train.all()
    nothing = baselines.nothing(problem).after
    assert baselines.always_backlash(problem).names == [name]
    assert baselines.always_backlash(problem).after < nothing
    assert baselines.polynomial(problem).after < nothing
    assert (
        baselines.gaussian_process(problem).after < nothing
        and not baselines.gaussian_process(problem).names
    )
    assert baselines.stlsq(problem).after < nothing


def test_lost_motion_of_the_loop_lags_where_it_is_dead_travel_and_leads_where_forward_is_beyond():
    command = np.array([0.0, 100.0, 200.0, 199.0, 150.0, 0.0])
    dead = loop.lost(command, np.full(6, 4.0))
    assert dead.tolist() == [-4.0, -4.0, -4.0, -3.0, 4.0, 4.0], "a play: it rests until taken up"
    beyond = loop.lost(command, np.full(6, -4.0))
    assert beyond.tolist() == [4.0, 4.0, 4.0, 4.0, -4.0, -4.0], "the last command says the side"


def test_a_refused_machine_is_told_without_the_folder_of_the_computer(tmp_path):
    folder = tmp_path / "machine"
    folder.mkdir()
    (folder / "machine.toml").write_text('format = "gcomp-machine/1"\nname = 3\n')
    text, said = loop.corrected("G21 G90\nG1 X1 F100\nM2\n", folder)
    assert text is None and "machine/machine.toml" in said and str(tmp_path) not in said
