"""Programs of tests: what a machine must run so that an instrument can tell something, for its own travel and control.

A test is a function here, named in TESTS; it gives the text and how the instrument is to be set. Positions are slide
positions; the text has what the control wants: words from its work offset, diameters, its dwell, its plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from postproc.errors import UsageError
from postproc.machine.model import Machine
from postproc.nc import dialects

XYZ = "XYZ"
DWELL = {  # how the control is told to wait, by the first word of the dialect's name
    "linuxcnc": "G4 P{0:g}", "fanuc": "G4 X{0:.3f}", "haas": "G4 P{0:.3f}", "grbl": "G4 P{0:g}", "grblhal": "G4 P{0:g}",
    "fluidnc": "G4 P{0:g}",
}  # fmt: skip
PLANES = {
    "XY": ("G17", "IJ", 1),
    "XZ": ("G18", "IK", -1),
    "YZ": ("G19", "JK", 1),
}  # sign: XYZ order against the plane's
GOLDEN = 0.6180339887498949
OUTRUN = 1.0  # mm: an overrun where the travel has room for it


@dataclass(frozen=True)
class Test:
    """A program, the instrument that it is meant for, and how that is to be set."""

    __test__ = False

    text: str
    instrument: str
    settings: dict[str, str]
    title: str


class Writer:
    """Blocks for one machine in one dialect, from slide positions."""

    def __init__(self, machine: Machine, dialect: str):
        self.machine, self.kind = machine, dialect.partition("-")[0]
        if self.kind not in DWELL:
            known = ", ".join(sorted(DWELL))
            raise UsageError(f"tests are not written for {dialect}", f"--dialect of one of {known}")
        codes = dialects.load(dialect).by_number
        # Millimetres, absolute words, feed per minute, as this control writes them; what it has not, it always does.
        self.modes = " ".join(codes[number].word for number in (210, 900, 940) if number in codes)
        self.zero = machine.offsets.get("G54", {})
        self.places = {x: -round(math.log10(a.least_increment)) for x, a in machine.axes.items()}
        self.lines: list[str] = []

    def begin(self, title: str) -> None:
        name = title.upper().replace("(", "").replace(")", "")
        frame = " G54" if "G54" in self.machine.offsets else ""
        if self.kind == "fanuc" or self.kind == "haas":
            self.lines += ["%", "O0001"]
        self.lines += [f"({name})", f"{self.modes}{frame}"]
        # Every slide is placed first: from there on it is known where the machine stands.
        self.lines.append("G0 " + " ".join(self.word(x, v) for x, v in sorted(middle(self.machine).items())))

    def word(self, axis: str, place: float) -> str:
        """The axis' word for a slide position."""
        value = (place - self.zero.get(axis, 0.0)) * (2.0 if axis in self.machine.diameter else 1.0)
        return f"{axis}{value:.{self.places[axis]}f}"

    def go(self, place: Mapping[str, float], feed: float) -> None:
        words = " ".join(self.word(x, place[x]) for x in sorted(place))
        self.lines.append(f"G1 {words} F{feed:g}")

    def rest(self, place: Mapping[str, float], feed: float) -> None:
        """To where axes stay, each from below, so that it is known from which side they came."""
        if place:
            low = {x: max(v - OUTRUN, self.machine.axes[x].travel[0]) for x, v in place.items()}
            self.go(low, feed)
            self.go(place, feed)

    def wait(self, seconds: float) -> None:
        self.lines.append(DWELL[self.kind].format(seconds))

    def arc(self, sense: int, plane: str, end: Mapping[str, float], arm: Mapping[str, float], feed: float) -> None:
        """An arc from where the tool is; sense +1 from the first letter of the plane to the second; arm: to the centre, mm."""
        _, centre, sign = PLANES[plane]
        code = "G3" if sense * sign > 0 else "G2"
        ends = " ".join(self.word(x, end[x]) for x in plane)
        arms = " ".join(f"{c}{arm[x]:.{self.places[x]}f}" for c, x in zip(centre, plane, strict=True))
        self.lines.append(f"{code} {ends} {arms} F{feed:g}")

    def text(self) -> str:
        """The program."""
        tail = ["%"] if self.kind in ("fanuc", "haas") else []
        return "\n".join([*self.lines, "M30", *tail]) + "\n"


@dataclass(frozen=True)
class Ask:
    """What --test says: the axes, and key=value."""

    axes: str
    given: Mapping[str, float]

    def of(self, key: str, default: float) -> float:
        value = self.given.get(key, default)
        if key in ("feed", "dwell", "step", "radius", "rate", "hours", "period", "overrun") and value <= 0:
            raise UsageError(f"{key} = {value:g} is not above zero")
        return value

    def count(self, key: str, default: int) -> int:
        value = self.given.get(key, default)
        if value != int(value) or not 1 <= value <= 10_000:
            raise UsageError(f"{key} = {value:g} is no number of 1 to 10000")
        return int(value)


def ranges(machine: Machine, overrun: float) -> dict[str, tuple[float, float]]:
    """Axis to mm, low and high: what the tables cover and the travel leaves room for, an overrun beyond it."""
    result = {}
    for x, axis in machine.axes.items():
        if x not in XYZ:
            continue
        low, high = axis.travel
        if axis.table is not None:
            low, high = max(low, float(axis.table.nodes[0])), min(high, float(axis.table.nodes[-1]))
        low, high = max(low, axis.travel[0] + overrun), min(high, axis.travel[1] - overrun)
        if not np.isfinite(low + high) or high <= low:
            raise UsageError(f"{x} has no room for a test with {overrun:g} mm of overrun", "overrun=... smaller")
        result[x] = (low, high)
    return result


def middle(machine: Machine) -> dict[str, float]:
    """Axis to mm: where it rests while others are measured."""
    return {x: (low + high) / 2 for x, (low, high) in ranges(machine, OUTRUN).items()}


def targets(low: float, high: float, step: float, even: bool) -> np.ndarray:
    """Places of targets: at even steps, or each moved by up to a quarter of a step, as ISO 230-2 wants it, so that no period
    of a screw stays hidden."""
    number = max(round((high - low) / step), 2)
    places = low + (high - low) * np.arange(number + 1) / number
    if even:
        return np.round(low + step * np.arange(int((high - low) / step + 1e-9) + 1), 4)
    moved = places + 0.5 * ((np.arange(number + 1) * GOLDEN) % 1.0 - 0.5) * (high - low) / number
    moved[0], moved[-1] = low, high
    return np.round(moved, 3)


def positioning(write: Writer, ask: Ask) -> Test:
    """Targets along one axis, there and back (ISO 230-2). step, runs, dwell, feed, overrun, even, others stay in the middle."""
    axis = ask.axes
    overrun = ask.of("overrun", OUTRUN)
    low, high = ranges(write.machine, overrun)[axis]
    at = targets(low, high, ask.of("step", (high - low) / 16), bool(ask.of("even", 0.0)))
    rest = {x: v for x, v in middle(write.machine).items() if x != axis}
    rest |= {x: ask.of(f"at_{x}", v) for x, v in rest.items()}
    feed, dwell = ask.of("feed", 2000.0), ask.of("dwell", 3.0)
    write.begin(f"positioning of {axis}")
    write.rest(rest, feed)
    for _ in range(ask.count("runs", 5)):
        write.go({axis: low - overrun}, feed)
        for place in at:
            write.go({axis: float(place)}, feed)
            write.wait(dwell)
        write.go({axis: float(at[-1]) + overrun}, feed)
        for place in at[::-1]:
            write.go({axis: float(place)}, feed)
            write.wait(dwell)
    write.go({axis: low - overrun}, feed)
    return Test(write.text(), "laser", {"dwell": f"{dwell:g}", "along": axis}, f"positioning of {axis}")


def straightness(write: Writer, ask: Ask) -> Test:
    """The targets of positioning, read across the travel."""
    test = positioning(write, ask)
    across = next((x for x in write.machine.letters if x in XYZ and x != ask.axes), "")
    if not across:
        raise UsageError("straightness is across another axis, and there is none")
    return Test(test.text, "straightness", {"dwell": test.settings["dwell"], "across": across}, f"straightness of {ask.axes}")  # fmt: skip


def angle(write: Writer, ask: Ask) -> Test:
    """The targets of positioning, read as a rotation of the axis."""
    test = positioning(write, ask)
    return Test(test.text, "angle", {"dwell": test.settings["dwell"]}, f"rotation of {ask.axes}")


def diagonal(write: Writer, ask: Ask) -> Test:
    """Targets along a diagonal of two or three axes, there and back (ISO 230-6). number, runs, dwell, feed, overrun."""
    overrun = ask.of("overrun", OUTRUN)
    room = ranges(write.machine, overrun)
    signs = {x: (-1.0 if ask.given.get(f"down_{x}") else 1.0) for x in ask.axes}
    number, feed, dwell = ask.count("number", 17), ask.of("feed", 2000.0), ask.of("dwell", 3.0)
    share = np.linspace(0.0, 1.0, number)
    share[1:-1] += 0.25 * ((np.arange(1, number - 1) * GOLDEN) % 1.0 - 0.5) / (number - 1)
    ends = {x: room[x] if signs[x] > 0 else room[x][::-1] for x in ask.axes}
    size = math.sqrt(sum((b - a) ** 2 for a, b in ends.values()))

    def place(t: float) -> dict[str, float]:
        return {x: a + (b - a) * t for x, (a, b) in ends.items()}

    beyond = overrun / size
    rest = {x: v for x, v in middle(write.machine).items() if x not in ask.axes}
    write.begin(f"diagonal of {' '.join(ask.axes)}")
    write.rest(rest, feed)
    for _ in range(ask.count("runs", 5)):
        write.go(place(-beyond), feed)
        for t in share:
            write.go(place(float(t)), feed)
            write.wait(dwell)
        write.go(place(1.0 + beyond), feed)
        for t in share[::-1]:
            write.go(place(float(t)), feed)
            write.wait(dwell)
    write.go(place(-beyond), feed)
    along = ",".join(f"{x}{(b - a) / size:.9f}" for x, (a, b) in ends.items())
    return Test(write.text(), "laser", {"dwell": f"{dwell:g}", "along": along}, f"diagonal of {' '.join(ask.axes)}")


def ballbar(write: Writer, ask: Ask) -> Test:
    """Circles in both senses, half a turn of overshoot at both ends (ISO 230-4). radius, feed, runs, at_X ...: centre."""
    plane = "".join(sorted(ask.axes))
    room, centre = ranges(write.machine, OUTRUN), middle(write.machine)
    centre = {x: round(ask.of(f"at_{x}", v), 3) for x, v in centre.items()}
    reach = min(min(centre[x] - room[x][0], room[x][1] - centre[x]) for x in plane)
    radius = ask.of(
        "radius", float(next((r for r in (300, 250, 150, 100, 75, 50, 25, 10) if r <= 0.9 * reach), reach / 2))
    )
    if radius > reach:
        raise UsageError(f"a circle of {radius:g} mm does not fit: {reach:g} mm are left", "radius=... smaller")
    feed = ask.of("feed", 1000.0)
    first, second = plane[0], plane[1]
    lead = min(2.0, reach - radius)
    write.begin(f"ballbar in {first}{second}")
    write.lines.append(PLANES[plane][0])
    write.rest({x: v for x, v in centre.items() if x not in plane}, feed)
    write.go({first: centre[first] + radius + lead, second: centre[second]}, feed)
    other = {first: centre[first] - radius, second: centre[second]}
    here = {first: centre[first] + radius, second: centre[second]}
    for k in range(ask.count("runs", 2) * 2):
        sense = 1 if k % 2 == 0 else -1
        write.go(here, feed)
        for _ in range(2):
            write.arc(sense, plane, other, {first: -radius, second: 0.0}, feed)
            write.arc(sense, plane, here, {first: radius, second: 0.0}, feed)
        write.go({first: centre[first] + radius + lead, second: centre[second]}, feed)
        write.wait(ask.of("dwell", 1.0))
    settings = {"centre": ",".join(f"{x}{centre[x]:.4f}" for x in plane), "radius": f"{radius:g}"}
    return Test(write.text(), "ballbar", settings, f"ballbar in {first}{second}, {radius:g} mm at {feed:g} mm/min")


def staircase(write: Writer, ask: Ask) -> Test:
    """Reversals of growing length about one place: backlash and windup part (a windup grows with the way after the turn).

    runs, dwell, feed; at: mm, the place (the middle)."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    place, feed, dwell = ask.of("at", (low + high) / 2), ask.of("feed", 500.0), ask.of("dwell", 2.0)
    longest = min(5.0, (high - low) / 4)
    runs = ask.count("runs", 3)
    write.begin(f"reversals of {axis}")
    rest = {x: v for x, v in middle(write.machine).items() if x != axis}
    write.rest(rest, feed)
    for _ in range(runs):
        for sign in (1.0, -1.0):
            write.go({axis: place - sign * 2 * longest}, feed)
            write.go({axis: place}, feed)
            write.wait(dwell)
            for size in longest / 500.0 * 2.0 ** np.arange(10):
                way = max(
                    round(float(min(size, longest)), write.places[axis]), write.machine.axes[axis].least_increment
                )
                write.go({axis: place - sign * way}, feed)
                write.wait(dwell)
                write.go({axis: place - sign * 2 * longest}, feed)
                write.go({axis: place}, feed)
                write.wait(dwell)
    return Test(
        write.text(), "laser", {"dwell": f"{dwell:g}", "along": axis, "runs": f"{runs}"}, f"reversals of {axis}"
    )


def feeds(write: Writer, ask: Ask) -> Test:
    """One axis to and fro at growing feeds, for an axis log: lag goes with the speed, inertia with its change.

    number of feeds, slowest and fastest mm/min, way mm, runs."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    way = min(ask.of("way", 40.0), high - low)
    place = (low + high - way) / 2
    write.begin(f"feeds of {axis}")
    rest = {x: v for x, v in middle(write.machine).items() if x != axis}
    write.rest(rest, 1000.0)
    write.go({axis: place}, 1000.0)
    speeds = np.geomspace(ask.of("slowest", 60.0), ask.of("fastest", 3000.0), ask.count("number", 5))
    for _ in range(ask.count("runs", 2)):
        for speed in speeds:
            write.wait(0.5)
            write.go({axis: place + way}, round(float(speed), 1))
            write.wait(0.5)
            write.go({axis: place}, round(float(speed), 1))
    write.wait(0.5)
    return Test(write.text(), "log", {}, f"feeds of {axis}")


def soak(write: Writer, ask: Ask) -> Test:
    """Heat and rest: two places read while an axis runs to and fro, then while it rests (ISO 230-3). hours, feed, period s."""
    axis = ask.axes
    low, high = ranges(write.machine, OUTRUN)[axis]
    feed, hours, period = ask.of("feed", 4000.0), ask.of("hours", 1.0), ask.of("period", 300.0)
    swings = max(1, round(period / (2 * (high - low) / feed * 60.0)))
    write.begin(f"warming of {axis}")
    rest = {x: v for x, v in middle(write.machine).items() if x != axis}
    write.rest(rest, feed)
    number = max(2, round(hours * 3600.0 / period))
    near, far = low + 0.05 * (high - low), high - 0.05 * (high - low)
    for runs in (True, False):
        for _ in range(number):
            write.go({axis: low}, feed)
            for place in (near, far):
                write.go({axis: place}, feed)
                write.wait(3.0)
            if runs:
                for _ in range(swings):
                    write.go({axis: high}, feed)
                    write.go({axis: low}, feed)
            else:
                write.wait(period)
    settings = {"dwell": "3", "along": axis}
    return Test(write.text(), "laser", settings, f"warming of {axis}")


TESTS: dict[str, tuple[Callable[[Writer, Ask], Test], int, tuple[str, ...]]] = {
    "positioning": (positioning, 1, ("step", "runs", "dwell", "feed", "overrun", "even")),
    "straightness": (straightness, 1, ("step", "runs", "dwell", "feed", "overrun", "even")),
    "angle": (angle, 1, ("step", "runs", "dwell", "feed", "overrun", "even")),
    "diagonal": (diagonal, 2, ("number", "runs", "dwell", "feed", "overrun")),
    "ballbar": (ballbar, 2, ("radius", "feed", "runs", "dwell")),
    "staircase": (staircase, 1, ("runs", "dwell", "feed", "at")),
    "feeds": (feeds, 1, ("number", "slowest", "fastest", "way", "runs")),
    "soak": (soak, 1, ("hours", "feed", "period")),
}


def write(test: str, machine: Machine, dialect: str) -> Test:
    """The program of a test like "positioning:Z" or "ballbar:XZ,radius=75,feed=500". Raises UsageError."""
    head, *rest = test.split(",")
    name, _, axes = head.partition(":")
    if name not in TESTS:
        raise UsageError(f"there is no test {name!r}", f"tests: {', '.join(TESTS)}")
    function, number, keys = TESTS[name]
    slides = [x for x in machine.letters if x in XYZ]
    good = len(set(axes)) == len(axes) and all(x in slides for x in axes)
    if not good or len(axes) < number or (len(axes) > number and name != "diagonal"):
        raise UsageError(
            f"{head!r} names no {'axis' if number == 1 else f'{number} axes'} of {machine.name}",
            f"like {name}:{''.join(slides[:number])}; its axes are {' '.join(slides)}",
        )
    known = (*keys, *(f"at_{x}" for x in slides), *(f"down_{x}" for x in slides if name == "diagonal"))
    given = {}
    for item in rest:
        key, _, value = item.strip().partition("=")
        try:
            given[key] = float(value)
        except ValueError:
            given[key] = math.nan
        if key not in known or not math.isfinite(given[key]):
            raise UsageError(
                f"{item!r} is not one of {', '.join(known)} and a number", f"like {name}:{axes},{known[0]}=2"
            )
    return function(Writer(machine, dialect), Ask(axes, given))
