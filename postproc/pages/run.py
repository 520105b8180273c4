"""The page of a job that was sent to a controller: how it ended, how it went on, what was refused,
what happened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from postproc.pages import charts
from postproc.pages.frame import Page

MOST = 200  # refused lines, and events, that are listed

FREE = "Blocks that are free in the controller's planner: at zero it has as much as it can hold."
BUFFER = "Bytes in the controller's receive buffer, as they are counted here."


def page(fields: dict[str, Any], samples: list[dict[str, Any]], ended: str = "") -> Page:
    """The page of a job. fields: what gcomp-run/1 holds; samples: states while it ran, in the order
    of time; ended: how it ended, as a person is told, with what is certain and the way out."""
    good = fields["outcome"] == "done"
    first, *rest = (ended or fields["message"]).splitlines()
    first = f"{first[:1].upper()}{first[1:]}"
    made = Page(
        f"{Path(fields['program']).name} on {fields['machine']}: {fields['outcome']}",
        f"{first}.",
        "good" if good else "bad",
    )
    made.subject = [
        ("program", fields["program"]),
        ("controller", fields["controller"]), ("map", fields["map"]), ("ended", fields["ended"]),
        ("sha256 of the program", fields["sha256"] or "not known: it came from a pipe"),
    ]  # fmt: skip
    made.listing([line.strip() for line in rest])
    made.tiles(*_tiles(fields))
    _course(made, fields, samples)
    if fields["refused"]:
        made.section("Refused by the controller")
        made.table(
            ("line", "text", "its words"),
            [(r["source_line"], r["text"], r["words"]) for r in fields["refused"][:MOST]],
            code=(1,),
        )
    if fields["events"]:
        made.section("What happened")
        made.table(
            (">s", "event", ""),
            [(f"{e['s']:.1f}", e["event"], e["message"]) for e in fields["events"][:MOST]],
        )
    return made


def _tiles(fields: dict[str, Any]) -> list[tuple[str, str, str]]:
    tiles = [(_minutes(fields["seconds"]), "it took", "")]
    if fields["expected_s"] is not None:
        tiles.append(
            (_minutes(fields["expected_s"]), "was expected, by the controller's settings", "")
        )
    if fields["held_s"]:
        tiles.append((_minutes(fields["held_s"]), "of it on hold", "open"))
    total = f" of {fields['lines']:,}" if fields["lines"] else ""
    tiles += [
        (f"{fields['executed']:,}{total}", "lines are surely over", ""),
        (f"{fields['answered']:,}", "lines answered", ""),
        (f"{len(fields['refused']):,}", "lines refused", "bad" if fields["refused"] else ""),
        (f"{fields['bytes']:,}", "bytes sent", ""),
    ]
    return tiles


def _minutes(seconds: float) -> str:
    minutes, rest = divmod(round(seconds, 1), 60)
    return f"{minutes:.0f} min {rest:.0f} s" if minutes else f"{rest:.1f} s"


def _course(made: Page, fields: dict[str, Any], samples: list[dict[str, Any]]) -> None:
    """Lines, feed and buffers over the time, with what happened marked."""
    if len(samples) < 2:
        return
    made.section("How it went on")
    t = [s["elapsed_s"] for s in samples]
    over = max(fields["seconds"], t[-1])  # what the last report could not know yet
    lines = [
        charts.line(
            [*t, over], [*(s[key] for s in samples), fields.get(key, samples[-1][key])], name, role
        )
        for key, name, role in (
            ("sent", "sent", "nominal"),
            ("answered", "answered", "command"),
            ("executed", "surely over", "after"),
        )
    ]
    marks = [e for e in fields["events"] if e["s"] <= t[-1] + 1][:MOST]
    lines.append(charts.dots(
        [e["s"] for e in marks], [0] * len(marks), "events", "limit", size=8, symbol="triangle-up",
        text=[e["message"] for e in marks], hovertemplate="%{x} s: %{text}<extra></extra>",
    ))  # fmt: skip
    made.figure(
        charts.figure("lines", "Lines of the job over the time.", lines, "time, s", "lines", 320)
    )
    _gauges(made, t, samples)


def _gauges(made: Page, t: list[float], samples: list[dict[str, Any]]) -> None:
    """Feed and buffers over the time, where the controller reports them."""
    for key, unit, said in (
        ("feed_mm_min", "mm/min", "Feed as the controller reports it."),
        ("planner_free", "blocks", FREE),
        ("buffer_bytes", "bytes", BUFFER),
    ):
        values = [s.get(key) for s in samples]
        if any(v is not None for v in values):
            made.figure(charts.figure(
                key, said, [charts.line(t, values, key, "command")], "time, s", unit, 240,
                showlegend=False, yaxis={"rangemode": "tozero"},
            ))  # fmt: skip
