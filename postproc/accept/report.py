"""Before and after for a person, and as data (format gcomp-accept/1)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

from postproc.accept import VERDICTS, Change, Outcome, Ratio
from postproc.accept.signs import REVERSAL
from postproc.iso import Parameter
from postproc.units import UM, URAD

FORMAT = "gcomp-accept/1"


def _too_small(judged: list[tuple[Outcome, Ratio]]) -> list[str]:
    """Ratios that their U leaves open."""
    return [
        f"{one.subject} {r.of} ({ratio(r)})"
        for one, r in judged
        if r.verdict == "undecided" and r.U is not None
    ]


def verdict(outcomes: Sequence[Outcome], machine: str) -> list[str]:
    """What is to be done, the worst first."""
    lines = list(chain.from_iterable(map(_faults, outcomes)))
    judged = [(one, r) for one in outcomes for r in one.ratios]
    good = sum(r.verdict == "good" for _, r in judged)
    # "verified" may only be said where nothing was left open: one direction that could not be told
    # may be turned
    small = _too_small(judged)
    if not lines and good:
        lines.append(f"all signs that can be told are right ({good} of {len(judged)})")
        if machine and not small:
            lines.append(
                f'signs = "verified" may stand in machine.toml of {machine}, if every component'
                " that it holds was measured here"
            )
    if small:
        lines.append(f"too small against the scatter to tell: {'; '.join(small)}")
    return lines or ["nothing here is large enough to judge a sign by"]


ADVICE = {
    "turned": "the correction is added where it has to be taken off",
    "too much": (
        "more was taken out than there was: corrected twice (a table of the control), or a radius"
        " taken for a diameter"
    ),
    "nothing": "was the corrected program the one that ran?",
    "between": "more runs, or part of the error is not in the map",
}


def _faults(one: Outcome) -> Iterator[str]:
    """A line for each kind of fault of one line of targets."""
    for kind, advice in ADVICE.items():
        if mine := [r for r in one.ratios if r.verdict == kind]:
            said = "; ".join(f"{r.of} {ratio(r)}" for r in mine)
            yield (
                f"{VERDICTS[kind]}: {one.subject}: {said};"
                f" {_turned(one) if kind == 'turned' else advice}"
            )


def _turned(one: Outcome) -> str:
    """The way out of a turned sign; with a machine also whether its map or the control has it."""
    if one.turned == [REVERSAL]:
        return (
            "forward and reverse are exchanged (--first when calibrating, the columns _fwd and"
            " _rev)"
        )
    # Both directions turned: either the map has the wrong sign and was obeyed (acted near 1: what
    # it says was taken out, and that made it worse), or the map is right and was added (acted near
    # -1).
    if len(one.turned) > 1 and one.acted is not None and one.acted > 0.5:
        return (
            "what the map says was taken out, so the map's own sign is turned: negate its column,"
            " or calibrate again"
        )
    if len(one.turned) > 1 and one.acted is not None and one.acted < -0.5:
        return (
            "the map has the right sign, and the control or the program uses it the other way round"
        )
    return ADVICE["turned"]


def text(outcomes: Sequence[Outcome], machine: str) -> str:
    """All of it."""
    parts = ["\n".join(_lines(one)) for one in outcomes]
    return "\n\n".join(
        [*parts, "\n".join(["verdict", *(f"  {line}" for line in verdict(outcomes, machine))])]
    )


def unit_of(one: Outcome) -> float:
    """mm or rad of one unit of what is shown."""
    return URAD if one.unit == "urad" else UM


def _lines(one: Outcome) -> list[str]:
    unit = unit_of(one)
    out = [
        f"{one.before.test}  {one.subject}",
        f"  {one.before.recording.file} -> {one.after.recording.file}",
        "",
    ]
    rows = [["", f"before, {one.unit}", "U (k=2)", "after", "U (k=2)", "less by", ""]]
    rows += [_row(change, unit) for change in one.changes]
    widths = [max(len(r[i]) for r in rows) for i in range(len(rows[0]))]
    for r in rows:
        cells = [
            c.ljust(w) if i in (0, 6) else c.rjust(w)
            for i, (c, w) in enumerate(zip(r, widths, strict=True))
        ]
        out.append(("  " + "  ".join(cells)).rstrip())
    out += ["", *(f"  {r.of}: {ratio(r)}: {VERDICTS[r.verdict]}" for r in one.ratios)]
    out += [f"  {line}" for line in rest(one, unit)]
    return out + [f"  note: {n}" for n in one.notices]


def _row(change: Change, unit: float) -> list[str]:
    shown = [
        number(v, unit)
        for v in (change.before.value, change.before.U, change.after.value, change.after.U)
    ]
    return [change.before.name, *shown, reduction(change), change.before.means]


def number(value: float | None, unit: float) -> str:
    """In this unit; -: it was not measured."""
    return "-" if value is None else f"{value / unit:.2f}"


def reduction(change: Change) -> str:
    """70 % (65 to 75), of the value before."""
    if change.reduction is None:
        return "-"
    if change.U is None:
        return f"{100 * change.reduction:.0f} %"
    low, high = 100 * (change.reduction - change.U), 100 * (change.reduction + change.U)
    return f"{100 * change.reduction:.0f} % ({low:.0f} to {high:.0f})"


def ratio(one: Ratio) -> str:
    """What of a deviation is there after, in words."""
    if one.U is None:
        return "no deviation to judge by"
    # + 0.0: no -0.00
    return f"{one.value + 0.0:.2f} +- {one.U:.2f} of it is there after"


def rest(one: Outcome, unit: float) -> list[str]:
    """How much of what is left the scatter of the runs makes, and what no map takes out."""
    out = [
        f"left: {one.left / unit:.2f} {one.unit} rms about"
        f" {'its line' if one.before.test == 'straightness' else 'its mean'}"
    ]
    if one.scatter is not None:
        # scatter and what is systematic are independent: their squares add up to what is left
        beyond = math.sqrt(max(one.left**2 - one.scatter**2, 0.0))
        out[0] += (
            f", of it {min(one.scatter, one.left) / unit:.2f} scatter of the runs and"
            f" {beyond / unit:.2f} systematic"
        )
    if one.repeat is not None:
        out.append(
            f"repeatability in one direction, up to {one.repeat / unit:.2f} {one.unit}, stays with"
            " any map"
        )
    if one.acted is not None:
        out.append(f"of what the map states {100 * one.acted:.0f} % was taken out")
    return out


def as_json(outcomes: Sequence[Outcome], machine: str) -> dict[str, Any]:
    """Numbers in the unit that `unit` names; null where not defined."""
    return {
        "format": FORMAT,
        "machine": machine or None,
        "verdict": verdict(outcomes, machine),
        "results": [_object(o) for o in outcomes],
    }


def _object(one: Outcome) -> dict[str, Any]:
    unit = unit_of(one)

    def sized(value: float | None) -> float | None:
        return None if value is None else value / unit

    def parameter(p: Parameter) -> dict[str, float | None]:
        return {"value": sized(p.value), "U": sized(p.U)}

    return {
        "test": one.before.test,
        "subject": one.subject,
        "unit": one.unit,
        "before": one.before.recording.file,
        "after": one.after.recording.file,
        "parameters": {
            c.before.name: {
                "before": parameter(c.before),
                "after": parameter(c.after),
                "reduction": c.reduction,
                "U_reduction": c.U,
            }
            for c in one.changes
        },
        "signs": [
            {"of": r.of, "ratio": r.value, "U": r.U, "rms": sized(r.size), "verdict": r.verdict}
            for r in one.ratios
        ],
        "taken_out_of_the_map": one.acted,
        "left_rms": sized(one.left),
        "scatter_rms": sized(one.scatter),
        "repeatability": sized(one.repeat),
        "notices": list(one.notices),
    }
