"""The page of tests by the ISO 230 series: each with its figure, its parameters and their
uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

from postproc.iso import Result
from postproc.iso.causes import Causes
from postproc.iso.drift import Drift
from postproc.iso.positioning import Positioning
from postproc.iso.straightness import Straightness
from postproc.pages import charts
from postproc.pages.frame import Page
from postproc.pages.measured_figures import along, at_rest, circle, shown
from postproc.units import UM

LEAST = 0.005  # of the sum: a cause of less is not drawn


def _figure(result: Result, name: str) -> charts.Figure | None:
    """What was read; None: there is no figure of such a test."""
    if isinstance(result.detail, Positioning | Straightness):
        return along(result, name)
    if isinstance(result.detail, list) and result.detail:
        return circle(result, name)
    return at_rest(result, name) if isinstance(result.detail, Drift) else None


def page(results: Sequence[Result], left: Sequence[str] = ()) -> Page:
    """The page of some results. left: what was not evaluated."""
    files = sorted({name for r in results for name in r.files})
    title = f"{', '.join(dict.fromkeys(r.subject for r in results))} by ISO 230"
    made = Page(
        title if len(title) < 90 else f"{len(results)} tests by ISO 230", _headline(results)
    )
    made.subject = [("recordings", ", ".join(files))]
    for k, result in enumerate(results):
        chosen = f"{result.chosen[:1].upper()}{result.chosen[1:]}."
        made.section(f"{result.subject}: {result.test}, {result.standard}", chosen)
        if figure := _figure(result, f"test-{k}"):
            made.figure(figure)
        if result.causes:
            _causes(made, result.causes, f"test-{k}-causes")
        _parameters(made, result)
        made.listing([f"{text}." for text in result.notices])
    if left:
        made.section("Left out")
        made.listing(list(left))
    return made


def _headline(results: Sequence[Result]) -> str:
    """The first parameter of each of the first tests."""
    said = []
    for result in results[:4]:
        main = next((p for p in result.parameters if p.value is not None), None)
        if main is not None:
            u = "" if main.U is None else f" +- {shown(result, main.U)}"
            size = f"{shown(result, main.value)}{u} {result.unit}"
            said.append(f"{result.subject}: {main.means} ({main.name}) {size}")
    return "; ".join(said) + (f"; and {len(results) - 4} more." if len(results) > 4 else ".")


def _parameters(made: Page, result: Result) -> None:
    rows = [
        (
            p.name,
            shown(result, p.value),
            shown(result, p.U),
            shown(result, p.runs),
            p.means + (f", {p.at}" if p.at else ""),
        )
        for p in result.parameters
    ]
    made.table(("", f">{result.unit}", ">U (k = 2)", ">of it runs", "what it is"), rows)
    if result.terms:
        made.text("In U, k = 1:")
        made.listing(
            [f"{t.name}: {shown(result, t.u)} {result.unit}; {t.said}" for t in result.terms]
        )


def _causes(made: Page, causes: Causes, name: str) -> None:
    """What makes a circle out of round, ranked."""
    shown = [c for c in causes.ranked if c.share >= LEAST]
    said = (
        f"{causes.whole / UM:.2f} um rms beside the set-up, {causes.left / UM:.2f} um rms that none"
        " of these explains"
    )
    # a cause is told from none where its range is beyond its U (95 %)
    roles = ["@command" if c.range > c.U_range else "@still" for c in shown]
    bars = charts.lying(
        name,
        "What makes it out of round, of each cause alone, with U (95 %); grey: not significant;"
        f" {said}.",
        [c.name for c in shown],
        [("range round the circle", "command", [c.range / UM for c in shown])],
        "um",
        error_x=charts.limits(charts.um([c.U_range for c in shown], 2)),
        marker={"color": roles},
        text=None,
    )
    made.figure(bars)
    rows = [
        (
            c.name,
            f"{c.range / UM:.2f}",
            f"{c.U_range / UM:.2f}",
            f"{100 * c.share:.0f}",
            f"{c.size:+.4g} {c.unit}",
            f"{c.U:.2g} {c.unit}",
            c.positive,
        )
        for c in causes.ranked
    ]
    made.table(
        (
            "cause",
            ">um",
            ">U (95 %)",
            ">% of the sum",
            ">its size",
            ">U (95 %)",
            "above zero it means",
        ),
        rows,
    )
