"""The Python interface gives what the command line gives, takes every setting, and refuses what is
none."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest

import gcomp
from postproc.api.programs import CHOICES, UNITS
from postproc.cli import main
from postproc.commands import reading_options

ROOT = Path(__file__).resolve().parents[2]
SHAFT = ROOT / "sample_programs" / "shaft.nc"
# What the command line calls otherwise: a unit at the end, and two offsets that would have one
# name.
OTHERWISE = {
    "tolerance_um": "tolerance",
    "hole_tolerance_um": "hole_tolerance",
    "hysteresis_um": "hysteresis",
    "ramp_mm": "ramp",
    "offsets": "offset",
    "offset_files": "offsets",
}


def options() -> dict[str, argparse.Action]:
    parser = argparse.ArgumentParser(add_help=False)
    reading_options.arguments(parser)
    return {action.dest: action for action in parser._actions}


def test_every_option_of_the_command_line_is_a_setting_and_no_other():
    taken = {OTHERWISE.get(name, name) for name in gcomp.Settings.__annotations__}
    # all three are of load_machine
    assert taken == set(options()) - {"machine", "temperature", "only"}
    assert set(UNITS) | set(CHOICES) <= set(gcomp.Settings.__annotations__)


def test_choices_are_those_of_the_command_line():
    for name, allowed in CHOICES.items():
        assert tuple(options()[name].choices or ()) == allowed


@pytest.mark.parametrize(
    "settings, words",
    [
        ({}, []),
        ({"tolerance_um": 2.0}, ["--tolerance", "2um"]),
        ({"reversal": "mean"}, ["--reversal", "mean"]),
        ({"block_delete": True, "cut_rapids": True}, ["--block-delete", "on", "--cut-rapids"]),
        ({"offsets": {"G54": {"X": 1.0, "Z": -0.5}}}, ["--offset", "G54=X1,Z-0.5"]),
    ],
)
def test_the_bytes_and_the_json_of_the_command_line(tmp_path, settings, words):
    out, told = tmp_path / "out.nc", tmp_path / "told.json"
    assert (
        main(
            [
                "--machine",
                "studer-s36",
                *words,
                "--verify",
                "--json",
                str(told),
                "-o",
                str(out),
                str(SHAFT),
            ]
        )
        == 0
    )
    done = gcomp.compensate(SHAFT, "studer-s36", verify=True, **settings)
    assert done.program == out.read_bytes()
    assert json.loads(done.to_json()) == json.loads(told.read_text())


def test_a_path_a_text_bytes_and_any_pieces_are_the_same_program():
    data = SHAFT.read_bytes()
    machine = gcomp.load_machine("studer-s36")
    ways = [
        SHAFT,
        data,
        data.decode(),
        [data[:100], data[100:101], data[101:]],
        iter(data.decode().splitlines(True)),
    ]
    assert len({gcomp.compensate(way, machine).program for way in ways}) == 1
    live = gcomp.live_filter(machine)
    assert (
        b"".join(live.feed(data[i : i + 7]) for i in range(0, len(data), 7)) + live.finish()
        == gcomp.compensate(data, machine).program
    )


def test_bytes_that_are_no_text_come_through():
    program = b"(caf\xe9 \xff)\nG90 G21 G18 G0 X20. Z0.\n"
    done = gcomp.compensate(program, "studer-s36")
    assert b"(caf\xe9 \xff)" in done.program
    assert done.text.encode("utf-8", "surrogateescape") == done.program


def test_a_zero_map_moves_no_byte_and_says_so():
    text = "G90 G21 G0 X20. Y0. Z0.\nG1 X40. F100\n"
    done = gcomp.compensate(text, "perfect")
    assert (done.text, done.changed, done.added) == (text, 0, 0)


@pytest.mark.parametrize(
    "settings, says",
    [
        ({"tolerance_um": -1}, "not above zero"),
        ({"tolerance_um": 5000}, "over 1 mm"),
        ({"reversal": "sideways"}, "none of mean, step"),
        ({"offsets": {"G99": {"X": 1.0}}}, "G99"),
        ({"offsets": {"G54": {"Q": 1.0}}}, "Q"),
        ({"start": {"Y": 0.0}}, "no axis of studer-s36"),
        ({"dialect": "none"}, "none"),
    ],
)
def test_a_setting_that_can_not_be_is_refused_with_what_can(settings, says):
    with pytest.raises(gcomp.UsageError) as error:
        gcomp.compensate("G0 X1.\n", "studer-s36", **settings)
    assert says in str(error.value)


def test_a_keyword_that_is_none_is_a_type_error_with_those_that_are():
    with pytest.raises(TypeError, match="'tolerence_um'; settings: tolerance_um"):
        gcomp.compensate("G0 X1.\n", "studer-s36", tolerence_um=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="no option 'dattum'"):
        gcomp.calibrate([], dattum=["Z=0"])


def test_a_refused_program_names_its_line_and_the_way_out():
    with pytest.raises(gcomp.ProgramError) as error:
        gcomp.compensate(b"G90 G21 G0 X20. Z0.\nG1 X30. XX2 F100\n", "studer-s36")
    assert error.value.place is not None and (error.value.place.file, error.value.place.line) == (
        "<program>",
        2,
    )


def test_a_file_that_stands_is_written_over_only_when_asked(tmp_path):
    done = gcomp.compensate("G90 G21 G18 G0 X20. Z0.\n", "studer-s36")
    path = done.save(tmp_path / "a.nc")
    with pytest.raises(gcomp.UsageError, match="exists"):
        done.save(path)
    assert done.save(path, overwrite=True).read_bytes() == done.program


def test_temperatures_warm_the_machine_or_are_refused():
    with pytest.raises(gcomp.UsageError, match="does not say how"):
        gcomp.load_machine("studer-s36", {"Z": 25.0})


def test_a_part_of_the_map_is_the_command_lines(tmp_path):
    out = tmp_path / "out.nc"
    assert (
        main(["--machine", "studer-s36", "--only", "EZZ", "--quiet", "-o", str(out), str(SHAFT)])
        == 0
    )
    part = gcomp.load_machine("studer-s36", only=["EZZ"])
    assert (
        gcomp.compensate(SHAFT, part).program
        == out.read_bytes()
        != gcomp.compensate(SHAFT, "studer-s36").program
    )


def test_a_machine_there_is_not_is_answered_with_those_there_are():
    with pytest.raises(gcomp.UsageError) as error:
        gcomp.compensate("G0 X1.\n", "no-such-machine")
    assert "studer-s36" in error.value.advice


def test_the_json_of_a_program_does_not_go_where_the_program_goes(tmp_path, capfd):
    program = tmp_path / "p.nc"
    program.write_bytes(SHAFT.read_bytes())
    line = ["--machine", "studer-s36", str(program)]
    assert main([*line, "--json", "-"]) == 2
    assert main([*line, "--json", str(program)]) == 2
    assert main([*line, "--json", "x.json", "--unbuffered"]) == 2
    assert program.read_bytes() == SHAFT.read_bytes()
    capfd.readouterr()
    assert main([*line, "--json", "-", "-o", str(tmp_path / "o.nc"), "--quiet"]) == 0
    assert json.loads(capfd.readouterr().out)["format"] == "gcomp-program/1"


def test_iso_and_calibrate_and_recordings_are_the_commands(tmp_path, capfd, monkeypatch):
    file = ROOT / "sample_recordings" / "z_positioning.csv"
    assert main(["iso", str(file), "--json", "-"]) == 0
    assert json.loads(capfd.readouterr().out) == json.loads(
        gcomp.evaluate([gcomp.read_recording(file)]).to_json()
    )
    names = [
        str(ROOT / "sample_recordings" / f"{n}.csv") for n in ("x_positioning", "z_positioning")
    ]
    monkeypatch.chdir(tmp_path)
    assert (
        main(
            ["calibrate", *names, "--like", "example-lathe", "--mean", "-o", "mine", "--json", "-"]
        )
        == 0
    )
    told = json.loads(capfd.readouterr().out)
    found = gcomp.calibrate(
        map(gcomp.read_recording, names), like="example-lathe", name="mine", mean=True
    )
    assert json.loads(found.to_json()) == {k: v for k, v in told.items() if k != "sha256"}
    assert {p.name: p.read_text() for p in (tmp_path / "mine").iterdir()} == found.files
    with pytest.raises(gcomp.UsageError, match="there already"):
        found.save(tmp_path / "mine")


@pytest.mark.parametrize("compensated", [False, True])
def test_a_diagnosis_is_the_commands_before_and_after_compensation(tmp_path, capfd, compensated):
    file = ROOT / "sample_recordings" / "ballbar_xz.csv"
    rows = file.read_text().splitlines()
    thin = tmp_path / "thin.csv"
    head = [r for r in rows if r.startswith("#")]
    body = rows[len(head) :]
    thin.write_text("\n".join([*head, body[0], *body[1::25]]) + "\n")
    words = ["diagnose", str(thin), "--machine", "studer-s36", "--json", "-", "--quiet"]
    assert main([*words, *["--compensated"] * compensated]) == 0
    found = gcomp.diagnose([thin], "studer-s36", compensated=compensated)
    assert json.loads(capfd.readouterr().out) == json.loads(found.to_json())
