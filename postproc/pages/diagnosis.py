"""The page of a diagnosis: first what is left, drawn; then what was found, how sure its names are,
and what to do."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from postproc.diagnose import machine_effects, prose, words
from postproc.diagnose.answer import Diagnosis, Finding
from postproc.diagnose.summary import fit_of, next_test
from postproc.pages import charts, circles, findings, left
from postproc.pages.frame import Page

MOST = 6  # signals that are drawn; the others have a line


def page(d: Diagnosis, written: str = "", accept: tuple[str, ...] = ()) -> Page:
    """The page of a diagnosis. written: the folder of the machine that was written with it; accept:
    names that went into it by --accept."""
    mood = {"nothing-left-out": "good", "left-out-physics": "bad", "unknown": "open"}[d.verdict]
    made = Page(
        f"Diagnosis of {d.machine.name}", prose.headline(d), "open" if d.disagreements else mood
    )
    made.subject = [
        ("machine", d.machine.title or d.machine.name),
        ("map", d.machine.digest),
        ("readings", f"{len(d.rows):,}"),
        ("recordings", ", ".join(Path(r.file).name for r in d.recordings)),
    ]
    drawn = left.signals(d)
    rounds = list(circles.of_diagnosis(d))
    _first(made, d, drawn, rounds)
    _tiles(made, d)
    _listing(made, "In doubt", [f"{text}." for text in d.disagreements])
    _found(made, d)
    _listing(made, "Where it stands out", [f"{prose.where(d, place)}." for place in d.places])
    _not_named(made, d)
    made.section("Shown on what took no part", f"{_upper(prose.held_out_words(d))}.")
    if d.held.any():
        made.figure(findings.held_out(d))
    _listing(made, "What to do next", list(map(_upper, prose.next_steps(d, written))))
    _written(made, d, accept)
    _others(made, d, drawn[1:], rounds[1:])
    _limits(made, d)
    return made


def _listing(made: Page, title: str, lines: list[str]) -> None:
    """A section of lines, where there are any."""
    if lines:
        made.section(title)
        made.listing(lines)


def _upper(text: str) -> str:
    """As a sentence begins; a name that other programs know (screw_heat:Z, --accept) stays."""
    return text if re.match(r"\w+(_|:\w)", text) else text[:1].upper() + text[1:]


def _first(made: Page, d: Diagnosis, drawn: list[int], rounds: list[charts.Figure]) -> None:
    """The figure that is seen first: circles, else the signal with the largest mismatch, else
    features of parts."""
    if rounds:
        made.figure(rounds[0])
    if drawn:
        made.figures(*left.of_signal(d, drawn[0]))
    if np.any(d.rows.sees == "part"):
        made.figure(findings.features(d))


def _tiles(made: Page, d: Diagnosis) -> None:
    fit = fit_of(d)
    found = sum(f.status == "accepted" for f in d.findings)
    tiles = [(str(found), f"effect{'s' * (found != 1)} found", "")]
    if fit["held_out"]:
        tiles += [
            (
                f"{fit['rms_before_um']:.2f} um",
                f"rms by the machine's file, {fit['held_out']}, which took no part",
                "before",
            ),
            (f"{fit['rms_after_um']:.2f} um", "with the effects found", "after"),
            (f"{fit['noise_floor_um']:.2f} um", "noise of a single reading", ""),
            (f"{100 * fit['coverage95']:.0f} %", "of them lie within their 95 % limits", ""),
        ]
    made.tiles(*tiles)


def _found(made: Page, d: Diagnosis) -> None:
    """Causes, ranked; then each by itself."""
    if not d.findings:
        return
    made.section("What was found")
    rows = [
        (n, f"{size:.2f}", f"{wide:.1f}", f"{100 * share:.0f}")
        for n, size, wide, share in findings.ranked(d)
    ]
    made.table(("cause", ">rms, um", ">range, um", ">share, %"), rows)
    made.figure(findings.shares(d))
    if (figure := findings.names(d)) is not None:
        made.figure(figure)
    for k, f in enumerate(d.findings):
        _finding(made, d, k, f)


def _finding(made: Page, d: Diagnosis, k: int, f: Finding) -> None:
    made.section(f"{_upper(f.status)}: {words.named(f.block.key)}")
    if (figure := left.of_finding(d, k)) is not None:
        made.figure(figure)
    made.text(f"{_upper(prose.kind(f))}. {f.text or f.block.module.TEXT}")
    made.table(("size", "sure", "what it is"), prose.sizes(d, f))
    made.text(f"{_upper(prose.worth(d, f))}.")
    if f.equivalent:
        made.text(
            f"{words.named(f.block.key)} is not told apart from:"
            f" {', '.join(map(words.named, f.equivalent))}.",
            f"To tell them apart: {next_test(d, f)}",
        )
    if len(f.names) > 1:
        rows = [(words.named(name), f"{100 * p:.0f}") for name, p in f.names.items()]
        made.table(("name, if it is one of these", ">probability, %"), rows)


def _not_named(made: Page, d: Diagnosis) -> None:
    if d.unknown:
        made.section("What no name explains", prose.unknown_words(d))
        if (figure := findings.unknown(d)) is not None:
            made.figure(figure)


def _written(made: Page, d: Diagnosis, accept: tuple[str, ...]) -> None:
    """What --write-machine would change."""
    if not any(f.status == "accepted" for f in d.findings):
        return
    figures = findings.written(d, accept)
    made.section("What the written machine would change")
    if not figures:
        made.text(
            "No correction of a program would change: no effect of the machine that the place"
            " decides is told apart and sized."
        )
    for figure in figures:
        made.figure(figure)
    made.listing([f"{_upper(text)}." for text in machine_effects.not_told_apart(d, accept)])


def _others(made: Page, d: Diagnosis, drawn: list[int], rounds: list[charts.Figure]) -> None:
    """The other signals."""
    if drawn or rounds:
        made.section("The other readings")
    for figure in rounds[:MOST]:
        made.figure(figure)
    for signal in drawn[:MOST]:
        made.figures(*left.of_signal(d, signal))
    made.listing(
        [f"{left.name(d, s)}: not drawn; --residuals writes its readings" for s in drawn[MOST:]]
    )
    for one in (one for one in d.drives if one.fitted):
        head, *terms = prose.drive_lines(one)
        made.text(head)
        made.listing([term.strip() for term in terms])


def _limits(made: Page, d: Diagnosis) -> None:
    if said := words.limits(d.limits):
        made.section("From which size on an effect would have been seen")
        made.table(
            ("from", "effects"), [tuple(part.split(": ", 1)) for part in said.split("; ") if part]
        )
    if d.blind:
        made.section("What these recordings can not show")
        made.table(("effects", "why"), words.by_reason(d.blind))
    if d.faults:
        made.section("Rows with faults")
        made.listing([text.removeprefix("DATA: ") for text in prose.faults(d)])
    if d.notices:
        made.section("Notes")
        made.listing([f"{text}." for text in d.notices])
