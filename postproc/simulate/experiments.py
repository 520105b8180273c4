"""Programs of tests: what a machine must run so that an instrument can tell something, for its own
travel and control.

A test is a function here, named in TESTS; it gives the text and how the instrument is to be set.
Positions are slide positions; the text has what the control wants: words from its work offset,
diameters, its dwell, its plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from postproc.errors import UsageError
from postproc.machine.model import Machine
from postproc.simulate.asked import Ask, Test, targets
from postproc.simulate.volumes import diagonal, steps, volume
from postproc.simulate.writer import OUTRUN, PLANES, XYZ, Writer, middle, ranges


def positioning(write: Writer, ask: Ask) -> Test:
    """Targets along one axis, there and back (ISO 230-2). step, runs, dwell, feed, overrun, even,
    others stay in the middle."""
    axis = ask.axes
    overrun = ask.of("overrun", OUTRUN)
    low, high = ranges(write.machine, overrun)[axis]
    at = targets(low, high, ask.of("step", (high - low) / 16), bool(ask.of("even", 0.0)))
    rest = middle(write.machine, axis)
    # where the others stand decides the arm of every angle: at_X says another line than the middle
    rest |= {x: ask.of(f"at_{x}", v) for x, v in rest.items()}
    feed, dwell = ask.of("feed", 2000.0), ask.of("dwell", 3.0)
    write.begin(f"positioning of {axis}")
    write.rest(rest, feed)
    for _ in range(ask.count("runs", 5)):
        _there_and_back(write, axis, at, overrun, feed, dwell)
    return Test(
        write.text(), "laser", {"dwell": f"{dwell:g}", "along": axis}, f"positioning of {axis}"
    )


def period(write: Writer, ask: Ask) -> Test:
    """A stretch of one axis at close targets whose steps are no part of a pitch, there and back:
    what a screw or a scale repeats every 2 mm to a third of the stretch shows in it. way mm (60),
    step mm (1), at: its middle, runs, dwell, feed."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    way = min(ask.of("way", 60.0), high - low)
    # within the travel, whichever middle is asked for
    begin = min(max(ask.of("at", (low + high) / 2) - way / 2, low), high - way)
    at = targets(begin, begin + way, min(ask.of("step", 1.0), way / 2), False)
    feed, dwell = ask.of("feed", 1000.0), ask.of("dwell", 2.0)
    write.begin(f"periods of {axis}")
    write.rest(middle(write.machine, axis), feed)
    for _ in range(ask.count("runs", 2)):
        _there_and_back(write, axis, at, OUTRUN, feed, dwell)
    return Test(write.text(), "laser", {"dwell": f"{dwell:g}", "along": axis}, f"periods of {axis}")


def arms(write: Writer, ask: Ask) -> Test:
    """The same targets along one axis on several lines: all other axes at their low end, then each
    of them at its high end. A rotation of the axis reads differently on lines that lie apart, a
    screw's error does not. step, runs (of each line), dwell, feed, overrun."""
    axis = ask.axes
    overrun = ask.of("overrun", OUTRUN)
    room = ranges(write.machine, overrun)
    low, high = room[axis]
    at = targets(low, high, ask.of("step", (high - low) / 12), False)
    feed, dwell, runs = ask.of("feed", 2000.0), ask.of("dwell", 3.0), ask.count("runs", 2)
    #     X ^   .- - - - - o    Z on its first line (all others low), then with X high, then with Y
    #       |   |               high: a rotation of Z differs between lines by angle times distance
    #       |   o - - - - - o
    #       +----------------> Z
    rest = {x: place[0] for x, place in room.items() if x != axis}
    if not rest:
        raise UsageError(f"{axis} is the only slide: there is no second line", f"like angle:{axis}")
    write.begin(f"{axis} on {len(rest) + 1} lines")
    for line in [rest, *({**rest, x: room[x][1]} for x in rest)]:
        write.go({axis: low - overrun}, feed)
        write.rest(line, feed)
        for _ in range(runs):
            _there_and_back(write, axis, at, overrun, feed, dwell)
    settings = {"dwell": f"{dwell:g}", "along": axis, "runs": f"{runs * (len(rest) + 1)}"}
    return Test(write.text(), "laser", settings, f"{axis} on {len(rest) + 1} lines")


def _there_and_back(
    write: Writer, axis: str, at: np.ndarray, overrun: float, feed: float, dwell: float
) -> None:
    """One run: all targets from below and from above, and the overruns from which they are
    reached."""
    write.go({axis: float(at[0]) - overrun}, feed)
    for place in at:
        write.stop({axis: float(place)}, feed, dwell)
    # beyond the last target, or coming back would begin there without a reversal (ISO 230-2)
    write.go({axis: float(at[-1]) + overrun}, feed)
    for place in at[::-1]:
        write.stop({axis: float(place)}, feed, dwell)
    write.go({axis: float(at[0]) - overrun}, feed)


def straightness(write: Writer, ask: Ask) -> Test:
    """The targets of positioning, read across the travel."""
    test = positioning(write, ask)
    across = next((x for x in write.machine.letters if x in XYZ and x != ask.axes), "")
    if not across:
        raise UsageError("straightness is across another axis, and there is none")
    return Test(
        test.text,
        "straightness",
        {"dwell": test.settings["dwell"], "across": across},
        f"straightness of {ask.axes}",
    )


def angle(write: Writer, ask: Ask) -> Test:
    """The targets of positioning, read as a rotation of the axis."""
    test = positioning(write, ask)
    return Test(test.text, "angle", {"dwell": test.settings["dwell"]}, f"rotation of {ask.axes}")


def ballbar(write: Writer, ask: Ask) -> Test:
    """Circles in both senses, half a turn of overshoot at both ends (ISO 230-4). radius, feed,
    runs, at_X ...: centre; slow: mm/min, the feed of as many runs more."""
    plane = "".join(sorted(ask.axes))
    room, centre = ranges(write.machine, OUTRUN), middle(write.machine)
    centre = {x: round(ask.of(f"at_{x}", v), 3) for x, v in centre.items()}
    reach = min(min(centre[x] - room[x][0], room[x][1] - centre[x]) for x in plane)
    radius = _radius(ask, reach)
    feed = ask.of("feed", 1000.0)
    first, second = plane[0], plane[1]
    #             .---.        From `lead` outside to (radius, 0), two whole turns, and out again:
    #            (  +  )--->   half a turn of run-in and of run-out leave the middle one at full
    #             '---'        feed, and the ballbar keeps that.
    lead = min(2.0, reach - radius)
    write.begin(f"ballbar in {first}{second}")
    write.lines.append(PLANES[plane][0])
    write.rest({x: centre[x] for x in centre.keys() - {first, second}}, feed)
    write.go({first: centre[first] + radius + lead, second: centre[second]}, feed)
    other = {first: centre[first] - radius, second: centre[second]}
    here = {first: centre[first] + radius, second: centre[second]}
    number = ask.count("runs", 2) * 2
    speeds = [feed] * number + [ask.of("slow", feed)] * (number if "slow" in ask.given else 0)
    for k, speed in enumerate(speeds):
        sense = (-1) ** k
        write.go(here, speed)
        for _ in range(2):
            write.arc(sense, plane, other, {first: -radius, second: 0.0}, speed)
            write.arc(sense, plane, here, {first: radius, second: 0.0}, speed)
        write.go({first: centre[first] + radius + lead, second: centre[second]}, feed)
        write.wait(ask.of("dwell", 1.0))
    settings = {"centre": ",".join(f"{x}{centre[x]:.4f}" for x in plane), "radius": f"{radius:g}"}
    return Test(
        write.text(),
        "ballbar",
        settings,
        f"ballbar in {first}{second}, {radius:g} mm at {feed:g} mm/min",
    )


def _radius(ask: Ask, reach: float) -> float:
    """mm: as asked for, or what ballbars are made for. Raises UsageError beyond `reach`."""
    # lengths of ballbars that are sold; 0.9: room for the lead
    usual = (r for r in (300.0, 250.0, 150.0, 100.0, 75.0, 50.0, 25.0, 10.0) if r <= 0.9 * reach)
    radius = ask.of("radius", next(usual, reach / 2))
    if radius > reach:
        raise UsageError(
            f"a circle of {radius:g} mm does not fit: {reach:g} mm are left", "radius=... smaller"
        )
    return radius


def staircase(write: Writer, ask: Ask) -> Test:
    """Reversals of growing length about one place: backlash and windup part (a windup grows with
    the way after the turn).

    runs, dwell, feed; at: mm, the place (the middle)."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    place, feed, dwell = ask.of("at", (low + high) / 2), ask.of("feed", 500.0), ask.of("dwell", 2.0)
    longest = min(5.0, (high - low) / 4)
    runs = ask.count("runs", 3)
    write.begin(f"reversals of {axis}")
    write.rest(middle(write.machine, axis), feed)
    for _ in range(runs):
        for sign in (1.0, -1.0):
            write.go({axis: place - sign * 2 * longest}, feed)
            write.stop({axis: place}, feed, dwell)
            #    <----    Each way is twice the one before: windup grows with the way behind the
            #      <--    turn, plain backlash is there at once. Between two of them a long way
            #       <-    turns the slide round whole.
            for size in longest / 500.0 * 2.0 ** np.arange(10):
                way = max(
                    round(float(min(size, longest)), write.places[axis]),
                    write.machine.axes[axis].least_increment,
                )
                write.stop({axis: place - sign * way}, feed, dwell)
                write.go({axis: place - sign * 2 * longest}, feed)
                write.stop({axis: place}, feed, dwell)
    return Test(
        write.text(),
        "laser",
        {"dwell": f"{dwell:g}", "along": axis, "runs": f"{runs}"},
        f"reversals of {axis}",
    )


def feeds(write: Writer, ask: Ask) -> Test:
    """One axis to and fro at growing feeds, for an axis log: lag goes with the speed, inertia with
    its change.

    number of feeds, slowest and fastest mm/min, way mm, runs."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    way = min(ask.of("way", 40.0), high - low)
    place = (low + high - way) / 2
    write.begin(f"feeds of {axis}")
    write.rest(middle(write.machine, axis), 1000.0)
    write.go({axis: place}, 1000.0)
    # equal ratios: lag goes with the speed, and is to be told from what does not
    speeds = np.geomspace(
        ask.of("slowest", 60.0), ask.of("fastest", 3000.0), ask.count("number", 5)
    )
    for _ in range(ask.count("runs", 2)):
        for speed in speeds:
            write.wait(0.5)
            write.go({axis: place + way}, round(float(speed), 1))
            write.wait(0.5)
            write.go({axis: place}, round(float(speed), 1))
    write.wait(0.5)
    return Test(write.text(), "log", {}, f"feeds of {axis}")


def soak(write: Writer, ask: Ask) -> Test:
    """Heat and rest: two places read while an axis runs to and fro, then while it rests (ISO
    230-3). hours, feed, period s."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    feed, hours, period = ask.of("feed", 4000.0), ask.of("hours", 1.0), ask.of("period", 300.0)
    # so many ways there and back as fill one period between two readings
    cycles = max(1, round(period / (2 * (high - low) / feed * 60.0)))
    write.begin(f"warming of {axis}")
    write.rest(middle(write.machine, axis), feed)
    number = max(2, round(hours * 3600.0 / period))
    # two places: a screw that grows from one end moves them unlike, a frame both alike
    near, far = low + 0.05 * (high - low), high - 0.05 * (high - low)
    # heat, then rest: the time constant shows twice, rising and falling
    for runs in (True, False):
        for _ in range(number):
            write.go({axis: low}, feed)
            for place in (near, far):
                write.stop({axis: place}, feed, 3.0)
            if runs:
                for _ in range(cycles):
                    write.go({axis: high}, feed)
                    write.go({axis: low}, feed)
            else:
                write.wait(period)
    settings = {"dwell": "3", "along": axis}
    return Test(write.text(), "laser", settings, f"warming of {axis}")


def rest(write: Writer, ask: Ask) -> Test:
    """Slides at rest in the middle, read every period: drift of the room, or, with rpm, of the
    spindle, which turns for the first half (ISO 230-3). hours (4), period s (60), rpm (0)."""
    axis = ask.axes
    hours, period, rpm = ask.of("hours", 4.0), ask.of("period", 60.0), ask.of("rpm", 0.0)
    number = max(2, round(hours * 3600.0 / period))
    write.begin(f"rest, read along {axis}")
    write.rest(middle(write.machine), 2000.0)
    for k in range(number):
        if rpm > 0 and k in (0, number // 2):
            write.lines.append("M5" if k else f"M3 S{rpm:g}")
        write.wait(period)
    return Test(
        write.text(), "laser", {"dwell": f"{period:g}", "along": axis}, f"rest, read along {axis}"
    )


ONE, PLANE, SEVERAL = range(1, 2), range(2, 3), range(2, 4)
# how it is written, how many axes it takes, its settings
TESTS: dict[str, tuple[Callable[[Writer, Ask], Test], range, tuple[str, ...]]] = {
    "positioning": (positioning, ONE, ("step", "runs", "dwell", "feed", "overrun", "even")),
    "period": (period, ONE, ("way", "step", "runs", "dwell", "feed", "at")),
    "arms": (arms, ONE, ("step", "runs", "dwell", "feed", "overrun")),
    "straightness": (straightness, ONE, ("step", "runs", "dwell", "feed", "overrun", "even")),
    "angle": (angle, ONE, ("step", "runs", "dwell", "feed", "overrun", "even")),
    "diagonal": (diagonal, SEVERAL, ("number", "runs", "dwell", "feed", "overrun")),
    "steps": (steps, SEVERAL, ("number", "runs", "dwell", "feed", "overrun")),
    "ballbar": (ballbar, PLANE, ("radius", "feed", "runs", "dwell", "slow")),
    "staircase": (staircase, ONE, ("runs", "dwell", "feed", "at")),
    "feeds": (feeds, ONE, ("number", "slowest", "fastest", "way", "runs")),
    "soak": (soak, ONE, ("hours", "feed", "period")),
    "volume": (volume, SEVERAL, ("number", "dwell", "feed")),
    "rest": (rest, ONE, ("hours", "period", "rpm")),
}


def write(test: str, machine: Machine, dialect: str) -> Test:
    """The program of a test like "positioning:Z" or "ballbar:XZ,radius=75,feed=500". Raises
    UsageError."""
    head, *rest = test.split(",")
    name, _, axes = head.partition(":")
    if name not in TESTS:
        raise UsageError(f"there is no test {name!r}", f"tests: {', '.join(TESTS)}")
    function, numbers, keys = TESTS[name]
    least = numbers[0]
    slides = "".join(x for x in machine.letters if x in XYZ)
    if len(set(axes) & set(slides)) != len(axes) or len(axes) not in numbers:
        raise UsageError(
            f"{head!r} names no {'axis' if least == 1 else f'{least} axes'} of {machine.name}",
            f"like {name}:{slides[:least]}; its axes are {' '.join(slides)}",
        )
    known = (
        *keys,
        *(f"at_{x}" for x in slides),
        *(f"down_{x}" for x in slides if name in ("diagonal", "steps")),
    )
    given = _given(rest, known, f"{name}:{axes}")
    return function(Writer(machine, dialect), Ask(axes, given))


def _given(items: list[str], known: tuple[str, ...], test: str) -> dict[str, float]:
    """What follows a test's name, like radius=75."""
    given = {}
    for item in items:
        key, _, value = item.strip().partition("=")
        try:
            given[key] = float(value)
        except ValueError:
            given[key] = math.nan
        if key not in known or not math.isfinite(given[key]):
            raise UsageError(
                f"{item!r} is not one of {', '.join(known)} and a number",
                f"like {test},{known[0]}=2",
            )
    return given
