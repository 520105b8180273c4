"""ISO 230-4 on circles that were made: the known error gives the known G, F, H and D."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iso_made import UM, ballbar, both_ways

from postproc.iso import IsoError, Options, Stated, choose
from postproc.iso.circles import least_squares, minimum_zone

RADIUS = 100.0  # mm


def values(recording):
    (result,), _ = choose.results([recording], Options())
    return {p.name: None if p.value is None else p.value / UM for p in result.parameters}, result


def is_near(found, expected, within=1e-3):
    for name, value in expected.items():
        assert found[name] == (value if value is None else pytest.approx(value, abs=within)), name


def test_squareness_and_scale_mismatch():
    # dr = (g r / 2) sin 2t: g = 50 urad, r = 100 mm: +-2.5 um. dr = (ds r / 2) cos 2t: ds = 80
    # um/m: +-4 um.
    found, _ = values(both_ways(lambda t, way: 2.5 * np.sin(2 * t)))
    is_near(
        found,
        {
            "Gxy": 5,
            "Gyx": 5,
            "Gxy mz": 5,
            "G(b)": 5,
            "G(b) mz": 5,
            "H": 0,
            "D": 0,
            "Fxy max": 2.5,
            "Fyx min": -2.5,
        },
    )
    found, _ = values(both_ways(lambda t, way: 4 * np.cos(2 * t)))
    is_near(found, {"Gxy": 8, "Gyx": 8, "G(b)": 8, "H": 0, "D": 0, "Fxy max": 4, "Fxy min": -4})


def test_mean_scale_is_d_alone():
    # both scales 30 um/m long: r grows by 3 um everywhere.
    found, _ = values(both_ways(lambda t, way: 3.0))
    is_near(
        found, {"Gxy": 0, "G(b)": 0, "H": 0, "D": 3, "Fxy max": 3, "Fxy min": 3, "Fxy max c": 3}
    )


def test_backlash_steps_at_the_quadrants():
    """X lags by b / 2 behind its motion: xy turns X towards - in the upper half, where it stands b
    / 2 too far in +."""
    b = 6.0

    def radial(t, way):
        # just after 0 and 180 degrees it has turned
        return way * b / 2 * np.sign(np.sin(t + way * 1e-6)) * np.cos(t)

    found, result = values(both_ways(radial, per_turn=3600))
    # each sense: +b/2 and -b/2 on either side of the step; between the senses b at the steps.
    is_near(
        found,
        {"Gxy": 6, "Gyx": 6, "G(b)": 6, "H": 6, "D": 0, "Fxy max": 3, "Fxy min": -3},
        within=0.02,
    )
    at = float(result["H"].at.split()[1])
    assert min(abs(at % 180), 180 - at % 180) < 1


def test_a_centre_beside_the_machine_s_is_in_f_alone():
    """Measured from a centre (20, -10) um off: exact distances, e.u + sqrt(r^2 - (e x u)^2) - r."""
    e = np.array([20.0, -10.0]) * UM

    def radial(t, way):
        u = np.stack([np.cos(t), np.sin(t)])
        return (-e @ u + np.sqrt(RADIUS**2 - (e[0] * u[1] - e[1] * u[0]) ** 2) - RADIUS) / UM

    found, result = values(both_ways(radial))
    is_near(found, {"Gxy": 0, "Gyx mz": 0, "G(b)": 0, "H": 0, "D": 0, "Fxy max c": 0}, within=1e-6)
    # |e| = 22.36 um
    is_near(found, {"Fxy max": np.hypot(20, 10), "Fyx min": -np.hypot(20, 10)}, within=0.01)
    assert [result.columns[f"centre {x} um"][0] for x in "XY"] == pytest.approx([-20, 10], abs=1e-6)


def test_the_senses_apart_are_hysteresis_and_in_the_two_way_deviation():
    # one sense 2 um larger everywhere: each is a circle; about one centre their zone is 2; D is the
    # mean of 0 and 2.
    found, _ = values(both_ways(lambda t, way: 1.0 + way))
    is_near(
        found,
        {"Gxy": 0, "Gyx": 0, "G(b)": 2, "G(b) mz": 2, "H": 2, "D": 1, "Fxy max": 2, "Fyx max": 0},
    )


def test_senses_are_named_by_the_way_they_turn():
    # +1 in the file turns from +Z to +X here: that is zx.
    recording = both_ways(lambda t, way: 1.0 + way, axes="XZ")
    recording.columns["sense"] = -recording.columns["sense"]
    found, result = values(recording)
    is_near(found, {"Fxz max": 2, "Fzx max": 0})
    assert "xz turns from +X to +Z" in result.chosen


def test_overshoot_is_taken_off_by_angle():
    """Arcs of 180 degrees before and after the circle hold a run-in of 50 um; the middle turn is 4
    cos 2t."""

    def radial(t, way):
        turned = np.abs(t - t[0])
        inside = (turned >= np.pi - 1e-9) & (turned < 3 * np.pi - 1e-9)
        return np.where(inside, 4 * np.cos(2 * t), 50.0)

    found, result = values(ballbar([(1, 10, 720, radial), (-1, 10, 720, radial)]))
    is_near(found, {"Gxy": 8, "Gyx": 8, "G(b)": 8, "H": 0, "D": 0, "Fxy max": 4})
    assert any("overshoot taken off: 360 to 360 degrees" in n for n in result.notices)
    assert result.columns["samples"] == [720, 720]


def test_an_arc_is_no_circle():
    found, result = values(
        ballbar([(1, 0, 220, lambda t, w: 1.0), (-1, 220, 220, lambda t, w: -1.0)])
    )
    is_near(
        found,
        {
            "Gxy": None,
            "Gxy mz": None,
            "G(b)": None,
            "D": None,
            "Fxy max c": None,
            "H": 2,
            "Fxy max": 1,
            "Fyx min": -1,
        },
    )
    assert any("220 degrees is no full circle" in n for n in result.notices)


def test_one_sense_has_no_hysteresis():
    found, result = values(ballbar([(1, 0, 360, lambda t, w: np.cos(2 * t))]))
    is_near(found, {"Gxy": 2, "Gyx": None, "G(b)": None, "H": None, "D": None, "Fyx max": None})
    assert any("one sense only" in n for n in result.notices)


def test_runs_are_pairs_in_their_order_and_scatter_is_in_u():
    # H of the pairs: 1 and 3 um: mean 2, s = sqrt(2), n = 2: t(1 dof, 95.45 %) = 13.97, 13.97 *
    # sqrt(2) / sqrt(2) = 13.97.
    shift = iter([0.0, 1.0, 0.0, 3.0])
    circles = [(w, 0, 360, lambda t, way, d=next(shift): d) for w in (1, -1, 1, -1)]
    _, result = values(ballbar(circles))
    assert result["H"].value == pytest.approx(2 * UM)
    assert result["H"].runs == pytest.approx(13.97 * UM, rel=2e-3)


def brute_annulus(points):
    """Least ring width: its centre is as far from two outer points as from each other, and from two
    inner ones, or from three of one kind."""
    best = np.inf
    for i, j, k, m in itertools.permutations(range(len(points)), 4):
        if i > j or k > m:
            continue
        candidates = [_centre(points, (i, j), (k, m)), _centre(points, (i, j), (j, k))]
        for centre in candidates:
            if centre is not None and np.linalg.norm(centre) < 1.0:
                best = min(best, float(np.ptp(np.linalg.norm(points - centre, axis=1))))
    return best


def _centre(points, one, two):
    """Where the perpendicular bisectors of two pairs of points meet."""
    rows = np.array([points[b] - points[a] for a, b in (one, two)])
    right = np.array([(points[b] @ points[b] - points[a] @ points[a]) / 2 for a, b in (one, two)])
    return None if abs(np.linalg.det(rows)) < 1e-9 else np.linalg.solve(rows, right)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_minimum_zone_circle_against_every_ring(seed):
    generator = np.random.default_rng(seed)
    count = int(generator.integers(5, 9))
    angle = np.arange(count) * 2 * np.pi / count + generator.uniform(-0.3, 0.3, count)
    # large deviations, so that a linear fit alone would be off
    radius = 5.0 + 0.02 * generator.normal(size=count)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1) + generator.uniform(
        -0.05, 0.05, 2
    )
    found = minimum_zone(points, 5.0)
    assert found.zone == pytest.approx(brute_annulus(points), abs=1e-9)
    assert found.zone <= least_squares(points, 5.0).zone + 1e-12


def test_least_squares_circle_is_stationary():
    generator = np.random.default_rng(4)
    angle = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    points = (10 + 0.1 * generator.normal(size=50))[:, None] * np.stack(
        [np.cos(angle), np.sin(angle)], axis=1
    ) + [0.5, -0.3]
    found = least_squares(points, 10.0)

    def squares(centre, radius):
        return np.sum((np.linalg.norm(points - centre, axis=1) - radius) ** 2)

    best = squares(found.centre, found.radius)
    for step in (1e-4, -1e-4):
        assert (
            squares(found.centre + [step, 0], found.radius)
            > best
            < squares(found.centre + [0, step], found.radius)
        )
        assert squares(found.centre, found.radius + step) > best


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda r: r.head.update(radius_mm=50.0),
            "100.000 mm from the centre, the radius is 50 mm",
        ),
        (lambda r: r.head.update(centre={"X": 0.0}), "the centre names X"),
        (lambda r: r.columns.update(sense=np.ones(len(r))), "turns the other way"),
    ],
)
def test_what_is_no_circle_is_refused_with_its_line(change, message):
    recording = both_ways(lambda t, way: 0.0)
    change(recording)
    with pytest.raises(IsoError, match=message) as caught:
        choose.results([recording], Options())
    assert caught.value.place.file == "ball.csv" and caught.value.place.line >= 1


def test_samples_beside_the_circle_and_gaps_are_said():
    recording = both_ways(lambda t, way: np.cos(2 * t))
    recording.columns["X_cmd_mm"][200:230] += 5
    found, result = values(recording)
    assert any("30 samples beside the commanded circle are left out" in n for n in result.notices)
    assert any("15.5 degrees apart" in n for n in result.notices)
    recording.columns["X_cmd_mm"][:30] += 5  # and a run-in: its 15 degrees are missing
    found, result = values(recording)
    assert found["Gxy"] is None and any("an arc of 345 degrees" in n for n in result.notices)
    few = ballbar([(1, 0, 360, lambda t, w: 0.0), (1, 0, 5, lambda t, w: 9.0)])
    assert any("run 2 has 10 samples only" in n for n in values(few)[1].notices)


def test_terms_of_a_circle_by_hand():
    """G, H: differences of two readings; F, D: one reading, and the expansion over the radius (the
    bar is the standard)."""
    budget = Stated(device=0.2 * UM, alpha=11.5e-6, u_temperature=0.5, drift=1.2 * UM)
    (result,), _ = choose.results([both_ways(lambda t, way: np.cos(2 * t))], Options(budget=budget))
    # G: 2 sqrt((1.414 * 0.2)^2 + (1.2 / 3.464)^2) = 0.894; D, F: 2 sqrt(0.2^2 + 0.3464^2 + (11.5e-6
    # * 100 mm * 0.5 K = 0.575 um)^2) = 1.401.
    for name, u in (
        ("Gxy", 0.894),
        ("G(b)", 0.894),
        ("H", 0.894),
        ("D", 1.401),
        ("Fxy max", 1.401),
    ):
        assert result[name].U / UM == pytest.approx(u, abs=1e-3), name
