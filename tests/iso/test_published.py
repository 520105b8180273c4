"""ISO 230-2 figures of a published report beside ours: all readings and all results stand in the
report, so every figure can be compared.

The report is written by the Paul Scherrer Institute's ecmc (repository
paulscherrerinstitute/ecmccfg, examples/test/fat_sat/report.md, 8 Dec 2023: a stage read by an
encoder). It prints what it calls E as that of the forward direction alone, and R as the larger of
both directions. The standard's own E and R are compared with sums of the printed means and s.
"""

from __future__ import annotations

import numpy as np
import pytest

from postproc.iso.positioning import evaluate

TARGETS = {"psi": [-10.0, -4.88, 0.24, 5.36, 10.48]}
UP = {
    "psi": [
        [-10.00008102, -10.00010202, -10.00008702, -10.00009202, -10.00010002],
        [-4.88008702, -4.88009702, -4.88009702, -4.88009502, -4.88008202],
        [0.23992798, 0.23990998, 0.23991198, 0.23991298, 0.23991298],
        [5.35989798, 5.35991398, 5.35991398, 5.35990698, 5.35992198],
        [10.47989998, 10.47988798, 10.47987098, 10.47989098, 10.47990298],
    ],
}
DOWN = {
    "psi": [
        [-10.00009902, -10.00009402, -10.00008202, -10.00009102, -10.00009402],
        [-4.88010302, -4.88010402, -4.88009502, -4.88011102, -4.88009302],
        [0.23991398, 0.23989798, 0.23990898, 0.23992398, 0.23990098],
        [5.35992798, 5.35990798, 5.35990498, 5.35989698, 5.35991898],
        [10.47989598, 10.47987398, 10.47986998, 10.47985898, 10.47989298],
    ],
}
PRINTED = {  # mm, as the report prints them, and half of their last digit
    "psi": (
        {
            "B": 1.22e-5,
            "M": 2.77e-5,
            "E+": 2.46e-5,
            "E-": 3.3e-5,
            "R+": 5.033e-5,
            "R-": 6.29e-5,
            "A+": 6.428e-5,
            "A-": 8.881e-5,
            "A": 8.881e-5,
        },
        5.1e-9,
    ),
}
# largest R of a target, and extremes of the printed means: what the standard calls R and E
OF_TARGETS = {
    "psi": (6.882e-5, -8.482e-5, -12.162e-5),
}


def ours(name: str):
    at, up, down = (np.array(v[name]) for v in (TARGETS, UP, DOWN))
    n = up.shape[1]
    position = np.repeat(at, n)
    reading = np.concatenate([(v - at[:, None]).ravel() for v in (up, down)])
    approach = np.repeat([1.0, -1.0], position.size)
    return evaluate(
        np.tile(position, 2), approach, reading, np.tile(np.arange(n) + 1.0, 2 * len(at))
    )


@pytest.mark.parametrize(
    ("name", "figure"), [(n, f) for n, (printed, _) in PRINTED.items() for f in printed]
)
def test_a_figure_is_the_printed_one(name, figure):
    printed, digit = PRINTED[name]
    assert ours(name).values[figure] == pytest.approx(printed[figure], abs=digit)


@pytest.mark.parametrize("name", OF_TARGETS)
def test_what_the_report_names_otherwise(name):
    """E is the range of all means, R the largest R of a target (ISO 230-2:2014, 2.21 and 2.18)."""
    largest, high, low = OF_TARGETS[name]
    values, digit = ours(name).values, PRINTED[name][1]
    assert values["R"] == pytest.approx(largest, abs=digit)
    assert values["E"] == pytest.approx(high - low, abs=2 * digit)


def test_deviations_beside_the_printed_ones():
    """All figures of the report: none differs by more than what is printed tells."""
    worst = max(
        abs(ours(n).values[f] - v) / digit
        for n, (printed, digit) in PRINTED.items()
        for f, v in printed.items()
    )
    assert worst <= 1.0
