"""A machine with errors, by exact rotations: a commanded slide position in, the actual tool point
out.

Written from the machine format and the rigid-body conventions, to judge the product: it imports
nothing of it, takes one point at a time and drops nothing that is small. Of the effects beyond the
geometric tables `backlash` is known (lost motion: behind by half of size_um on the side that the
axis came from), every other is refused.

Every error is stored as motion of the tool relative to the workpiece, so the chain is read from the
workpiece to the tool. With E = the error motion of an axis about the point where its translations
were measured,

    E(r) = m + d + R (r - m),

an axis on the tool's side gives "move by q, then E" and an axis on the workpiece's side "E, then
move by q".
"""

import csv
import math
import re
import tomllib
from bisect import bisect_right
from pathlib import Path

import numpy as np

UNIT = {
    "X": np.array([1.0, 0.0, 0.0]),
    "Y": np.array([0.0, 1.0, 0.0]),
    "Z": np.array([0.0, 0.0, 1.0]),
}
TRANSLATIONS, ROTATIONS = "XYZ", "ABC"
UM = 1e-3  # mm
URAD = 1e-6  # rad
IDENTITY = np.eye(4)


def translation(vector):
    """The 4 x 4 transform that moves by `vector`, mm."""
    matrix = IDENTITY.copy()
    matrix[:3, 3] = vector
    return matrix


def rotation(vector):
    """The 4 x 4 transform that turns about `vector` by its length in rad (Rodrigues; exact, no
    order of axes)."""
    a, b, c = map(float, vector)
    angle = math.sqrt(a * a + b * b + c * c)
    if angle == 0.0:
        return IDENTITY.copy()
    a, b, c = a / angle, b / angle, c / angle
    sine, versine = math.sin(angle), 2.0 * math.sin(angle / 2.0) ** 2
    # 1 - cos(angle) would lose all its digits at a few µrad.
    x, y, z = versine * b * c, versine * a * c, versine * a * b
    return np.array(
        [
            [1.0 - versine * (b * b + c * c), z - sine * c, y + sine * b, 0.0],
            [z + sine * c, 1.0 - versine * (a * a + c * c), x - sine * a, 0.0],
            [y - sine * b, x + sine * a, 1.0 - versine * (a * a + b * b), 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def vector_of(table, what):
    """{X = 1.0, Z = 2.0} as (3,) mm; what is not named is 0."""
    unknown = set(table) - set("XYZ")
    if unknown:
        raise ValueError(f"{what} names {sorted(unknown)}; known are X Y Z")
    return np.array([float(table.get(axis, 0.0)) for axis in "XYZ"])


def read_table(path, axis):
    """(nodes, {component: (forward, reverse)}) of an axis table; mm and rad."""
    with open(path, newline="", encoding="utf-8") as file:
        lines = [line for line in file if line.strip() and not line.lstrip().startswith("#")]
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines)]
    if not rows or rows[0][0] != f"{axis}_mm":
        raise ValueError(f"{path}: the first column must be {axis}_mm")
    head, rows = rows[0], rows[1:]
    if len(set(head)) != len(head):
        raise ValueError(f"{path}: a column stands twice")
    for row in rows:
        if len(row) != len(head):
            raise ValueError(f"{path}: {row} has {len(row)} cells, the head {len(head)}")
    nodes = [float(row[0]) for row in rows]
    if not nodes or any(b <= a for a, b in zip(nodes, nodes[1:])):
        raise ValueError(f"{path}: {axis}_mm must ascend")
    found = {}
    for column, name in enumerate(head[1:], start=1):
        match = re.fullmatch(rf"E([XYZABC]){axis}_(um|urad)(_fwd|_rev)?", name)
        if not match or (match[1] in TRANSLATIONS) != (match[2] == "um"):
            raise ValueError(f"{path}: no such column: {name}")
        unit = UM if match[2] == "um" else URAD
        values = [float(row[column]) * unit for row in rows]
        found.setdefault(match[1], {})[match[3] or "both"] = values
    components = {}
    for direction, columns in found.items():
        if set(columns) == {"both"}:
            components[direction] = (columns["both"], columns["both"])
        elif set(columns) == {"_fwd", "_rev"}:
            components[direction] = (columns["_fwd"], columns["_rev"])
        else:
            raise ValueError(f"{path}: E{direction}{axis} needs one column, or _fwd and _rev")
    return nodes, components


def lost_motion(effect, folder):
    """(size, way over which it is taken up), mm, of an [[effect]] backlash."""
    known = {"name", "axis", "size_um", "play_mm", "source"}
    if effect["name"] != "backlash" or set(effect) - known:
        raise ValueError(f"{folder}: the reference knows no effect {effect}")
    return float(effect["size_um"]) * UM, float(effect.get("play_mm", 0.0))


def with_lost_motion(components, axis, nodes, size):
    """The components of an axis, its positioning behind by half of `size` mm on either side."""
    if size == 0.0:
        return components
    forward, reverse = components.get(axis, ([0.0] * len(nodes),) * 2)
    return {**components, axis: ([v - size / 2 for v in forward], [v + size / 2 for v in reverse])}


class Axis:
    """One moving axis: its table, where it was measured, its lean, and on which side of the bed it
    is."""

    def __init__(
        self, name, side, nodes, components, measured_at, lean, travel, least_increment, play_mm=0.0
    ):
        self.name, self.side = name, side
        self.nodes, self.components = nodes, components
        self.measured_at, self.lean = measured_at, lean
        self.way = rotation(lean)[:3, :3] @ UNIT[name]  # along which it goes
        self.travel, self.least_increment = travel, least_increment
        self.play_mm = play_mm  # of the effects: the way after a turn over which they are taken up

    def values(self, position, approach, clamp, margin):
        """{direction: component E<direction><axis>} at a slide position, in mm or rad; linear
        between nodes, held past the ends."""
        first, last = self.nodes[0], self.nodes[-1]
        if not clamp and not first - margin <= position <= last + margin:
            raise ValueError(
                f"{self.name} = {position} mm is outside its table, {first} to {last} mm"
            )
        position = min(max(position, first), last)
        k = bisect_right(self.nodes, position, 0, len(self.nodes) - 1) - 1
        part = (position - self.nodes[k]) / (self.nodes[k + 1] - self.nodes[k])
        found = {}
        for direction, columns in self.components.items():
            forward, reverse = (v[k] + part * (v[k + 1] - v[k]) for v in columns)
            found[direction] = (forward + reverse) / 2.0 + approach * (forward - reverse) / 2.0
        return found

    def moved(self, point, position, approach, clamp, margin):
        """(3,) mm: a point, of the frame nearer to the tool, in the frame nearer to the
        workpiece."""
        found = self.values(position, approach, clamp, margin)
        d = np.array([found.get(name, 0.0) for name in TRANSLATIONS])
        turn = rotation([found.get(name, 0.0) for name in ROTATIONS])[:3, :3]
        way = self.way * position
        if self.side == "tool":
            return way + (self.measured_at + d + turn @ (point - self.measured_at))
        return self.measured_at + d + turn @ (point + way - self.measured_at)


class Machine:
    """The machine of a folder: `axes` (name -> Axis, in chain order), `tool` (3,), `diameter`,
    `offsets`, limits."""

    def __init__(
        self,
        axes,
        tool,
        control="linuxcnc",
        diameter=(),
        offsets=None,
        max_correction=0.5,
        outside="error",
        hysteresis=1.0 * UM,
    ):
        self.axes, self.tool = axes, tool
        self.hysteresis = hysteresis  # mm by which a slide may turn back and keep its side
        self.control, self.diameter, self.offsets = control, tuple(diameter), offsets or {}
        self.max_correction, self.outside = max_correction, outside

    @classmethod
    def load(cls, folder, *, measured_at="stood"):
        """Read `machine.toml` and its tables.

        measured_at = "point": the stated numbers are the point m in the carriage's frame,
        literally. measured_at = "stood" (the contract): they are positions of the other axes, so an
        axis that does not stand between the carriage and the tool (tool's side), or does not carry
        towards it (workpiece's side), gives no arm.
        """
        if measured_at not in ("point", "stood"):
            raise ValueError('measured_at is "point" or "stood"')
        folder = Path(folder)
        facts = tomllib.loads((folder / "machine.toml").read_text(encoding="utf-8"))
        if facts.get("format") != "gcomp-machine/1":
            raise ValueError(f"{folder}: format {facts.get('format')!r} is not gcomp-machine/1")
        links = facts["chain"].split("-")
        if links[0] != "w" or links[-1] != "t" or links.count("b") != 1:
            raise ValueError(f"{folder}: chain {facts['chain']} does not run from w over b to t")
        names = [link for link in links[1:-1] if link != "b"]
        if (
            len(set(names)) != len(names)
            or set(names) - set("XYZ")
            or set(names) != set(facts["axes"])
        ):
            raise ValueError(
                f"{folder}: chain {facts['chain']} and axes {sorted(facts['axes'])} do not fit"
            )
        bed = links.index("b")
        lean = {name: np.zeros(3) for name in names}
        for name, value in facts.get("squareness", {}).items():
            match = re.fullmatch("([ABC])0([XYZ])", name)
            if (
                not match
                or match[2] not in lean
                or ROTATIONS.index(match[1]) == TRANSLATIONS.index(match[2])
            ):
                raise ValueError(f"{folder}: no such squareness: {name}")
            lean[match[2]][ROTATIONS.index(match[1])] += value * URAD
        for effect in facts.get("effect", []):
            if effect.get("axis") not in names:
                raise ValueError(f"{folder}: effect {effect} is on none of the axes {names}")
        axes = {}
        for name in names:
            entry = facts["axes"][name]
            side = "tool" if links.index(name) > bed else "workpiece"
            nodes, components = read_table(folder / entry["table"], name)
            point = vector_of(entry.get("measured_at", {}), f"{folder}: measured_at of {name}")
            if measured_at == "stood":
                after = links[links.index(name) + 1 :]
                point = np.array([v if axis in after else 0.0 for axis, v in zip("XYZ", point)])
            play = [
                lost_motion(effect, folder)
                for effect in facts.get("effect", [])
                if effect.get("axis") == name
            ]
            axes[name] = Axis(
                name,
                side,
                nodes,
                with_lost_motion(components, name, nodes, sum(size for size, _ in play)),
                point,
                lean[name],
                tuple(entry["travel"]) if "travel" in entry else (-math.inf, math.inf),
                float(entry.get("least_increment", 0.0)),
                max((way for _, way in play), default=0.0),
            )
        limits = facts.get("limits", {})
        return cls(
            axes,
            vector_of(facts.get("tool", {}), f"{folder}: tool"),
            facts.get("control", "linuxcnc"),
            facts.get("diameter", ()),
            facts.get("offsets", {}),
            float(limits.get("max_correction", 0.5)),
            limits.get("outside", "error"),
            float(limits.get("hysteresis_um", 1.0)) * UM,
        )

    def nominal(self, command):
        """(3,) mm: where the tool point would be on a machine without errors."""
        point = self.tool.copy()
        for name in self.axes:
            point = point + UNIT[name] * command[name]
        return point

    def actual(self, command, approach, *, clamp=False, margin=0.0):
        """(3,) mm: the actual tool point relative to the workpiece.

        command: {axis: slide position, mm}; approach: {axis: +1, -1, or 0 = mean of both columns,
        or what lies between: on which side of its play the nut is}, absent = 0.
        Past the ends of a table by more than `margin` mm is a ValueError, unless `clamp`; the end
        value is held.
        """
        point = self.tool
        for name, axis in reversed(self.axes.items()):
            point = axis.moved(point, command[name], approach.get(name, 0), clamp, margin)
        return point

    def deviation(self, command, approach, *, clamp=False, margin=0.0):
        """(3,) mm: actual - nominal."""
        return self.actual(command, approach, clamp=clamp, margin=margin) - self.nominal(command)
