"""Which squareness a calibration has, and from what: a stated value, two straightnesses on one
reference, diagonals, circles.

A stated value goes first; what else the recordings say is compared with it and told. Two sources
never add up.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from postproc.calibrate import CalibrationError, Finding, Options, circles, opening, square
from postproc.calibrate.assign import Diagonal
from postproc.calibrate.component import Component
from postproc.calibrate.square import Squareness
from postproc.calibrate.statistics import cells_of
from postproc.errors import Place
from postproc.machine.chain import XYZ
from postproc.recordings import Recording
from postproc.units import UM, URAD

if TYPE_CHECKING:
    from postproc.calibrate.assign import Series
    from postproc.calibrate.calibration import Calibration

APART = 2.0  # combined standard uncertainties beyond which two sources contradict each other


def determine(calibration: Calibration) -> tuple[dict[str, Squareness], list[Finding]]:
    """Squareness by name. Raises CalibrationError for a source that is asked for and not there."""
    options = calibration.options
    axes = tuple(x for x in options.chain.axes if x in XYZ)
    found, findings = _found(calibration, axes)
    result: dict[str, Squareness] = {}
    for name, wanted in options.squareness.items():
        if not isinstance(wanted, str):
            result[name] = _stated(calibration, name, wanted)
            findings += _nowhere(calibration, result[name])
        else:
            result[name] = _wanted(name, wanted, found.get(name, {}))
    for name, sources in found.items():
        if name not in result:
            # one that states no u (a square whose own error is in it) is the last choice
            best = min(sources.values(), key=lambda s: np.inf if s.u is None else s.u)
            result[name] = best
        # told, never averaged: two sources that differ mean an error in one of them
        findings += _compare(result[name], sources)
    if options.keep_lines:
        findings += _counted_twice(calibration, result)
    return result, findings


def _stated(calibration: Calibration, name: str, wanted: tuple[float, float | None]) -> Squareness:
    """What the user says, brought from where the square stood to where the tables are zero."""
    value, u = wanted
    at = calibration.options.square_at
    if not at:
        return Squareness(name, value, u, "stated")
    # A square that stands where the tables are zero reads S, elsewhere S + opened: there the axis
    # that carries the other one is turned by its own angle.
    opened = opening.opened(calibration, name, at)
    known = [opening.known_to(calibration, name, at, x) for x in square.pair_of(name)]
    where = ", ".join(f"{x} = {v:g}" for x, v in at.items())
    remark = (
        f"{value / URAD:+.1f} urad was measured at {where}, where the axes' own angles make"
        f" {opened / URAD:+.1f} of it"
    )
    return Squareness(
        name,
        value - opened,
        None if u is None else float(np.hypot(u, np.linalg.norm(known))),
        "stated",
        remark,
    )


def _nowhere(calibration: Calibration, one: Squareness) -> list[Finding]:
    """A stated value without its place, where the place matters more than its u."""
    if calibration.options.square_at:
        return []
    most = opening.farthest(calibration, one.name)
    if most / URAD < max(0.05, (one.u or 0.0) / URAD):
        return []
    text = (
        f"{one.name} = {one.value / URAD:+.1f} urad is taken as measured where the tables are zero;"
        " where the square stood elsewhere, the axes' own angles are in it, up to"
        f" {most / URAD:.1f} urad: --square-at X200,Y150 says the place"
    )
    return [Finding("square-at", "doubt", one.name, text, {"opened_urad": most / URAD})]


def _compare(chosen: Squareness, sources: dict[str, Squareness]) -> Iterator[Finding]:
    """What the other sources say."""
    if chosen.remark:
        yield Finding("squareness", "note", chosen.name, f"{chosen.name}: {chosen.remark}")
    for other in sources.values():
        if other is chosen:
            continue
        apart = (other.value - chosen.value) / URAD
        u = np.hypot(chosen.u or 0.0, other.u or 0.0) / URAD
        disagrees = abs(apart) > APART * u and bool(u)
        text = (
            f"{chosen.name} is {chosen.value / URAD:+.1f} urad ({chosen.source}); {other.source}"
            f" would give {other.value / URAD:+.1f}, {apart:+.1f} apart with u = {u:.1f} urad"
        )
        yield Finding(
            "squareness", "doubt" if disagrees else "note", chosen.name, text,
            {"apart_urad": apart, "u_urad": u},
        )  # fmt: skip


def _counted_twice(calibration: Calibration, result: dict[str, Squareness]) -> Iterator[Finding]:
    """Lines that were left in beside a squareness."""
    for one in result.values():
        for a, b in itertools.permutations(square.pair_of(one.name)):
            component = calibration.components.get(f"E{a}{b}")
            if component is not None and component.slope:
                length = float(np.ptp(component.nodes))
                text = (
                    f"{component.name} keeps its line of {component.slope / URAD:+.1f} urad and"
                    f" {one.name} = {one.value / URAD:+.1f} urad is added to it: what of the line"
                    " is squareness counts twice, up to"
                    f" {abs(component.slope) * length * 1e3:.1f} um"
                )
                yield Finding(
                    "squareness", "doubt", component.name, text,
                    {"slope_urad": component.slope / URAD},
                )  # fmt: skip


def _slope(calibration: Calibration, series: Series) -> float:
    """rad: of the reference line of one file's means, without what the axes' own angles make of it
    where it was read."""
    cells = cells_of(series.position, series.approach, series.reading)
    mean = np.nanmean(cells.mean, axis=0)
    own = opening.of_line(calibration, series.component, cells.nodes, series.rest)
    return opening.slope(cells.nodes, mean, calibration.options.line) - own


def _found(
    calibration: Calibration, axes: tuple[str, ...]
) -> tuple[dict[str, dict[str, Squareness]], list[Finding]]:
    """What the recordings say of each squareness, by name and source."""
    pairs = ("".join(p) for p in itertools.combinations([x for x in XYZ if x in axes], 2))
    names = (square.name_for(p, calibration.options.squareness, axes) for p in pairs)
    straight = [_straightness(calibration, name) for name in names]
    across, findings = _diagonals(calibration, axes) if calibration.diagonals else ([], [])
    circles, says = _circles(calibration, axes)
    found: dict[str, dict[str, Squareness]] = {}
    for source, many in (("straightness", straight), ("diagonals", across), ("ballbar", circles)):
        for one in filter(None, many):
            found.setdefault(one.name, {})[source] = one
    return found, [*findings, *says]


def _wanted(name: str, source: str, found: dict[str, Squareness]) -> Squareness:
    """The one from the source that the user names. Raises CalibrationError."""
    if source in found:
        return found[source]
    there = f"there is {' and '.join(found)}" if found else "the recordings give none"
    raise CalibrationError(
        f"squareness {name} can not be had from {source}: {there}",
        "straightness: both axes of the pair against one square, lines taken off;"
        " diagonals: two in its plane; ballbar: circles in both senses",
    )


def _straightness(calibration: Calibration, name: str) -> Squareness | None:
    """From both straightnesses of a pair against one reference: files that name the same
    `reference`, or all of them where the user asks for it. `reversed = true` in a head: the square
    lay turned over, and its own error drops out."""
    a, b = tuple(square.pair_of(name))
    one, other = calibration.measured.get(f"E{a}{b}"), calibration.measured.get(f"E{b}{a}")
    options = calibration.options
    if one is None or other is None or options.keep_lines:
        return None
    both = (one, other)
    means = _against_one_square(calibration, name, both)
    if not means:
        return None
    arms = [opening.known_to(calibration, name, c.rest, c.letter) for c in both]
    scatter = float(np.linalg.norm([one.u_slope, other.u_slope, *arms]))
    files = " and ".join(dict.fromkeys(c.file for c in both))
    return _with_the_square(name, means, scatter, files, options)


def _against_one_square(
    calibration: Calibration, name: str, both: tuple[Component, Component]
) -> dict[bool, float]:
    """rad, mean of what files of both components say that were read against one square, by whether
    it lay turned over."""
    asked = calibration.options.squareness.get(name) == "straightness"
    found: dict[bool, list[float]] = {}
    for pair in itertools.product(*(component.series for component in both)):
        (reference, turned), (its, its_turned) = map(_square_of, pair)
        if (asked or (reference and reference == its)) and turned == its_turned:
            # each without what the axes' own angles make of it where it was read (opening.py)
            slopes = {s.component: _slope(calibration, s) for s in pair}
            found.setdefault(turned, []).append(square.from_slopes(name, slopes))
    return {turned: float(np.mean(values)) for turned, values in found.items()}


def _square_of(series: Series) -> tuple[str, bool]:
    """The reference that a file names, and whether it lay turned over."""
    return series.head.get("reference", ""), bool(series.head.get("reversed", False))


def _with_the_square(
    name: str, means: dict[bool, float], scatter: float, files: str, options: Options
) -> Squareness:
    """What the square's own error makes of it. means: rad, by whether it lay turned over."""
    if len(means) == 2:
        #    as it lies     value + sign * over     turned over, the square's own error changes its
        #    turned over    value - sign * over     sign: half the sum is the machine, half the
        #                                           difference the square
        own = -square.sign(name) * (means[True] - means[False]) / 2
        remark = (
            f"the square turned over: its own angle is 90 degrees {own / URAD:+.1f} urad, and"
            " dropped out"
        )
        return Squareness(
            name, sum(means.values()) / 2, _told(scatter / np.sqrt(2)),
            f"two straightnesses, {files}", remark,
        )  # fmt: skip
    value = next(iter(means.values()))
    if options.square_error is not None:
        over, u = options.square_error
        return Squareness(
            name,
            square.with_square(name, value, over),
            _told(np.hypot(scatter, u)),
            f"two straightnesses, {files}",
        )
    remark = (
        "the square's own error is in it: turn the square over (reversed = true) or state it with"
        " --square-error"
    )
    return Squareness(name, value, None, f"two straightnesses, {files}", remark)


def _told(u: float) -> float | None:
    """u, None where the scatter of single readings says nothing of it."""
    return float(u) if np.isfinite(u) else None


def _diagonals(
    calibration: Calibration, axes: tuple[str, ...]
) -> tuple[list[Squareness], list[Finding]]:
    """Squareness of all pairs that the diagonals cross, from what the measured components do not
    explain."""
    options = calibration.options
    slopes, directions, spread, findings = [], [], [], []
    pairs: list[str] = []
    for diagonal in calibration.diagonals:
        slope, u = _leftover(calibration, diagonal)
        slopes.append(slope)
        directions.append(diagonal.direction)
        spread.append(u)
        pairs += map("".join, itertools.combinations(diagonal.axes, 2))
        own = (f"E{x}{x}" for x in diagonal.axes)
        if lacking := [name for name in own if name not in calibration.components]:
            text = (
                f"{diagonal.file}: {' and '.join(lacking)} is not among the components, so the"
                " diagonal's scale contains it"
            )
            findings.append(Finding("diagonal", "note", diagonal.name, text))
    names = [square.name_for(pair, options.squareness, axes) for pair in dict.fromkeys(pairs)]
    try:
        values, u_of, scale = square.from_diagonals(slopes, directions, spread, names)
    except CalibrationError as error:
        return [], [*findings, Finding("diagonal", "note", "", f"{error.message}: {error.advice}")]
    findings.append(_of_scale(scale, spread))
    files = " and ".join(dict.fromkeys(d.file for d in calibration.diagonals))
    return [
        Squareness(n, values[n], _told(u_of[n]), f"diagonals, {files}") for n in names
    ], findings


def _of_scale(scale: float, spread: list[float]) -> Finding:
    """What is said of the scale that is left, rad. spread: u of each diagonal."""
    text = (
        f"the diagonals have {scale / URAD:+.1f} um/m of scale left that the components do not"
        " explain"
    )
    u_scale = float(np.sqrt(np.sum(np.square(np.nan_to_num(spread)))) / len(spread))
    level = "doubt" if abs(scale) > max(3 * u_scale, 2 * URAD) else "note"
    return Finding("diagonal", level, "", text, {"scale_um_per_m": scale / URAD})


def _circles(
    calibration: Calibration, axes: tuple[str, ...]
) -> tuple[list[Squareness], list[Finding]]:
    """Squareness of each plane in which a ballbar went round, from what the measured components do
    not explain."""
    planes: dict[str, list[Recording]] = {}
    found, findings = [], []
    for recording in calibration.circles:
        plane = circles.axes_of(recording)
        if not all(x in axes for x in plane):
            raise CalibrationError(
                f"a circle of {plane}, and the chain has {' '.join(axes)}",
                "--chain names all axes",
                Place(recording.file, 1),
            )
        planes.setdefault(plane, []).append(recording)
    for plane, some in planes.items():
        one = circles.fit(some, [_round(calibration, r, plane) for r in some])
        name = square.name_for(plane, calibration.options.squareness, axes)
        files = " and ".join(one.files)
        found.append(
            Squareness(name, square.sign(name) * one.square, one.u["square"], f"ballbar, {files}")
        )
        for x, play, u in zip(
            plane, one.play, (one.u["first play"], one.u["second play"]), strict=True
        ):
            level = "doubt" if abs(play) > max(2 * u, UM) else "note"
            text = (
                f"{files}: lost motion of {x} is {play / UM:+.2f} um beyond the map (u ="
                f" {u / UM:.2f})"
            )
            findings.append(Finding(
                "ballbar", level, f"E{x}{x}", text, {"play_um": play / UM},
            ))  # fmt: skip
        text = (
            f"{files}: the scale of {plane[0]} is {one.scale / URAD:+.1f} um/m more than that of"
            f" {plane[1]} beyond the map (u = {one.u['scale'] / URAD:.1f}), {one.rms / UM:.2f} um"
            " rms are left; of both alike a bar of unknown length says nothing"
        )
        level = "doubt" if abs(one.scale) > max(2 * one.u["scale"], 2 * URAD) else "note"
        findings.append(Finding("ballbar", level, "", text, {"scale_um_per_m": one.scale / URAD}))
    return found, findings


def _round(calibration: Calibration, recording: Recording, plane: str) -> np.ndarray:
    """(N,) mm: the radial deviation along a circle that the components make."""
    machine = calibration.machine
    position = machine.at({x: recording.position(x) for x in recording.axes}, len(recording))
    arm = np.stack([recording.position(x) - recording.head["centre"][x] for x in plane])
    far = np.hypot(*arm)
    unit = arm / np.where(far > 0, far, 1.0)  # the run-in may begin in the middle
    sense = circles.senses(recording, arm, circles.on_circle(recording, arm))
    # as on any circle (iso/causes.py): the axis moves against the sine, along the cosine of the
    # angle
    ways = zip(plane, (-sense * np.sign(unit[1]), sense * np.sign(unit[0])), strict=True)
    approach = machine.at(dict(ways), len(recording))
    off = machine.deviation(position, approach)
    return np.asarray(
        sum(u * off[machine.letters.index(x)] for x, u in zip(plane, unit, strict=True))
    )


def _leftover(calibration: Calibration, diagonal: Diagonal) -> tuple[float, float]:
    """rad: slope over its length of what a diagonal's reading has beyond the components, and its
    u, NaN where no reading is left to tell it."""
    # Squareness makes one diagonal of a face longer and the other as much shorter, scales make both
    # longer (ISO 230-6): of what the components leave, the slope over the length tells all of it.
    machine = calibration.machine
    count = len(diagonal.reading)
    position = machine.at({**diagonal.rest, **diagonal.path}, count)
    ways = {x: diagonal.approach * np.sign(diagonal.direction[x]) for x in diagonal.path}
    approach = machine.at(ways, count)
    expected = machine.deviation(position, approach)
    along = sum(c * expected[machine.letters.index(x)] for x, c in diagonal.direction.items())
    left = diagonal.reading - along
    s = np.asarray(sum(c * diagonal.path[x] for x, c in diagonal.direction.items()))
    # Each direction of travel has its own height: a reversal is not a slope.
    # s (N,) mm along the diagonal; columns: slope, height coming forth, height coming back
    terms = np.column_stack([s - s.mean(), diagonal.approach >= 0, diagonal.approach < 0]).astype(
        float
    )
    terms = terms[:, terms.any(axis=0)]
    fit, *_ = np.linalg.lstsq(terms, left, rcond=None)
    rest = left - terms @ fit
    # slope, and its u: residual scatter times the root of its element of (T'T)**-1
    free = len(left) - terms.shape[1]
    own = np.linalg.pinv(terms.T @ terms)[0, 0]
    return float(fit[0]), float(np.sqrt(rest @ rest / free * own)) if free > 0 else np.nan
