"""The page of a program: its path, what is off before and after, where, and which lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from postproc.errors import Notice
from postproc.filter import Filter
from postproc.machine.lacks import lacks
from postproc.machine.uncertainty import micrometres
from postproc.pages import charts
from postproc.pages.frame import Page
from postproc.trace import CLASSES, Places, Trace
from postproc.units import UM
from postproc.verify import Verifier

LATHE = (("Z", "X"), ("X", "Y"), ("Z", "Y"))
MILL = (("X", "Y"), ("X", "Z"), ("Y", "Z"))
FLAT = 0.02  # of the longest extent: a plane in which the path is no longer than that shows nothing
SOLID = 0.25  # of the longest extent: a path whose cuts are that high is first shown in space
SHARE = 0.06  # of the longest extent, as which the largest error is drawn
STEPS = 18  # of the slider: 1, 2, 5, ... a million
NOTHING = 1e-9  # mm: what arithmetic leaves
EVEN = 8.0  # times: more than that between before and after asks for logarithmic steps


def page(filter_: Filter, verifier: Verifier, why: str = "") -> Page:
    """The page of a program that was corrected and verified, with the verifier's trace. why: that
    it was written out."""
    trace = verifier.trace
    assert trace is not None
    before, after = trace.before.places(), trace.after.places()
    result = Page(
        f"{Path(filter_.name).name} on {filter_.machine.name}",
        _headline(verifier),
        _mood(verifier),
        scripts=("program.js",),
    )
    summary = filter_.summary
    result.subject = [
        ("program", filter_.name), ("machine", filter_.machine.title),
        ("map", filter_.machine.digest), ("read as", filter_.dialect.name),
        ("lines", f"{summary.lines:,}"), ("motions", f"{summary.motions:,}"),
        ("path", f"{trace.length:,.0f} mm"),
    ]  # fmt: skip
    _tiles(result, filter_, verifier, trace)
    if why:
        result.text(f"The program was {why}.")
    if not len(after):
        result.section(
            "Path",
            "The machine's map is zero everywhere: the tool is where the program puts it, and there"
            " is nothing to draw."
            if filter_.machine.is_zero
            else "No place of this program is known to the map, so there is nothing to draw.",
        )
    else:
        _path(result, trace, verifier, before, after)
        _along(result, trace, verifier, before, after)
        _histogram(result, trace, verifier)
        _worst(result, trace)
    _add_notices(result, filter_, verifier)
    return result


def _mood(verifier: Verifier) -> str:
    """Of the headline: what was not looked at is neither good nor bad."""
    if verifier.blind:
        return "open"
    return "good" if verifier.passed else "bad"


def _headline(verifier: Verifier) -> str:
    after, before = verifier.corrected, verifier.uncorrected
    said = (
        "Replayed on the machine's model, the corrected program stays within"
        f" {after.deviation / UM:.2f} um of its nominal path (worst in line {after.line}); as it"
        f" was it would be up to {before.deviation / UM:.1f} um off (line {before.line})."
    )
    if verifier.blind:
        said = "Nothing was compared: no place of the path is known in all of its axes."
    elif max(before.deviation, after.deviation) < NOTHING:
        said = "The map has no error where this program goes: nothing is changed."
    return said if verifier.passed else f"NOT WITHIN THE TOLERANCE. {said}"


def _tiles(result: Page, filter_: Filter, verifier: Verifier, trace: Trace) -> None:
    summary, known = filter_.summary, verifier.map
    before, after = verifier.uncorrected.deviation / UM, verifier.corrected.deviation / UM
    unknown = "not known"
    tiles = [
        (
            unknown if verifier.blind else f"{before:.1f} um",
            "largest deviation, not corrected",
            "before",
        ),
        (unknown if verifier.blind else f"{after:.2f} um", "largest deviation, corrected", "after"),
        (f"{verifier.tolerance / UM:g} um", f"tolerance asked for{_beyond(verifier)}", ""),
        (f"{summary.largest / UM:.1f} um", "largest correction of an axis", "command"),
        (
            f"{summary.added:,}",
            "blocks added: "
            + counted(trace.take_ups, "take-up")
            + " of lost motion, "
            + counted(trace.cuts, "cut"),
            "",
        ),
    ]
    if known.known.parts and known.line:
        tiles.append(
            (
                f"+- {micrometres(known.largest)} um",
                "how well the map itself is known on this path (95 %)",
                "",
            )
        )
    else:
        tiles.append(("not stated", "how well the map itself is known", ""))
    result.tiles(*tiles)


def counted(number: int, what: str) -> str:
    """ "1 cut", "2 cuts"."""
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def _beyond(verifier: Verifier) -> str:
    """What a take-up of lost motion may cost besides, where slides have any."""
    if not verifier.follows:
        return ""
    return f"; {verifier.allowed / UM:.2g} um are allowed where lost motion is taken up"


# -- the path --------------------------------------------------------------------------------------


def views(letters: tuple[str, ...], points: np.ndarray, lathe: bool) -> list[str]:
    """Planes in which a path (A, N) may be looked at, the best first; in space where there are
    three slides."""
    extent = {x: float(np.ptp(points[k])) for k, x in enumerate(letters) if x in "XYZ"}
    known = LATHE if lathe else MILL
    planes = [f"{a} {b}" for a, b in known if {a, b} <= extent.keys()]
    longest = max(extent.values(), default=0.0)
    # stable: of planes that show as much the usual one stays first
    planes.sort(key=lambda p: sum(extent[x] <= FLAT * longest for x in p.split()))
    if not planes:  # a single slide is drawn over itself
        only = next(iter(extent), letters[0])
        planes = [f"{only} {only}"]
    if len(extent) < 3:
        return planes
    return ["3D", *planes] if min(extent.values()) > SOLID * longest else [*planes, "3D"]


def magnified(extent: float, error: float) -> int:
    """The slider's step at which the largest error is some hundredths of the extent."""
    wanted = SHARE * extent / max(error, 1e-6)
    # 1 2 5 10 ... 1,000,000, as the slider has them; nearest on a logarithmic scale
    steps = [m * 10.0**d for d in range(7) for m in (1, 2, 5)][: STEPS + 1]
    return int(np.argmin([abs(np.log(s / max(wanted, 1e-9))) for s in steps]))


def _series(places: Places) -> dict[str, Any]:
    return {
        "s": charts.column(places.s, 2),
        "p": [charts.column(row, 4) for row in places.point],
        "off": [charts.um(row) for row in places.off],
        "cmd": [charts.um(row) for row in places.command],
        "d": charts.um(places.distance),
        "c": charts.um(np.sqrt((places.command**2).sum(axis=0))),
        "u": charts.um(places.u),
        "line": places.line.tolist(),
        "plain": places.plain.tolist(),
        "feed": places.feed.astype(int).tolist(),
    }


def _path(result: Page, trace: Trace, verifier: Verifier, before: Places, after: Places) -> None:
    letters = trace.machine.letters
    slides = [k for k, x in enumerate(letters) if x not in trace.machine.chain.rotary]
    extent = max((float(np.ptp(after.point[k])) for k in slides), default=0.0)
    known = bool(verifier.map.known.parts)
    colours = [
        ("before", "deviation, not corrected"),
        ("after", "deviation left"),
        ("correction", "correction"),
    ]
    if known:
        colours.append(("u", "uncertainty of the map"))
    wanted = {*before.plain.tolist(), *after.plain.tolist()}
    cuts = after.point[:, after.feed] if after.feed.any() else after.point
    shown = views(letters, cuts, bool(trace.machine.diameter))
    result.data["path"] = {
        "axes": letters,
        "views": shown,
        "before": _series(before),
        "after": _series(after),
        "known": known,
        "thinned": max(trace.before.step, trace.after.step) > 2,
        "magnify": magnified(extent or 1.0, float(np.abs(before.off).max(initial=0.0))),
        "text": {
            str(n): [own, list(became)] for n, (own, became) in trace.text.items() if n in wanted
        },
    }
    note = f" Of each {trace.after.step:,} places measured the one farthest off is drawn." * (
        trace.after.step > 1
    )
    result.section("Path")
    result.blocks.append({
        "kind": "path", "views": shown, "colours": colours, "height": 520,
        "caption": "The path in machine coordinates, slide positions"
        + (" (X as radius)" if trace.machine.diameter else "")
        + ". Errors are drawn larger than they are, so that they can be seen." + note,
    })  # fmt: skip


# -- figures ---------------------------------------------------------------------------------------


def _along(result: Page, trace: Trace, verifier: Verifier, before: Places, after: Places) -> None:
    data = []
    if verifier.map.known.parts:
        s, u = charts.column(after.s, 2), charts.um(after.u)
        data.append(charts.band(s, [0.0] * len(s), u, "uncertainty of the map (95 %)", "u"))
    for places, name, role in ((before, "not corrected", "before"), (after, "corrected", "after")):
        size = np.maximum(places.distance, 1e-6)  # a logarithm has no zero
        data.append(charts.line(
            charts.column(places.s, 2), charts.um(size), name, role,
            customdata=places.line.tolist(), width=1.2,
            hovertemplate="line %{customdata}, %{x:.1f} mm: %{y:.2f} um<extra></extra>",
        ))  # fmt: skip
    if trace.turns:
        at, lines = zip(*trace.turns, strict=True)
        data.append(charts.dots(
            charts.column(at, 2), [verifier.tolerance / UM] * len(at), "lost motion taken up",
            "mark", size=7, symbol="triangle-up", customdata=list(lines),
            hovertemplate="line %{customdata}: take-up<extra></extra>",
        ))  # fmt: skip
    data.append(charts.line(
        [0, round(trace.length, 2)], [verifier.tolerance / UM] * 2, "tolerance", "limit",
        dash="dash", width=1.2, hoverinfo="skip",
    ))  # fmt: skip
    log = verifier.uncorrected.deviation > EVEN * max(verifier.corrected.deviation, 1e-9)
    result.section("Deviation along the path")
    result.figure(charts.figure(
        "along",
        "Distance of the actual from the nominal path, along the path. A click shows the line.",
        data, "path, mm", "deviation, um", 360, log=log,
        xaxis={"range": charts.reach([0.0, round(trace.length, 2)])},
    ))  # fmt: skip


def _histogram(result: Page, trace: Trace, verifier: Verifier) -> None:
    """Path by size of its deviation; classes are even on a logarithmic scale."""
    counts = trace.histogram
    used = np.flatnonzero(counts["before"] + counts["after"])
    if not len(used):
        return
    low, high = max(int(used[0]), 1), min(int(used[-1]), len(CLASSES) - 1)
    middle = np.round(
        np.log10(np.sqrt(CLASSES[low - 1 : high] * CLASSES[low : high + 1]) / UM), 3
    ).tolist()
    whole = max(float(counts["after"].sum()), 1e-9)
    data, top = [], 1.0
    for name, said, role in (
        ("before", "not corrected", "before"),
        ("after", "corrected", "after"),
    ):
        own = 100 * counts[name][low : high + 1] / whole
        # what is smaller or larger than the classes that are drawn counts with the first and the
        # last
        own[0] += 100 * counts[name][:low].sum() / whole
        own[-1] += 100 * counts[name][high + 1 :].sum() / whole
        sizes = [f"{10**x:.2g} um" for x in middle]
        data.append(charts.bars(
            middle, charts.column(own, 2), said, role, opacity=0.75, width=0.09, customdata=sizes,
            hovertemplate="about %{customdata}: %{y:.1f} % of the path<extra></extra>",
        ))  # fmt: skip
        top = max(top, float(own.max()))
    at = round(float(np.log10(verifier.tolerance / UM)), 3)
    data.append(
        charts.line(
            [at, at], [0, round(top, 2)], "tolerance", "limit", dash="dash", hoverinfo="skip"
        )
    )
    powers = range(int(np.floor(min(*middle, at))), int(np.ceil(max(*middle, at))) + 1)
    result.section("How much of the path is off by how much")
    result.figure(
        charts.figure(
            "histogram",
            "Share of the cutting path by the size of its deviation, ten classes for each power of"
            " ten.",
            data,
            "deviation, um",
            "path, %",
            300,
            barmode="overlay",
            bargap=0.05,
            xaxis={"tickvals": list(powers), "ticktext": [f"{10.0**k:g}" for k in powers]},
        )
    )


def _worst(result: Page, trace: Trace) -> None:
    rows = []
    for worst in trace.worst():
        own, became = trace.text.get(worst.plain, ("", ()))
        rows.append(
            (
                worst.line,
                f"{worst.before / UM:.2f}",
                f"{worst.after / UM:.2f}",
                own,
                "\n".join(became) or "the same",
            )
        )
    result.section("Lines that stay farthest off")
    result.table(
        ("line", ">not corrected, um", ">corrected, um", "block", "what it became"),
        rows,
        code=(3, 4),
        pick=True,
    )


def _add_notices(result: Page, filter_: Filter, verifier: Verifier) -> None:
    result.section("What a person should know", f"Verified: {verifier.report()}.")
    result.listing([_notice(n) for n in filter_.notices])
    if lacking := lacks(filter_.compensator.machine):
        result.section("Not in the map", "The correction can not know of:")
        result.listing(lacking)


def _notice(notice: Notice) -> str:
    return notice.message + (f" (first in line {notice.line})" if notice.line else "")
