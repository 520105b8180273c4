"""The page of an acceptance: each line of targets before and after compensation, and whether every
sign is right."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from postproc.accept import VERDICTS, Change, Outcome, report
from postproc.iso import Parameter
from postproc.pages import charts
from postproc.pages.frame import Page

CURVES = (
    ("before +", "before", "solid"),
    ("before -", "before", "dash"),
    ("after +", "after", "solid"),
    ("after -", "after", "dash"),
)
MOODS = {"turned": "bad", "too much": "bad", "nothing": "open", "between": "open"}


def page(outcomes: Sequence[Outcome], machine: str) -> Page:
    """The page of all pairs of measurements."""
    said = report.verdict(outcomes, machine)
    of = f" of {machine}" if machine else ""
    made = Page(
        f"Acceptance{of}: before and after compensation",
        f"{said[0][:1].upper()}{said[0][1:]}.",
        mood(outcomes),
    )
    made.subject = [("lines of targets", ", ".join(dict.fromkeys(o.subject for o in outcomes)))]
    if machine:
        made.subject.insert(0, ("machine", machine))
    made.listing([f"{text}." for text in said[1:]])
    made.tiles(*_tiles(outcomes))
    for k, one in enumerate(outcomes):
        _outcome(made, k, one)
    return made


def mood(outcomes: Sequence[Outcome]) -> str:
    """bad, open, or good: the colour of the headline. Good wants a sign that was told."""
    verdicts = {r.verdict for one in outcomes for r in one.ratios}
    moods = {MOODS[v] for v in verdicts if v in MOODS}
    if "bad" in moods:
        return "bad"
    # nothing bad is not enough: readings that tell no sign tell nothing good of it, too
    return "good" if "good" in verdicts and not moods else "open"


def _tiles(outcomes: Sequence[Outcome]) -> Iterator[tuple[str, str, str]]:
    """The first parameter of each line of targets, before and after."""
    for one in outcomes[:6]:
        change = next(
            (c for c in one.changes if c.before.value is not None and c.after.value is not None),
            None,
        )
        if change is not None:
            unit = report.unit_of(one)
            before, after = (report.number(p.value, unit) for p in (change.before, change.after))
            yield (
                (
                    f"{before} to {after} {one.unit}",
                    f"{change.before.means} of {one.subject}, before and after",
                    "after",
                )
            )


def _outcome(made: Page, k: int, one: Outcome) -> None:
    made.section(
        f"{one.subject}: {one.before.test}",
        f"{one.before.recording.file} -> {one.after.recording.file}",
    )
    made.figure(_curves(k, one))
    made.figure(_bars(k, one))
    unit = report.unit_of(one)
    rows = [
        (
            c.before.name,
            report.number(c.before.value, unit),
            report.number(c.before.U, unit),
            report.number(c.after.value, unit),
            report.number(c.after.U, unit),
            report.reduction(c),
            c.before.means,
        )
        for c in one.changes
    ]
    made.table(
        (
            "",
            f">before, {one.unit}",
            ">U (k = 2)",
            f">after, {one.unit}",
            ">U (k = 2)",
            ">less by",
            "what it is",
        ),
        rows,
    )
    made.table(
        ("sign", "what is left of it", ""),
        [(r.of, report.ratio(r), VERDICTS[r.verdict]) for r in one.ratios],
    )
    made.listing([*report.rest(one, unit), *one.notices])


def _curves(k: int, one: Outcome) -> charts.Figure:
    """Means over the targets, about their own mean."""
    unit, name = report.unit_of(one), one.subject.partition(",")[0]
    letter = name[2] if len(name) == 3 and name[0] == "E" else name
    x = charts.column([v for v in one.curves["target"] if v is not None], 4)
    data = []
    for name, role, dash in CURVES:
        values = [None if v is None else round(v / unit, 3) for v in one.curves[name]]
        if set(values) - {None}:
            moment, sign = name.split()
            data.append(charts.line(
                x, values, f"{moment}, approached in {sign}", role, dash=dash, mode="lines+markers",
                marker={"size": 4, "color": f"@{role}"},
                hovertemplate=f"%{{x}}: %{{y:.2f}} {one.unit}<extra></extra>",
            ))  # fmt: skip
    along = "degrees" if one.before.test == "rotary" else "mm"
    return charts.figure(
        f"curves-{k}",
        "Means of the runs at each target, actual - commanded by the nominal program, about their"
        " own mean.",
        data,
        f"{letter}, {along}",
        f"deviation, {one.unit}",
        360,
        xaxis={"range": charts.reach(x)},
    )


def _bars(k: int, one: Outcome) -> charts.Figure:
    """Parameters before and after, with U."""
    unit = report.unit_of(one)
    shown = [c for c in one.changes if c.before.value is not None and c.after.value is not None]
    data = [
        _with_u([(c, c.before) for c in shown], "before", unit),
        _with_u([(c, c.after) for c in shown], "after", unit),
    ]
    return charts.figure(
        f"parameters-{k}", "Parameters before and after, with U (95 %) where it is known.", data,
        "", one.unit, 280, yaxis={"rangemode": "tozero"},
    )  # fmt: skip


def _with_u(shown: list[tuple[Change, Parameter]], role: str, unit: float) -> charts.Trace:
    u = [0.0 if p.U is None else p.U / unit for _, p in shown]
    return charts.bars(
        [c.before.name for c, _ in shown],
        charts.column([(p.value or 0.0) / unit for _, p in shown], 3), role, role,
        error_y=charts.limits(charts.column(u, 3)), hovertemplate="%{x}: %{y:.2f}<extra></extra>",
    )  # fmt: skip
