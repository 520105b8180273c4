"""What is in every recording and is no finding: zeros, set-ups, what the map may be wrong by, what
an instrument wanders.

Each group of columns has a standard deviation: stated here, free (unknown), or learned
beside every set of effects from a usual value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.diagnose import mains, telegraph
from postproc.diagnose.noise import FORCES, Unit, hats, wander
from postproc.diagnose.rows import Rows
from postproc.diagnose.signals import FAR
from postproc.effects import legendre
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine

FREE = 1e3  # mm: an unknown zero
# um: by how much each smooth term of a measured map is usually wrong (design of the experiment:
# 0.25 um)
MAP_UM = 0.3
LEAST_UM = 0.05  # um: what is stated to be exact was rounded, and lies between nodes
COVERAGE = 2.0  # an expanded uncertainty U over a standard one
DEGREES = range(1, 7)
CENTRE = 0.1  # mm
BAR = 0.01  # mm: by how much a bar may grow while it turns
PART = 5e-4  # mm
# mm: what a measuring machine's stylus, set at a reference sphere, is off by at every wall
# (unverified: a usual figure)
STYLUS = 3e-4
# rad, a second of arc: what squares and levels are good for that lines of straightness are referred
# to (unverified)
ALIGNED = 5e-6
# mm: of a feature's own, beside what the map is off by at its two places (unverified)
FEATURE = 5e-4
# mm: how far lost motion is from being taken up where a recording begins (a preloaded screw's,
# unverified); ways over which it is taken up
BEGINS, TAKEN_UP = 2e-3, (0.1, 1.0, 5.0)
# mm: by how much a circle may be off where it begins, spikes counted; s: times in which that fades
SPIKES, FADES = 1e-2, (0.05, 0.2, 0.5)
RESTING = 0.02  # of the largest speed of an axis: with less it rests
# mm: by how much the zero of an instrument differs from run to run, usually and at most
RUN, MOST_RUN = 3e-4, 1e-3
WANDER, MOST_WANDER = (
    3e-4,
    1.5e-3,
)  # mm: by how much it wanders while it reads (lasers and probes in workshops: 0.1 to 3 um)
MOST_FEATURE = 1.5e-3  # mm
PICKUP = 2e-3  # mm: of the mains, by an instrument (unverified)
PROCESS, MOST_PROCESS = 2e-3, 1.0  # mm: of what no name explains
ZEROS = 1e-2  # mm: of an instrument that is set to zero anew before each run
PER_MM = 1e-3  # rad of an angle that count as much as a mm
SQUARE = 1.5e-6  # rad
COARSE, FINE = 6, 24  # nodes of a process over the place, for each combination of directions
MOST_NODES = 120
TURNS, SHORTEST, LONGEST = 12, 1e-3, 1.0  # nodes of a process after a turn; s
SPEEDS, SLOWEST = 6, 0.05  # nodes of a process over the speed; mm/s
# kinds of Group; those that come back and are no noise, and that which a name says as well
PROCESSES = ("place", "turn", "speed", "drift", "lever", "zeros", "driver")
RECURRENT, NAMED = ("place", "turn", "driver"), ("driver",)


@dataclass(frozen=True)
class Group:
    """Columns (n, M) of one unit, or (N, M) of all rows. sd mm; kind: zero, set-up, run, wander,
    feature, map, jump, and PROCESSES; most mm: where sd is a first guess, the largest that an
    instrument in order may have; 0 where sd is known."""

    kind: str
    columns: np.ndarray
    sd: float
    most: float = 0.0

    @property
    def learned(self) -> bool:
        return self.most > 0


def of_all(rows: Rows, units: list[Unit]) -> list[list[Group]]:
    """The groups that are of one instrument alone, of each."""
    found = [of_unit(rows, unit) for unit in units]
    for own, level in zip(found, telegraph.levels(rows, units), strict=True):
        if level is not None:
            own.append(Group("zero", level[:, None], FREE))
    for own, step in zip(found, telegraph.steps(rows, units), strict=True):
        if step is not None:
            own.append(Group("zero", step[0], 2 * step[1]))
    for own, hum in zip(found, mains.waves(rows, units), strict=True):
        if hum is not None:
            own.append(Group("zero", hum, PICKUP))
    return found


# Whole: a list of processes, with the condition of each.
def of_unit(rows: Rows, unit: Unit) -> list[Group]:
    """The same of one unit, but for the levels of an instrument that switches."""
    own, n = unit.rows, len(unit)
    scale = PER_MM if unit.sees == "angle" else 1.0
    found: list[Group] = []
    file = int(rows.file[own[0]])
    kind = rows.kinds[file]
    if unit.sees == "part":
        found += _of_features(rows, unit)
    else:
        found.append(Group("zero", np.ones((n, 1)), FREE))
    if kind == "ballbar":
        found.append(
            Group("set-up", rows.direction[own][:, rows.direction[own].any(axis=0)], CENTRE)
        )
        share = _share(unit.time)  # the bar warms in the hand and on the machine
        found.append(
            Group("set-up", np.stack([legendre(share, d) for d in (1, 2, 3)], axis=1), BAR)
        )
        found += _at_quadrants(rows, unit)
    if kind == "trace":
        found += _beginnings(rows, unit)
    if kind == "targets" and unit.sees == "tool":
        # its line is known as well as it was referred to an axis
        for p in rows.state.position.values():
            if np.ptp(p[own]) > 1e-3:
                found.append(Group("set-up", (p[own] - p[own].mean())[:, None], ALIGNED))
    numbers = np.unique(rows.run[own])
    if unit.sees != "part" and len(numbers) > 1:
        each = (rows.run[own][:, None] == numbers).astype(float)
        found.append(Group("run", each, RUN * scale, MOST_RUN * scale))
        late = np.zeros_like(each)
        for k in range(len(numbers)):
            which = each[:, k] > 0
            if which.sum() >= 4:
                late[which, k] = _share(unit.time[which]) / 2
        if late.any():
            found.append(Group("run", late, RUN * scale, MOST_RUN * scale))
    # without times nobody can tell what wanders
    if unit.sees != "part" and np.ptp(rows.state.time[own]) > 0:
        found += [
            Group("wander", columns, WANDER * scale, MOST_WANDER * scale)
            for columns in wander(unit)
        ]
    return found


def _beginnings(rows: Rows, unit: Unit) -> list[Group]:
    """How lost motion stood when a run of a trace began, and how it is taken up on the way to the
    first turn: a level of its own until the axis moves, and what fades with the way since."""
    own = unit.rows
    axis = XYZ[int(np.argmax(np.abs(rows.direction[own]).max(axis=0)))]
    distance = rows.state.distance.get(axis)
    if distance is None:
        return []
    found = []
    moved = rows.state.approach[axis][own] != 0
    place = rows.state.position[axis][own]
    for run in np.unique(rows.run[own]):
        first = (rows.run[own] == run) & (distance[own] >= FAR / 2)
        rests, goes = first & ~moved, first & moved
        if rests.any() and (moved & (rows.run[own] == run)).any():
            found.append(Group("set-up", rests.astype(float)[:, None], BEGINS))
        if goes.any():
            way = np.abs(place - place[np.flatnonzero(goes)[0]])
            fades = np.exp(-way[:, None] / TAKEN_UP) * goes[:, None]
            found.append(Group("set-up", fades, BEGINS))
    return found


def _at_quadrants(rows: Rows, unit: Unit) -> list[Group]:
    """What fades behind the start of circles that begin where an axis rests, at a quadrant: whether
    it turned there, and how it was pushed before, was not recorded (ISO 230-4 leaves the beginning
    out)."""
    own = unit.rows
    found = []
    speeds = [np.abs(v[own]) for v in rows.state.velocity.values() if np.any(v[own])]
    for run in np.unique(rows.run[own]):
        here = np.flatnonzero(rows.run[own] == run)
        if any(v[here[0]] < RESTING * float(v[here].max()) for v in speeds):
            gone = unit.time[here] - unit.time[here[0]]
            fades = np.zeros((len(own), len(FADES)))
            fades[here] = np.exp(-gone[:, None] / np.array(FADES))
            found.append(Group("set-up", fades, SPIKES))
    return found


def _of_features(rows: Rows, unit: Unit) -> list[Group]:
    own = unit.rows
    found = []
    signals = np.unique(rows.signal[own])
    each = (rows.signal[own][:, None] == signals).astype(float)
    # A feature has no set-up zero of its own, only what the map does not know at its place.
    found.append(Group("feature", each, FEATURE, MOST_FEATURE))
    wall = rows.state.channels.get("wall", np.ones(len(rows)))[own]
    if wall.any():
        found.append(Group("set-up", wall[:, None], STYLUS))
    numbers = np.unique(rows.run[own])  # every part lies a little differently in its fixture
    for i in range(3):
        lies = (rows.run[own][:, None] == numbers) * (rows.direction[own][:, i] * wall)[:, None]
        if lies.any() and len(numbers) > 1:
            found.append(Group("run", lies, PART, MOST_RUN))
    return found


# Whole: a list of processes, with the condition of each.
def processes(rows: Rows, unit: Unit) -> list[Group]:
    """What is there and no name explains: smooth functions of the place, one for each combination
    of the directions of approach ("place"), of the time since a turn, one for each axis and
    direction ("turn"), of the speed ("speed"), of time, larger than an instrument wanders
    ("drift"), and of time in proportion to the place ("lever"); a zero of its own of each run
    ("zeros"); and at rest what goes in proportion to a force or a speed that was recorded
    ("driver")."""
    own = unit.rows
    if len(own) < 8:
        return []
    scale = PER_MM if unit.sees == "angle" else 1.0
    if unit.sees == "part":
        each = (rows.signal[own][:, None] == np.unique(rows.signal[own])).astype(float)
        return [Group("place", each, PROCESS, MOST_PROCESS)]
    moving = [x for x, p in rows.state.position.items() if np.ptp(p[own]) > 1e-3]
    found = []
    if moving:
        main = max(moving, key=lambda x: float(np.ptp(rows.state.position[x][own])))
        sides = np.stack([np.sign(rows.state.approach[x][own]) for x in moving])
        side = np.unique(sides, axis=1, return_inverse=True)[1].ravel()
        for number in (COARSE, FINE):
            columns = _nodes(rows.state.position[main][own], side, number)
            if columns.shape[1] <= min(MOST_NODES, len(own) // 2):
                found.append(Group("place", columns, PROCESS * scale, MOST_PROCESS * scale))
    if unit.dense:
        turns = []
        for x in moving:
            since = rows.state.since[x][own]
            near = (since < LONGEST) & (rows.state.velocity[x][own] != 0)
            if near.sum() > 8:
                late = np.log(np.maximum(since, SHORTEST))
                side = np.where(near, np.sign(rows.state.approach[x][own]), 0.0)
                turns.append(_nodes(late, side, TURNS, only=(-1.0, 1.0)))
        if turns:
            found.append(Group("turn", np.concatenate(turns, axis=1), PROCESS, MOST_PROCESS))
    if unit.dense and moving:
        found.append(Group("speed", _of_speed(rows, own, main), PROCESS, MOST_PROCESS))
    if np.ptp(rows.state.time[own]) > 0:
        slow = wander(unit)[:2]
        found += [
            Group("drift", columns, PROCESS * scale, MOST_PROCESS * scale) for columns in slow
        ]
        if moving and slow:  # what tilts or stretches for a while
            place = rows.state.position[main][own]
            lever = 2 * (place - place.mean()) / np.ptp(place)
            found.append(
                Group("lever", slow[0] * lever[:, None], PROCESS * scale, MOST_PROCESS * scale)
            )
    forces = [v[own] for name, v in rows.state.channels.items() if name.startswith(FORCES)]
    forces = [v / np.abs(v).max() for v in forces if np.isfinite(v).all() and np.ptp(v) > 0]
    if forces and not unit.dense:
        columns = np.stack(forces, axis=1)
        found.append(Group("driver", columns, PROCESS * scale, MOST_PROCESS * scale))
    numbers = np.unique(rows.run[own])
    if 1 < len(numbers) < len(own) / 2:
        found.append(
            Group(
                "zeros",
                (rows.run[own][:, None] == numbers).astype(float),
                ZEROS * scale,
                MOST_PROCESS * scale,
            )
        )
    return found


def _of_speed(rows: Rows, own: np.ndarray, axis: str) -> np.ndarray:
    """(n, M): smooth functions of the speed of an axis, for each direction, alike everywhere and
    more at one end."""
    v = rows.state.velocity[axis][own]
    place = rows.state.position[axis][own]
    columns = _nodes(np.log(np.maximum(np.abs(v), SLOWEST)), np.sign(v), SPEEDS)
    return np.concatenate(
        [columns, columns * (2 * (place - place.mean()) / np.ptp(place))[:, None]], axis=1
    )


def _nodes(
    value: np.ndarray, side: np.ndarray, number: int, only: tuple[float, ...] = ()
) -> np.ndarray:
    """(n, M): lines between so many values, for each side apart."""
    columns = []
    for s in only or np.unique(side):
        which = side == s
        if not which.any():
            continue
        places = np.unique(np.round(value[which], 2))
        nodes = np.unique(np.quantile(places, np.linspace(0, 1, min(number, len(places)))))
        block = np.zeros((len(value), len(nodes)))
        block[which] = hats(value[which], nodes)
        columns.append(block)
    return np.concatenate(columns, axis=1)


def of_map(rows: Rows, machine: Machine) -> list[Group]:
    """What the machine's map may be wrong by, as it states or as maps usually are: the same for all
    instruments. (N, M)."""
    seen = np.isin(rows.sees, ("laser", "tool"))
    part = rows.sees == "part"
    smooth, square = [], []
    for x in rows.state.position:
        u = np.clip(rows.state.share(x), -1.2, 1.2)
        for along in range(3):
            enters = np.where(seen, rows.direction[:, along], 0.0)
            # One group, one learned size, for all components: each in proportion to what is stated
            # of it.
            times = _stated(machine, x, along) / MAP_UM
            for degree in DEGREES:
                shape = enters * legendre(u, degree)
                # features see the same map, at the two places of their walls
                if along == XYZ.index(x):
                    walls = np.where(part, rows.direction[:, along], 0.0)
                    shape = shape + walls * _between(rows, x, degree)
                smooth.append(times * shape)
            if along != XYZ.index(x):
                # across its own axis a slope is an error of squareness, with a size of its own
                square.append(enters * rows.state.position[x])
    groups = [("map", smooth, MAP_UM * 1e-3, 3 * MAP_UM * 1e-3), ("square", square, SQUARE, 0.0)]
    found = []
    for kind, columns, sd, most in groups:
        shown = [c for c in columns if np.abs(c).max(initial=0.0) > 1e-9]
        if shown:
            found.append(Group(kind, np.stack(shown, axis=1), sd, most))
    return found


def _stated(machine: Machine, axis: str, along: int) -> float:
    """um: the standard uncertainty of one component of an axis' table, in the middle of its nodes;
    MAP_UM where none is stated."""
    known = machine.axes[axis].uncertainty
    if known is None or along not in known.stated:
        return MAP_UM
    return max(float(np.median(known.table.forward[along])) / COVERAGE * 1e3, LEAST_UM)


def _between(rows: Rows, axis: str, degree: int) -> np.ndarray:
    """(N,) difference of a smooth term of the map at the two walls of features; of a diameter on a
    lathe, at its radius."""
    here = legendre(np.clip(rows.state.share(axis), -1.2, 1.2), degree)
    if axis not in rows.other:
        return here
    low, high = rows.state.travel[axis]
    other = rows.other[axis]
    there = legendre(
        np.clip(2 * (np.nan_to_num(other) - low) / (high - low) - 1, -1.2, 1.2), degree
    )
    return here - np.where(np.isnan(other), 0.0, there)


def _share(t: np.ndarray) -> np.ndarray:
    """(N,) -1 to 1 from the first of these times to the last; times that were not recorded: in the
    order of rows."""
    t = t if np.ptp(t) > 0 else np.arange(len(t), dtype=float)
    share: np.ndarray = 2 * (t - t.mean()) / max(float(np.ptp(t)), 1e-9)
    return share
