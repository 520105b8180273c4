"""Which test a recording is for is told from its data; what fits none is refused with file and
line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from iso_made import UM, along, both_ways, runs_of, targets

from postproc.iso import IsoError, Options, choose
from postproc.recordings import ReadingOptions, Recording, Source, contract

PRACTICE = Path(__file__).resolve().parents[3] / "shared" / "recordings" / "practice"
LINE = np.arange(0.0, 401, 50)


def kinds(*recordings, **options):
    found, left = choose.results(recordings, Options(**options))
    return [(r.test, r.subject.split(",")[0]) for r in found], found, left


@pytest.mark.parametrize(
    ("letter", "sensitive", "quantity", "expected"),
    [
        ("X", {"X": 1.0}, "displacement", ("positioning", "EXX")),
        ("Y", {"Y": -1.0, "Z": 0.0}, "displacement", ("positioning", "EYY")),
        ("Z", {"X": 1.0}, "straightness", ("straightness", "EXZ")),
        ("Z", {"Y": 1.0}, "displacement", ("straightness", "EYZ")),
        ("Z", {"Y": 1.0}, "angle", ("angle", "EBZ")),
        ("X", {"B": 1.0}, "angle", ("angle", "EBX")),
        ("C", {"C": 1.0}, "angle", ("rotary", "ECC")),
        ("C", {"Z": 1.0}, "angle", ("rotary", "ECC")),
        ("C", {"X": 1.0}, "angle", ("angle", "EAC")),
    ],
)
def test_the_test_follows_from_axis_quantity_and_direction(letter, sensitive, quantity, expected):
    found, results, _ = kinds(along(letter, LINE, np.zeros((2, 9)), sensitive, quantity))
    assert found == [expected]
    assert f"{letter} moves" in results[0].chosen


def diagonal(signs, axes="XYZ", sense=1.0, scale=0.0, lost=0.0):
    """A diagonal of 300, 200, 100 mm; readings: scale (um/m) along it, `lost` um of reversal."""
    ends = dict(zip(axes, (300.0, 200.0, 100.0), strict=False))
    length = np.sqrt(sum(v * v for v in ends.values()))
    share = np.linspace(0, 1, 7)
    t, approach, reading, run = runs_of(
        share, np.stack([scale * share * length / 1000, scale * share * length / 1000 - lost])
    )
    moves, ways = {}, {}
    for x, sign in zip(axes, signs, strict=True):
        moves[x] = ends[x] * (t if sign == "P" else 1 - t)
        ways[x] = approach * (1 if sign == "P" else -1)
    unit = {
        x: sense * (1 if s == "P" else -1) * ends[x] / length
        for x, s in zip(axes, signs, strict=True)
    }
    return targets(moves, sense * reading, ways, unit, run=run)


def test_diagonals_by_their_signs_and_the_largest_of_each():
    found, results, _ = kinds(
        *(
            diagonal(s, scale=k, lost=b)
            for s, k, b in (("PPP", 10, 1), ("NPP", -30, 2), ("PNP", 20, 5), ("NNP", 0, 1))
        )
    )
    assert found[:4] == [
        ("diagonal", "PPP of XYZ"),
        ("diagonal", "NPP of XYZ"),
        ("diagonal", "PNP of XYZ"),
        ("diagonal", "NNP of XYZ"),
    ]
    # length sqrt(300^2 + 200^2 + 100^2) = 374.17 mm; E of NPP = 30e-6 * 374.17 + 2 um = 13.22; of
    # PNP 7.48 + 5 = 12.48.
    assert found[4] == ("diagonals", "XYZ diagonals")
    assert (
        results[4]["Ed"].value / UM == pytest.approx(13.225, abs=1e-3)
        and results[4]["Ed"].at == "NPP"
    )
    assert results[4]["Bd"].value / UM == pytest.approx(5) and results[4]["Bd"].at == "PNP"
    assert any("can not separate scale from squareness" in n for n in results[4].notices)
    assert not any("measured," in n for n in results[4].notices)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(
    ("signs", "name"), [("PP", "PP"), ("NP", "NP"), ("PN", "NP"), ("NN", "PP")]
)
def test_a_diagonal_is_the_same_from_both_ends_and_with_either_sign(signs, name, sense):
    found, results, _ = kinds(diagonal(signs, "XZ", sense, scale=100, lost=3))
    assert found[0] == ("diagonal", f"{name} of XZ")
    # 361 mm (300, 200) * 100 um/m = 36.06 um, + 3 = 39.06; measured from the other end, the zero is
    # there: B alone turns.
    assert results[0]["E"].value / UM == pytest.approx(39.056, abs=1e-3)
    assert results[0]["M"].value / UM == pytest.approx(36.056, abs=1e-3)
    assert any("1 of 2 diagonals measured" in n for n in results[1].notices)
    mean = results[0].columns["mean + um"]
    assert (mean[-1] - mean[0]) == pytest.approx(36.056, abs=1e-3)


def test_one_way_diagonals_have_no_largest():
    recording = diagonal("PPP")
    _, results, _ = kinds(recording.pick(recording.approach("X") > 0))
    assert results[0]["E+"].value == 0 and results[1]["Ed"].value is results[1]["Bd"].value is None


def test_an_axis_at_several_places_is_as_many_results():
    one, two = (along("Z", LINE, np.full((2, 9), v)) for v in (1.0, 2.0))
    columns = {n: np.concatenate([c, two.columns[n]]) for n, c in one.columns.items()}
    columns["X_mm"][len(one) :] = 120.0
    both = Recording(
        "targets", one.head, columns, "made.csv", np.arange(2, len(columns["X_mm"]) + 2)
    )
    found, results, _ = kinds(both)
    assert found == [("positioning", "EZZ")] * 2
    assert [r.subject for r in results] == ["EZZ, X 0, Y 0", "EZZ, X 120, Y 0"]
    assert [r.columns["mean + um"][0] for r in results] == pytest.approx([1.0, 2.0])


def test_straightnesses_that_do_not_face_each_other_make_no_squareness():
    one = along("X", LINE, np.zeros((2, 9)), {"Y": 1.0}, "straightness")
    two = along("Y", LINE, np.zeros((2, 9)), {"Z": 1.0}, "straightness")
    assert [k for k, _ in kinds(one, two)[0]] == ["straightness", "straightness"]


def broken(change):
    recording = along("X", LINE, np.zeros((2, 9)))
    change(recording)
    return recording


def scattered(recording):
    recording.columns["Y_mm"][:] = np.random.default_rng(1).uniform(0, 100, len(recording))
    recording.columns["X_mm"][:] = np.random.default_rng(2).uniform(0, 100, len(recording))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r.columns.update(X_mm=np.zeros(len(r))), "no axis moves"),
        (
            lambda r: r.columns.update(approach_X=np.zeros(len(r))),
            "direction of approach is not recorded: approach_X",
        ),
        (lambda r: r.columns.pop("approach_X"), "direction of approach is not recorded"),
        (
            lambda r: r.head.update(sensitive={"X": 0.6, "Y": 0.8}),
            "neither along the motion nor across it",
        ),
        (
            lambda r: r.head.update(quantity="straightness"),
            "neither along the motion nor across it",
        ),
        (scattered, "neither alone nor along one straight line"),
    ],
)
def test_what_fits_no_test_is_refused_with_its_place(change, message):
    with pytest.raises(IsoError, match=message) as caught:
        kinds(broken(change))
    assert caught.value.place.file == "made.csv" and caught.value.place.line >= 1


def test_a_single_target_at_one_place_is_named():
    recording = along("X", LINE, np.zeros((2, 9)))
    recording.columns["Y_mm"][4] = 60.0
    with pytest.raises(IsoError, match="at Y 60 there is one target of X only") as caught:
        kinds(recording)
    assert caught.value.place.line == 6


def test_rotary_motion_and_crooked_angles_are_refused():
    with pytest.raises(IsoError, match="no angle is read"):
        kinds(along("C", LINE, np.zeros((2, 9)), {"X": 1.0}))
    recording = along("X", LINE, np.zeros((2, 9)), {"Y": 0.6, "Z": 0.8}, "angle")
    recording.columns["reading_urad"] = recording.columns.pop("reading_urad")
    with pytest.raises(IsoError, match="about no axis"):
        kinds(recording)
    skew = diagonal("PP", "XZ")
    skew.head["sensitive"] = {"X": 1.0}
    with pytest.raises(IsoError, match="along a diagonal"):
        kinds(skew)


def test_other_recordings_are_left_out_and_said():
    features = Recording("features", {}, {"nominal_mm": np.zeros(1)}, "part.csv")
    found, _, left = kinds(both_ways(lambda t, w: 0.0), features)
    assert found == [("circle", "XY")]
    assert left == ["part.csv: no test of the ISO 230 series is evaluated from features"]
    with pytest.raises(IsoError, match="nothing to evaluate"):
        kinds(features)


@pytest.mark.skipif(not PRACTICE.exists(), reason="practice recordings are not beside the project")
def test_every_practice_recording_has_its_test():
    seen = set()
    for path in sorted(PRACTICE.glob("*/r*.csv")):
        recording = contract.read(Source(path.name, path.read_bytes()), ReadingOptions())
        if recording.kind not in ("targets", "ballbar"):
            continue
        results, _ = choose.results([recording], Options())
        seen |= {r.test for r in results}
        for result in results:
            values = [p.value for p in result.parameters]
            assert any(v is not None for v in values) and all(
                v is None or np.isfinite(v) for v in values
            )
            if result.test == "circle":
                assert (
                    result["H"].value < 100 * UM
                    and result["Gxy" if "XY" in result.subject else "Gxz"].value > 0
                )
    assert seen == {"positioning", "straightness", "diagonal", "diagonals", "circle"}
