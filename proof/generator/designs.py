"""Experiments as drawn: which instruments, where, how fast, with which channels. Knows no effect
and no kind of case."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from proof.generator import parts, tracks
from proof.generator.machines import XYZ, Machine
from proof.generator.streams import log_uniform
from proof.generator.tracks import Track

TURNS = {"X": "EAX", "Y": "EBY", "Z": "ECZ"}


@dataclass(frozen=True)
class Design:
    """One experiment: the files in order, the room, and what is recorded beside the readings."""

    machine: Machine
    tracks: list[Track]
    room: dict[str, float]
    channels: dict[str, bool]

    @property
    def end(self) -> float:
        return max(t.end for t in self.tracks) + 60.0

    @property
    def moving(self) -> list[str]:
        """Axes that move in some file."""
        return [x for x in self.machine.axes if any(x in t.moving for t in self.tracks)]


MENU = {  # share of experiments that hold such a file
    "axis": 0.85,
    "second_axis": 0.45,
    "diagonal": 0.45,
    "straightness": 0.35,
    "angle": 0.12,
    "ballbar": 0.75,
    "trace": 0.45,
    "gauge": 0.4,
    "features": 0.35,
}


def draw(rng: np.random.Generator, machine: Machine) -> Design:
    """One experiment on the machine."""
    while True:
        files = [name for name, share in MENU.items() if rng.random() < share]
        if len(files) >= 2 and set(files) & {"axis", "ballbar", "trace"}:
            break
    rng.shuffle(files)
    channels = _channels(rng)
    room = {
        "start": rng.uniform(15, 24),
        "swing": log_uniform(rng, 0.2, 5.0),
        "period": rng.uniform(3, 12) * 3600,
        "phase": rng.uniform(0, 2 * np.pi),
        "walk": rng.uniform(0.05, 0.3),
        "heating": rng.choice([0.0, rng.normal(0, 4.0)]),
        "heating_at": rng.uniform(0, 3e4),
        "heating_tau": rng.uniform(1500, 6000),
        "screw_tau": rng.uniform(700, 2400),
        "screw_rise": rng.uniform(3.0, 8.0),
        "sensor": rng.uniform(0.2, 0.6),
        "bearing": rng.uniform(0.1, 0.5),
    }
    plans = _lines(machine)
    plan: list[Track] = []
    now = 0.0
    used: list[str] = []
    for name in files:
        made = _file(rng, machine, name, plans, now, channels, used)
        if made is None:
            continue
        plan += made
        pause = rng.uniform(150, 1200) if rng.random() < 0.8 else rng.uniform(2000, 6000)
        now = float(np.round(made[-1].end + pause))
    return Design(machine, plan, {k: float(v) for k, v in room.items()}, channels)


def _channels(rng) -> dict[str, bool]:
    warm = rng.random()
    return {
        "air": bool(warm < 0.8),
        "screw": bool(warm < 0.7),
        "bed": bool(warm < 0.75),
        "force": bool(rng.random() < 0.7),
        "spindle": bool(rng.random() < 0.85),
        "feed": bool(rng.random() < 0.9),
        "current": bool(rng.random() < 0.6),
        "stated": bool(rng.random() < 0.25),
    }


def _lines(machine: Machine) -> list[str]:
    return [p for p in ("XY", "XZ", "YZ") if all(x in machine.axes for x in p)]


def _head(kind: str, machine: Machine, instrument: str, **more) -> dict:
    return {"kind": kind, "machine": machine.name, "instrument": instrument, **more}


def _file(
    rng, machine: Machine, name: str, planes: list[str], now: float, channels, used: list[str]
) -> list[Track] | None:
    if name in ("axis", "second_axis"):
        left = [x for x in machine.axes if x not in used]
        letter = str(rng.choice(left))
        used.append(letter)
        return [axis_line(rng, machine, letter, letter, now, channels)]
    if name == "straightness":
        letter = str(rng.choice(list(machine.axes)))
        across = str(rng.choice([x for x in machine.axes if x != letter]))
        return [axis_line(rng, machine, letter, across, now, channels)]
    if name == "angle":
        turning = [c for c in machine.components() if c[1] in "ABC" and c != TURNS.get(c[2])]
        if not turning:
            return None
        component = str(rng.choice(turning))
        return [
            axis_line(
                rng,
                machine,
                component[2],
                XYZ["ABC".index(component[1])],
                now,
                channels,
                angle=True,
            )
        ]
    if name == "diagonal":
        return [diagonal(rng, machine, str(rng.choice(planes)), now, channels)]
    if name == "gauge":
        return [gauge(rng, machine, now)]
    if name == "ballbar":
        flat = machine.form == "mill" and (rng.random() < 0.75 or turning_mill(machine))
        plane = "XY" if flat else str(rng.choice(planes))
        senses = (
            [1, -1, 1, -1] if rng.random() < 0.85 else ([1, -1] if rng.random() < 0.5 else [1, 1])
        )
        slow, fast = (
            float(rng.choice([300.0, 500.0, 800.0])),
            float(rng.choice([2000.0, 3000.0, 4000.0])),
        )
        feeds = [slow, fast] if rng.random() < 0.8 else [float(rng.choice([1000.0, 2000.0]))]
        return ballbars(rng, machine, plane, senses, feeds, now)
    if name == "trace":
        return [trace(rng, machine, now, channels, "scale" if rng.random() < 0.5 else "tool")]
    count = int(rng.integers(6, 11))
    made = parts.features(
        rng,
        machine,
        _head("features", machine, "coordinate measuring machine"),
        now,
        count,
        rng.uniform(8, 18),
        int(rng.integers(0, 3)),
    )
    made.noise = {"sd": rng.uniform(0.8, 2.6)}
    return [made]


def _laser_noise(rng, sd: tuple[float, float], walk: tuple[float, float]) -> dict[str, float]:
    """Student's t with a random walk under it, um; zero: where the set-up left the zero."""
    return {
        "sd": rng.uniform(*sd),
        "freedom": rng.uniform(3.5, 8),
        "walk": rng.uniform(*walk),
        "zero": rng.normal(0, 10),
    }


def turning_mill(machine: Machine) -> bool:
    return machine.form == "mill" and any(c[1] in "ABC" for c in machine.components())


def places(rng, machine: Machine, free: list[str], two: bool) -> list[dict[str, float]]:
    """Where the axes stand that a line does not move: one place or two."""
    first = {x: machine.axes[x].share(rng.uniform(0.2, 0.45)) for x in free}
    if not two or not free:
        return [first]
    return [first, {x: machine.axes[x].share(rng.uniform(0.6, 0.85)) for x in free}]


def spread(rng, axis, n: int, how: str) -> np.ndarray:
    """(n,) targets over the travel: scattered, evenly, or at round multiples."""
    low, high = axis.share(0.03), axis.share(0.97)
    even = np.linspace(low, high, n)
    if how == "even":
        return np.round(even, 3)
    if how == "round":
        step = max(10.0, 10.0 * round((high - low) / (n - 1) / 10))
        first = 10.0 * np.ceil(low / 10)
        return first + step * np.arange(int((high - first) / step) + 1)
    moved = even + rng.uniform(-0.3, 0.3, n) * (even[1] - even[0])
    moved[[0, -1]] = low, high
    return np.round(moved, 3)


def axis_line(
    rng,
    machine,
    letter,
    sensed,
    now,
    channels,
    angle=False,
    how=None,
    both=None,
    two=None,
    count=None,
) -> Track:
    """Positioning, straightness or angle along one axis. sensed: the direction of the reading."""
    axis = machine.axes[letter]
    n = count or int(rng.integers(12, 21))
    how = how or str(rng.choice(["scattered", "even", "round"], p=[0.7, 0.2, 0.1]))
    points = spread(rng, axis, n, how)
    line = np.zeros((len(points), 3))
    line[:, XYZ.index(letter)] = points
    free = [x for x in machine.axes if x != letter]
    two = bool(rng.random() < 0.35) if two is None else two
    both = bool(rng.random() < 0.93) if both is None else both
    runs = int(rng.integers(3, 6))
    loads = [
        float(np.round(rng.uniform(300, 700))) if rng.random() < 0.2 else 0.0 for _ in range(runs)
    ]
    if rng.random() < 0.3:
        loads = [0.0] * runs
    what = "angle" if angle else ("displacement" if sensed == letter else "straightness")
    sensitive = np.zeros(3)
    sensitive[XYZ.index(sensed)] = 1.0
    name = "laser" if what == "displacement" else what
    head = _head(
        "targets",
        machine,
        f"{name} interferometer",
        quantity=what,
        sensitive=_vector(machine, sensitive, angle),
    )
    made = tracks.targets(
        rng,
        machine,
        head,
        line,
        places(rng, machine, free, two),
        runs=runs,
        feed=float(rng.choice([1000.0, 2000.0, 3000.0])),
        start=now,
        dwell=(3.5, 5.5),
        gap=(150, 1200),
        both=both,
        over=float(rng.uniform(2.0, 5.0)),
        strokes=bool(rng.random() < 0.75),
        loads=loads,
        sensitive=sensitive,
    )
    made.noise = _laser_noise(rng, (0.3, 1.6), (0.01, 0.07))
    made.channels = {"force": True}
    if channels["stated"]:
        head["u_um"] = round(made.noise["sd"], 1)
    return made


def diagonal(rng, machine, plane, now, channels, both=None) -> Track:
    """A face diagonal, rising or falling."""
    n = int(rng.integers(10, 22))
    down = bool(rng.random() < 0.4)
    line = np.zeros((n, 3))
    ends = []
    for k, x in enumerate(plane):
        axis = machine.axes[x]
        points = np.linspace(axis.share(0.03), axis.share(0.97), n)
        line[:, XYZ.index(x)] = points[::-1] if down and k else points
        ends.append(x)
    unit = (line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0])
    free = [x for x in machine.axes if x not in plane]
    runs = int(rng.integers(3, 5))
    head = _head(
        "targets",
        machine,
        "laser interferometer",
        quantity="displacement",
        sensitive=_vector(machine, unit),
    )
    made = tracks.targets(
        rng,
        machine,
        head,
        np.round(line, 3),
        places(rng, machine, free, False),
        runs=runs,
        feed=float(rng.choice([1000.0, 2000.0])),
        start=now,
        dwell=(3.5, 5.5),
        gap=(130, 600),
        both=both is not False,
        over=float(rng.uniform(2.0, 5.0)),
        strokes=bool(rng.random() < 0.6),
        loads=[0.0] * runs,
        sensitive=unit,
    )
    made.noise = _laser_noise(rng, (0.3, 1.3), (0.01, 0.07))
    made.channels = {"force": True}
    return made


def gauge(rng, machine, now) -> Track:
    """Probing between the parts of a working day: few targets, one approach, many runs, the spindle
    on and off."""
    letter = str(rng.choice(["X", "Z"] if machine.form != "mill" else ["X", "Y", "Z"]))
    axis = machine.axes[letter]
    line = np.zeros((int(rng.integers(4, 7)), 3))
    line[:, XYZ.index(letter)] = spread(rng, axis, len(line), "scattered")
    runs = int(rng.integers(28, 50))
    sensitive = np.zeros(3)
    sensitive[XYZ.index(letter)] = 1.0
    head = _head(
        "targets",
        machine,
        "in-process gauge",
        quantity="displacement",
        sensitive=_vector(machine, sensitive),
    )
    made = tracks.targets(
        rng,
        machine,
        head,
        line,
        places(rng, machine, [x for x in machine.axes if x != letter], False),
        runs=runs,
        feed=3000.0,
        start=now,
        dwell=(2.0, 3.5),
        gap=(140, 320),
        both=False,
        over=4.0,
        strokes=True,
        loads=[0.0] * runs,
        sensitive=sensitive,
    )
    made.noise = _laser_noise(rng, (0.5, 1.3), (0.0, 0.03))
    first = [float(made.time[made.run == r][0]) for r in range(1, runs + 1)]
    speed = float(rng.choice([750.0, 1500.0, 3000.0]))
    breaks = sorted(rng.choice(np.arange(6, runs - 3), size=int(rng.integers(1, 4)), replace=False))
    for r in range(1, runs):
        pause = any(b <= r < b + 3 for b in breaks)
        if not pause:
            made.spindle.append((first[r - 1] + 30, first[r] + 15, speed))
        if r in breaks and rng.random() < 0.5:
            speed = float(rng.choice([750.0, 1500.0, 3000.0]))
    every = int(rng.integers(7, 16))
    made.changes = [first[r] - 5.0 for r in range(every, runs, every)]
    return made


def ballbars(rng, machine, plane, senses, feeds, now, count=None) -> list[Track]:
    """One file a feed, the bar left as it is set up."""
    spans = [machine.axes[x].length for x in plane]
    radius = float(
        max(r for r in (50.0, 75.0, 100.0, 150.0) if r <= 50.0 or 2 * r + 30 <= min(spans))
    )
    centre = np.zeros(3)
    for x, axis in machine.axes.items():
        centre[XYZ.index(x)] = round(axis.middle)
    if turning_mill(machine):
        centre[2] = 0.0
    theta, lead = rng.uniform(-np.pi, np.pi), rng.uniform(0.8, 3.2)
    count = count or int(rng.choice([360, 720, 1080]))
    noise = {
        "sd": rng.uniform(0.2, 0.6),
        "white": rng.uniform(0.05, 0.2),
        "rho": rng.uniform(0.4, 0.75),
    }
    made = []
    for feed in feeds:
        where = {x: float(centre[XYZ.index(x)]) for x in plane}
        head = _head(
            "ballbar", machine, "ballbar", centre=where, radius_mm=radius, feed_mm_min=feed
        )
        made.append(
            tracks.ballbar(
                rng, machine, head, plane, centre, radius, feed, now, senses, count, theta, lead
            )
        )
        made[-1].noise = noise | {
            "length": rng.normal(0, 3),
            "u": rng.normal(0, 4),
            "v": rng.normal(0, 4),
        }
        now = made[-1].end + rng.uniform(250, 500)
    return made


def trace(rng, machine, now, channels, sees) -> Track:
    pair = "XY" if machine.form == "mill" else "XZ"
    centre = np.array(
        [float(round(machine.axes[x].middle)) if x in machine.axes else 0.0 for x in XYZ]
    )
    if turning_mill(machine):
        centre[2] = 0.0
    speeds = {
        "creep": float(rng.choice([10.0, 15.0, 20.0])),
        "brisk": float(rng.choice([800.0, 1200.0])),
        "cut": 400.0,
        "long": float(rng.choice([5000.0, 6000.0, 7500.0])),
        "circle": float(rng.choice([1000.0, 1500.0, 2000.0])),
        "radius": 12.0,
    }
    head = _head(
        "trace", machine, "grid encoder" if sees == "tool" else "controller log", sees=sees
    )
    cut = rng.uniform(300, 1200, 2) * (rng.permutation([1.0, 0.1]) if rng.random() < 0.8 else 1.0)
    made = tracks.trace(rng, machine, head, pair, centre, now, 3, speeds, -cut, 250.0)
    made.noise = {
        "sd": rng.uniform(0.2, 0.45) if sees == "tool" else rng.uniform(0.05, 0.25),
        "rho": rng.uniform(0.0, 0.6),
    }
    made.channels = {"force": True, "current": channels["current"] and sees == "scale"}
    return made


def _vector(machine, unit, angle: bool = False) -> dict[str, float]:
    letters = XYZ if angle else machine.letters
    return {x: float(np.round(unit[XYZ.index(x)], 9)) for x in letters}
