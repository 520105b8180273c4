"""What looks like a slip is said: the unit by its range, the directions of the runs by the splits
that they might be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pytest import approx

from postproc.errors import UsageError
from postproc.recordings import _components as components
from postproc.recordings import _split as split
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from tests.recordings import samples
from tests.recordings.samples import taken

K = 12


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("um", 1.0),
        ("µm", 1.0),
        ("μm", 1.0),
        ("MM", 1e3),
        ("in", 25400.0),
        ("nm", 1e-3),
        ("mm/m", 1e3),
        ("mrad", 1e3),
        ("µrad", 1.0),
        ("arcsec", math.pi / 0.648),
        ("arc-sec", math.pi / 0.648),
        ("deg", math.pi / 180 * 1e6),
        ("°", math.pi / 180 * 1e6),
    ],
)
def test_units_in_all_spellings(name, factor):
    """One arcsecond is pi / 648000 rad."""
    assert units.named(name).factor == approx(factor, rel=1e-12)


def test_the_micro_sign_of_another_code_page_is_known():
    assert units.named("µm".encode("cp1252").decode("gbk")).name == "um"


@pytest.mark.parametrize(
    ("heading", "name"),
    [
        ("Up 1 (µm)", "um"),
        ("dzz_mm", "mm"),
        ("Deviation in arcsec", "arcsec"),
        ("Error [mm/m]", "mm/m"),
        ("Up 1 µm", "um"),
        ("Mean", None),
        ("Run in", None),
        ("comes in", None),
        ("x (first)", None),
    ],
)
def test_units_in_headings(heading, name):
    found = units.in_heading(heading)
    assert (found.name if found else None) == name


@pytest.mark.parametrize("quantity", ["length", "angle"])
def test_the_band_has_two_ends(quantity):
    low, high = units.BAND[quantity]
    assert (
        units.outside(low * 1.01, quantity) is None and units.outside(high * 0.99, quantity) is None
    )
    assert units.outside(low * 0.99, quantity) and units.outside(high * 1.01, quantity)
    assert units.outside(0.0, quantity) == "all readings are the same"


@pytest.mark.parametrize(
    ("spread", "read_in", "slip"),
    [
        (0.012, "um", "mm read as um"),
        (12_000.0, "mm", "um read as mm"),
        (0.03, "urad", "mm/m read as urad|mrad read as urad"),
        (50_000.0, "deg", "arcsec read as deg"),
        (0.05, "urad", "deg read as urad"),
    ],
)
def test_the_likely_slip_is_named(spread, read_in, slip):
    unit = units.named(read_in)
    told = units.outside(spread, unit.quantity, unit)
    assert told and any(s in told for s in slip.split("|"))


def drawn(runs: int, sign, reversal: float = 5.0, drift: float = 0.0, seed: int = 0):
    """run, target, value of a screw with a reversal, a drift from run to run, and 0.2 of
    scatter."""
    rng = np.random.default_rng(seed)
    run, k = np.meshgrid(np.arange(1, runs + 1), np.arange(K), indexing="ij")
    truth = np.array([sign(r) for r in range(1, runs + 1)])
    value = (
        np.sin(k / 2)
        + 0.5 * reversal * truth[:, None]
        + drift * run
        + rng.normal(0, 0.2, run.shape)
    )
    return run.ravel(), 10.0 * k.ravel(), value.ravel(), np.repeat(truth, K)


def parity(r):
    return 1 if r % 2 else -1


@pytest.mark.parametrize("runs", [4, 5, 6, 10, 16])
def test_the_true_directions_are_never_doubted(runs):
    for seed in range(20):
        for drift in (0.0, 2.0):
            run, target, value, sign = drawn(
                runs, parity, drift=drift if runs >= 6 else 0.0, seed=seed
            )
            assert split.better_split(run, target, value, sign) is None
        # nor where there is no reversal at all
        run, target, value, sign = drawn(runs, parity, reversal=0.0, seed=seed)
        assert split.better_split(run, target, value, sign) is None


@pytest.mark.parametrize("runs", [4, 6, 10, 16])
def test_blocks_read_by_turns_are_found(runs):
    """All up, then all down, but odd runs were taken as up."""
    half = runs // 2
    run, target, value, _ = drawn(runs, lambda r: 1 if r <= half else -1)
    told = split.better_split(run, target, value, np.where(run % 2, 1, -1))
    assert told and f"runs {', '.join(str(r) for r in range(1, half + 1))} are alike" in told
    assert "with a random one" in told


def test_runs_there_and_back_taken_for_one_way_are_found():
    run, target, value, _ = drawn(6, parity)
    told = split.better_split(run, target, value, np.ones(len(run)))
    assert (
        told
        and "runs 1, 3, 5 are alike, and so are runs 2, 4, 6; with one direction for all" in told
    )


def test_too_few_runs_say_nothing():
    run, target, value, _ = drawn(3, parity)
    assert split.better_split(run, target, value, np.ones(len(run))) is None


def test_the_doubt_reaches_the_reader():
    table = samples.readings(6)
    right = taken(
        "z.txt", samples.blocks(table, headed=False), axis="Z", unit="um", layout="blocks"
    )
    wrong = taken(
        "z.txt", samples.blocks(table, headed=False), axis="Z", unit="um", layout="interleaved"
    )
    assert not any("look wrong" in t for t in right.notices)
    assert any(
        "look wrong: runs 1, 2, 3 are alike, and so are runs 4, 5, 6" in t for t in wrong.notices
    )


@pytest.mark.parametrize(
    ("name", "axis", "quantity", "sensitive"),
    [
        ("EZZ", "Z", "displacement", {"Z": 1}),
        ("exz", "Z", "straightness", {"X": 1}),
        ("EAX", "X", "angle", {"X": 1}),
        ("EBZ", "Z", "angle", {"Y": 1}),
        ("ECY", "Y", "angle", {"Z": 1}),
        ("ECC", "C", "angle", {"Z": 1}),
        ("EXC", "C", "straightness", {"X": 1}),
    ],
)
def test_components_by_their_names(name, axis, quantity, sensitive):
    found = components.parsed(name)
    assert (found.axis, found.quantity, found.sensitive) == (axis, quantity, sensitive)


@pytest.mark.parametrize("name", ["B0Z", "EZ", "dzz", "EZZZ", ""])
def test_other_names_are_refused(name):
    with pytest.raises(UsageError, match="no component"):
        components.parsed(name)


@pytest.mark.parametrize(
    ("words", "axis"),
    [
        ("Z", "Z"),
        ("X-axis", "X"),
        ("Achse y", "Y"),
        ("Z1", "Z"),
        ("X and Y", ""),
        ("linear", ""),
        ("", ""),
    ],
)
def test_axis_letters_in_free_text(words, axis):
    assert components.axis_in(words) == axis


@pytest.mark.parametrize(
    "word", ["1_000", "nan", "inf", "1e999", "0x10", "１２", "1,5", "--1", "1e", ""]
)
def test_only_plain_digits_are_numbers(word):
    assert text.number(word) is None


@pytest.mark.parametrize(
    ("word", "value"), [("1.5", 1.5), ("-.5", -0.5), ("+5.", 5.0), ("1E-3", 1e-3), ("−2", -2.0)]
)
def test_numbers(word, value):
    assert text.number(word) == value
    assert (
        text.number(
            word.replace(".", ",") if "," not in word and "5." not in word else word,
            "," if "5." not in word else ".",
        )
        == value
    )


def test_where_a_run_has_readings_of_both_directions_nothing_is_said():
    """Six runs by turns, of which one reading stands under the other direction: there is no split
    of runs to be compared with."""
    run, target, value, _ = drawn(6, parity)
    sign = np.ones(len(run))
    assert split.better_split(run, target, value, sign) is not None
    sign[0] = -1
    assert split.better_split(run, target, value, sign) is None
