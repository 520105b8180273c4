"""Random machines with play on every axis, and random programs for them; the same for the same
number.

Thirty machines: the 24 chains of three slides and six of two (lathes in both dialects). All
components of every axis are smooth waves, the squareness is up to 400 µrad, the play is 3, 12 or 40
µm on every axis, stated in the tables (there it varies along the axis, and some straightness and
angle with it) or as an effect.
"""

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .interpreter import CENTRE_LETTER, PLANES
from .machine import ROTATIONS, TRANSLATIONS
from .samples import write_machine

PLAYS_UM = (3.0, 12.0, 40.0)
TICK = 1e-4  # mm, of programs and machines
TRAVEL = (-30.0, 330.0)
ROOM = (10.0, 290.0)  # mm, where programs go
LATHES = ("w-b-Z-X-t", "w-Z-b-X-t", "w-b-X-Z-t", "w-b-Z-X-t", "w-X-b-Z-t", "w-X-Z-b-t")
MILLS = [
    "-".join(["w", *order[:bed], "b", *order[bed:], "t"])
    for order in itertools.permutations("XYZ")
    for bed in range(4)
]
CHAINS = [chain for six in range(6) for chain in (LATHES[six], *MILLS[six::6])]
# part of the play by which a straightness (µm) and an angle (µrad) depend on the direction
TWO_WAY = 0.05


@dataclass(frozen=True)
class Drawn:
    """A machine that was written."""

    number: int
    folder: Path
    chain: str
    play_um: float
    by: str  # "tables" or "effects"
    dialect: str
    diameter: tuple = ()

    @property
    def axes(self):
        return tuple(link for link in self.chain.split("-") if link in "XYZ")


# Machines -----------------------------------------------------------------------------------------


def wave(rng, nodes, largest):
    """Two sines; together at most `largest`."""
    size = rng.uniform(0.2, 0.5, 2) * largest
    length, phase = rng.uniform(120.0, 500.0, 2), rng.uniform(0.0, 2 * math.pi, 2)
    return sum(a * np.sin(2 * math.pi * nodes / w + p) for a, w, p in zip(size, length, phase))


def axis_table(rng, axis, play_um):
    """The six components of an axis; play_um > 0: its positioning has that lost motion, stated in
    the table."""
    nodes = np.arange(TRAVEL[0], TRAVEL[1] + 1, float(rng.choice([10.0, 15.0, 20.0])))
    nodes[-1] = TRAVEL[1]
    own = play_um * (1 + 0.15 * np.sin(2 * math.pi * nodes / rng.uniform(150.0, 400.0)))
    two_way = {f"E{axis}{axis}_um": -own / 2}
    for name in (
        rng.choice([d for d in TRANSLATIONS if d != axis]) + axis + "_um",
        rng.choice(list(ROTATIONS)) + axis + "_urad",
    ):
        two_way["E" + name] = TWO_WAY / 2 * own
    table = {"nodes": nodes}
    for direction in (*TRANSLATIONS, *ROTATIONS):
        unit, largest = (
            ("um", rng.uniform(3.0, 20.0))
            if direction in TRANSLATIONS
            else ("urad", rng.uniform(5.0, 50.0))
        )
        name, value = f"E{direction}{axis}_{unit}", wave(rng, nodes, largest)
        if play_um and name in two_way:
            table[name + "_fwd"], table[name + "_rev"] = (
                value + two_way[name],
                value - two_way[name],
            )
        else:
            table[name] = value
    return {name: np.round(value, 3) for name, value in table.items()}


def draw_machine(folder, number, play_um=None):
    """Write machine `number` (0 to 29) into a folder of its own below `folder`; returns what it is.

    play_um: another play than the machine's own, 0 for none.
    """
    rng = np.random.default_rng([13, number])
    chain = CHAINS[number]
    play = PLAYS_UM[number % 3] if play_um is None else play_um
    by = ("tables", "effects")[number // 3 % 2]
    axes = [link for link in chain.split("-") if link in "XYZ"]
    fanuc = len(axes) == 2 and number % 2 == 1
    lean = ["C0Y", "B0Z", "A0Z"] if len(axes) == 3 else ["B0X"]
    folder = write_machine(
        Path(folder) / f"machine-{number:02}",
        chain,
        {axis: axis_table(rng, axis, play if by == "tables" else 0.0) for axis in axes},
        measured_at={
            axis: {after: round(rng.uniform(*ROOM)) for after in axes[k + 1 :]}
            for k, axis in enumerate(axes)
        },
        squareness={name: round(rng.uniform(-400.0, 400.0), 1) for name in lean},
        tool={axis: round(rng.uniform(-80.0, 80.0), 1) for axis in axes},
        control="fanuc-lathe" if fanuc else "linuxcnc",
        diameter=["X"] if fanuc else [],
        offsets={"G54": dict.fromkeys(axes, 0.0)},
        travel=TRAVEL,
    )
    if by == "effects" and play:
        with open(folder / "machine.toml", "a") as file:
            for axis in axes:
                file.write(f'\n[[effect]]\nname = "backlash"\naxis = "{axis}"\nsize_um = {play}\n')
    return Drawn(
        number,
        folder,
        chain,
        play,
        by,
        "fanuc-lathe" if fanuc else "linuxcnc",
        ("X",) if fanuc else (),
    )


# Programs -----------------------------------------------------------------------------------------


def draw_program(drawn, number):
    """Program `number` of a machine: 40 to 120 blocks; text."""
    rng = np.random.default_rng([13, drawn.number, number])
    return Writer(rng, drawn).program(int(rng.integers(40, 121)))


class Writer:
    """Writes a program; `at`: where the slides stand, in ticks."""

    def __init__(self, rng, drawn):
        self.rng, self.drawn, self.axes = rng, drawn, sorted(drawn.axes)
        self.planes = [plane for plane, pair in PLANES.items() if set(pair) <= set(self.axes)]
        self.at = dict.fromkeys(self.axes, 0)
        self.lines, self.incremental = [], False

    def program(self, blocks):
        self.plane = self.planes[0]
        self.lines.append(f"G21 G90 G94 {self.plane} G54")
        self.line({axis: self.place() for axis in self.axes}, "G0")
        self.line({self.axes[-1]: self.at[self.axes[-1]] - self.ticks(2, 8)}, "G1", feed=True)
        parts = (
            self.mill, self.mill, self.contour, self.contour, self.to_and_fro, self.small_steps,
            self.increments, self.arcs, self.helix, self.rapids, self.one_axis_alone,
        )  # fmt: skip
        while len(self.lines) < blocks:
            parts[int(self.rng.integers(len(parts)))]()
        self.lines.append("M2" if self.drawn.dialect == "linuxcnc" else "M30")
        return "\n".join(self.lines) + "\n"

    # What a block is made of ----------------------------------------------------------------------

    def ticks(self, low, high):
        return round(self.rng.uniform(low, high) / TICK)

    def place(self):
        return self.ticks(*ROOM)

    def held(self, value):
        return min(max(value, round(ROOM[0] / TICK)), round(ROOM[1] / TICK))

    def near(self, axis, low, high):
        """A place `low` to `high` mm away, on either side."""
        return self.held(self.at[axis] + int(self.rng.choice([-1, 1])) * self.ticks(low, high))

    def word(self, letter, ticks, axis=None):
        if axis in self.drawn.diameter:
            ticks *= 2
        return f"{letter}{ticks * TICK:.4f}"

    def line(self, goal, code="G1", feed=False, extra=()):
        """A motion to `goal`, ticks; axes that are not named rest."""
        words = [code]
        for axis, value in goal.items():
            words.append(
                self.word(axis, value - self.at[axis] if self.incremental else value, axis)
            )
            self.at[axis] = value
        words += extra
        if feed or (code != "G0" and self.rng.random() < 0.1):
            words.append(f"F{int(self.rng.integers(1, 20)) * 50}.")
        self.lines.append(" ".join(words))

    def some(self, largest=None):
        """A choice of the axes, one at least."""
        count = int(self.rng.integers(1, (largest or len(self.axes)) + 1))
        return [str(axis) for axis in self.rng.permutation(self.axes)[:count]]

    def use(self, plane):
        if plane != self.plane:
            self.plane = plane
            self.lines.append(plane)

    def arc(self, radius, sweep, along=None):
        """An arc of `radius` mm over `sweep` rad, + counterclockwise, that stays in the room; else
        nothing."""
        first, second = PLANES[self.plane]
        for _ in range(8):
            angle = self.rng.uniform(0.0, 2 * math.pi)
            i, j = round(-radius * math.cos(angle) / TICK), round(-radius * math.sin(angle) / TICK)
            centre = self.at[first] + i, self.at[second] + j
            if all(ROOM[0] + radius < c * TICK < ROOM[1] - radius for c in centre):
                break
        else:
            return
        end = centre
        if abs(sweep) < 2 * math.pi:
            way = math.atan2(-j, -i) + sweep
            end = tuple(
                round(c + math.hypot(i, j) * part)
                for c, part in zip(centre, (math.cos(way), math.sin(way)))
            )
        goal = dict(zip((first, second), end)) if abs(sweep) < 2 * math.pi else {}
        goal |= along or {}
        extra = [self.word(CENTRE_LETTER[first], i), self.word(CENTRE_LETTER[second], j)]
        self.line(goal, "G3" if sweep > 0 else "G2", extra=extra)

    def sweep(self):
        return float(self.rng.choice([-1, 1])) * (
            2 * math.pi if self.rng.random() < 0.25 else self.rng.uniform(0.2, 5.5)
        )

    # Parts of programs ----------------------------------------------------------------------------

    def mill(self):
        """2.5D: the last axis goes down and rests, the others travel."""
        rest = self.axes[-1]
        others = [axis for axis in self.axes if axis != rest]
        self.line({axis: self.place() for axis in others}, "G0")
        self.line({rest: self.near(rest, 2, 30)})
        for _ in range(int(self.rng.integers(3, 9))):
            if self.rng.random() < 0.25 and len(self.axes) == 3:
                self.use("G17")
                self.arc(self.rng.uniform(2, 40), self.sweep())
            else:
                self.line(
                    {
                        axis: self.near(axis, 1, 120)
                        for axis in others
                        if self.rng.random() < 0.75 or axis == others[0]
                    }
                )
        self.line({rest: self.near(rest, 2, 30)}, "G0")

    def contour(self):
        """Short segments along a smooth curve."""
        count, step = int(self.rng.integers(8, 25)), self.rng.uniform(0.1, 3.0)
        turn, bend = self.rng.uniform(0, 2 * math.pi), self.rng.uniform(-0.5, 0.5)
        a, b = (str(axis) for axis in self.rng.permutation(self.axes)[:2])
        third = [axis for axis in self.axes if axis not in (a, b) and self.rng.random() < 0.4]
        for k in range(count):
            way = {a: step * math.cos(turn + bend * k), b: step * math.sin(turn + bend * k)}
            way |= {axis: 0.2 * step * math.sin(0.5 * k) for axis in third}
            self.line({axis: self.held(self.at[axis] + round(v / TICK)) for axis, v in way.items()})

    def to_and_fro(self):
        """Passes along one axis, a step aside between them."""
        a, b = (str(axis) for axis in self.rng.permutation(self.axes)[:2])
        low, high = sorted((self.place(), self.place()))
        aside = self.ticks(0.05, 4.0) * int(self.rng.choice([-1, 1]))
        for k in range(int(self.rng.integers(3, 8))):
            self.line({a: (low, high)[k % 2]})
            if self.rng.random() < 0.8:
                self.line({b: self.held(self.at[b] + aside)})

    def small_steps(self):
        for _ in range(int(self.rng.integers(4, 10))):
            size = 10 ** self.rng.uniform(-2.5, 0.0)
            self.line({axis: self.near(axis, 0.5 * size, size) for axis in self.some()})

    def increments(self):
        self.lines.append("G91")
        self.incremental = True
        for _ in range(int(self.rng.integers(3, 8))):
            self.line({axis: self.near(axis, 0.05, 40) for axis in self.some()})
        if self.rng.random() < 0.5:
            self.arc(self.rng.uniform(1, 20), self.sweep())
        self.lines.append("G90")
        self.incremental = False

    def arcs(self):
        self.use(str(self.rng.choice(self.planes)))
        for _ in range(int(self.rng.integers(1, 5))):
            self.arc(10 ** self.rng.uniform(0.0, 1.8), self.sweep())

    def helix(self):
        if len(self.axes) < 3:
            return self.arcs()
        self.use(str(self.rng.choice(self.planes)))
        (axis,) = set(self.axes) - set(PLANES[self.plane])
        sign = float(self.rng.choice([-1, 1]))
        for _ in range(int(self.rng.integers(1, 4))):
            self.arc(self.rng.uniform(2, 30), sign * 2 * math.pi, {axis: self.near(axis, 0.2, 6)})

    def rapids(self):
        for _ in range(int(self.rng.integers(1, 4))):
            self.line({axis: self.place() for axis in self.some()}, "G0")

    def one_axis_alone(self):
        """One axis travels far and turns back where another rests."""
        axis = str(self.rng.choice(self.axes))
        for _ in range(int(self.rng.integers(1, 4))):
            self.line({axis: self.place()})
