"""What a person reads: sizes with sensible digits, nothing that says nothing, what to do next, and
a page that needs no network."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from postproc import effects, recordings
from postproc.cli import main
from postproc.diagnose import prose, words
from postproc.diagnose.analysis import diagnose
from postproc.machine.file import read_machine

ROOT = Path(__file__).resolve().parents[2]
STUDER = ROOT / "machines" / "studer-s36"


def of(name: str, ci: dict | None = None, **value: float) -> list[str]:
    """The parameters of an effect as they are said."""
    ci95 = {key: (ci or {}).get(key, (v, v)) for key, v in value.items()}
    said = words.parameters(effects.load(name), value, ci95, ["a.csv", "b.csv"], 600.0)
    return [" | ".join(part for part in parts if part) for parts in said]


@pytest.mark.parametrize(
    ("value", "low", "high", "said"),
    [
        (9.1234, 8.7012, 9.5456, ("9.12", "8.70", "9.55")),
        (-65.881, -73.93, -57.82, ("-65.9", "-73.9", "-57.8")),
        (1234.5, 934.0, 1535.0, ("1234", "934", "1535")),
        (0.00021234, 0.00020, 0.00023, ("0.000212", "0.000200", "0.000230")),
        (-0.0001, -0.9, 0.9, ("0.00", "-0.90", "0.90")),
        (7.30218, 7.30218, 7.30218, ("7.302", "", "")),
    ],
)
def test_two_digits_of_half_the_interval(value, low, high, said):
    assert words.number(value, low, high) == said


def test_what_is_as_it_is_where_nobody_states_it_is_not_said():
    assert of("backlash", {"size_um": (8.7, 9.5)}, size_um=9.1, play_mm=0.0) == [
        "size 9.10 um | 95 %: 8.70 to 9.50 | lost motion between the two directions of approach"
    ]
    assert len(of("backlash", size_um=9.1, play_mm=0.02)) == 2
    unused = {f"b{k}_um": 0.0 for k in range(3, 7)}
    said = of(
        "backlash_position",
        {f"b{k}_um": (1.0, 2.0) for k in range(3)},
        b0_um=1.5,
        b1_um=1.5,
        b2_um=1.5,
        **unused,
        play_mm=0.0,
        degree=2.0,
    )
    assert len(said) == 3 and not any("degree" in line or "b3" in line for line in said)


def test_numbers_that_stand_for_something_are_described_by_what_they_stand_for():
    assert of("bow", size_um=3.0, third_um=1.0, across=1.0)[-1] == "the direction of the error: Y"
    assert of("squareness", urad=12.0, leans=1.0)[-1] == "the second leans as the first moves"
    assert of("cosine", ppm=-40.0, file=1.0)[-1] == "in b.csv alone"
    assert len(of("cosine", ppm=-40.0, file=-1.0)) == 1
    assert of("stick_slip", period_mm=0.0, size_um=2.0)[0] == "too short to be told apart"
    assert of("tool_wear", rate_um=1.0, start_um=0.5, change=3.0)[-1].startswith("change 3 |")


def test_a_drift_says_what_it_goes_with():
    bed = of("structure_drift", size_um=8.0, tau_s=0.0)
    assert (
        bed[0].startswith("size 8 um per K |")
        and bed[1] == "by the recorded temperature of the bed"
    )
    assert of("structure_drift", size_um=8.0, tau_s=-120.0)[1] == "by that of the air, 120 s late"
    came = of("structure_drift", size_um=8.0, tau_s=900.0, from_s=-1.0, file=-1.0, bend_um=0.0)
    assert came == [
        "size 8 um | at the end of the recording",
        "tau about 900 s | the time in which it comes",
    ]
    assert of("structure_drift", size_um=8.0, tau_s=1e6)[1] == "evenly with the time"


@pytest.mark.parametrize("name", effects.names())
def test_every_parameter_of_every_effect_can_be_said(name):
    module = effects.load(name)
    value = dict.fromkeys(module.PARAMETERS, 1.25)
    said = words.parameters(module, value, {key: (1.0, 1.5) for key in value}, ["a.csv"])
    assert len(said) >= len(module.PARAMETERS) - 2  # degree, and the file's number
    assert all(meaning and not meaning.startswith(("um", "mm,")) for _, _, meaning in said)
    assert words.use(module)


def test_an_effect_that_no_place_decides_is_not_promised_to_programs():
    assert "programs can be corrected" in words.use(effects.load("backlash"))
    assert "programs can be corrected" not in words.use(effects.load("tool_size"))
    assert "never the machine" in words.use(effects.load("cosine"))


def test_names_that_share_a_size_or_a_reason_stand_together():
    assert (
        words.limits({"backlash:Z": 7e-4, "backlash:X": 7e-4, "scale:X": 2.1e-3, "bow:X": 5.0})
        == "0.7 um: backlash X Z; 2 um: scale X"
    )
    assert (
        words.blind(
            [("abbe", "X", "one line"), ("abbe", "Z", "one line"), ("delay", "", "at rest")]
        )
        == "abbe X Z (one line); delay (at rest)"
    )
    assert words.stretch("X", 400.0, 400.02) == "X at 400.0 mm"
    assert words.named("laser_air:") == "laser_air" and words.named("backlash:Z") == "backlash of Z"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A lost motion that the machine's file does not know, seen by a ballbar and a laser."""
    folder = tmp_path_factory.mktemp("words")
    read = []
    for name, test in (("bar", "ballbar:XZ"), ("laser", "positioning:Z")):
        file = folder / f"{name}.csv"
        hidden = ["--with", "backlash:Z:size_um=7", "--noise", "0.4", "--seed", "3", "--quiet"]
        assert (
            main(["simulate", "--test", test, "--machine", str(STUDER), *hidden, "-o", str(file)])
            == 0
        )
        read.append(recordings.read(recordings.Source(str(file), file.read_bytes())))
    return diagnose(read, read_machine(STUDER))


def test_the_text_says_what_where_how_large_how_sure_and_what_next(found):
    text = prose.as_text(found)
    assert text.splitlines()[0] == "The model of studer-s36 leaves out: backlash of Z."
    size = re.search(r"size (\d\.\d+) um \(95 %: (\S+) to (\S+)\): lost motion", text)
    assert size and float(size[2]) < 7.0 < float(size[3])
    for word in (
        "WHERE: ",
        "HELD OUT: ",
        "NEXT: ",
        "noise alone reaches",
        "Can not be seen in these recordings: ",
    ):
        assert word in text
    assert not re.search(r"play|= -1\b|: ,|:\s*$|\bnan\b|:\.|  um", text.replace("\n", "|\n"))


def test_a_map_that_predicts_nothing_is_said_to_be_of_no_use(found):
    cell = SimpleNamespace(low=10.0, high=10.0, approach=1, rows=5, mean=3e-3, error=2e-4)
    left = SimpleNamespace(
        signal=0,
        rms=2e-3,
        share=0.5,
        along="Z",
        depends=("position",),
        cells=(cell,),
        before=2e-3,
        after=2e-3,
    )
    kept, found.unknown = found.unknown, left
    try:
        assert "predicts nothing" in prose.unknown_words(
            found
        ) and "+3.0 um, at Z = 10 mm, approached in +" in prose.unknown_words(found)
        left.after = 5e-4
        assert "from 2.00 to 0.50 um rms" in prose.unknown_words(found)
    finally:
        found.unknown = kept


def test_a_mismatch_without_a_name_is_no_clean_bill(found):
    findings, found.findings = found.findings, []
    unknown, found.unknown = found.unknown, None
    try:
        assert found.verdict == "nothing-left-out" and found.places
        text = prose.as_text(found)
        assert (
            "Nothing is left out" not in text
            and "see WHERE" in text.splitlines()[0]
            and "record the same again" in text
        )
    finally:
        found.findings, found.unknown = findings, unknown


def test_a_room_that_switches_has_an_amplitude_and_no_time_constant():
    """size_um alone is "um at the end"; of a cycle it is the amplitude, whatever tau_s stands
    there."""
    said = of("structure_drift", {"size_um": (2.0, 4.0)}, size_um=3.0, tau_s=1.0, cycle_s=1200.0)
    assert said[0] == "size 3.0 um | 95 %: 2.0 to 4.0 | its amplitude, zero to peak"
    assert len(said) == 2 and said[1].startswith("cycle 1200 s | period of a room")


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        (
            "tool_wear",
            {"life": 10.0},
            "life 10 runs | of the gauge after which the tool is changed every time",
        ),
        ("tool_wear", {"bores": -1.0}, "it makes bores smaller, as an edge does"),
        ("squareness", {"leans": 1.0}, "the second leans as the first moves"),
        ("sag", {"free_end": -1.0}, "it is free at the low end"),
        (
            "spindle_growth",
            {"power": 5 / 3},
            "power 1.667 | the power of the speed that heat goes with",
        ),
    ],
)
def test_what_a_choice_means_stands_by_itself(name, value, said):
    assert of(name, **value) == [said]


def test_a_unit_is_a_unit():
    for name in effects.names():
        for text in effects.load(name).PARAMETERS.values():
            assert len(words._meaning(text)[0]) < 30, (name, text)
