"""Machines as drawn: two-axis grinders and lathes, three-axis mills; the map that the user has, and
how it is wrong.

The true geometry is the user's map plus smooth random curves of the size that the map's source
states. Lengths mm, deviations um, rotations urad; deviation = actual - commanded, tool relative to
workpiece.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from proof.generator.streams import log_uniform

XYZ, ABC = "XYZ", "ABC"
WAVES = 3  # half waves of an error of the map, each with sine and cosine


@dataclass(frozen=True)
class Axis:
    letter: str
    low: float
    high: float
    least: float
    velocity: float  # mm/min
    acceleration: float  # mm/s2
    measured_at: dict[str, float]
    nodes: np.ndarray
    # component to forward, reverse; the same array where one-way
    tables: dict[str, tuple[np.ndarray, np.ndarray]]
    screw_lead: float

    @property
    def length(self) -> float:
        return self.high - self.low

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2

    def share(self, u: float) -> float:
        """The position at a share of the travel, rounded as a person would type it."""
        return round(self.low + u * self.length, 1)


@dataclass(frozen=True)
class Machine:
    form: str
    name: str
    title: str
    control: str
    chain: str
    axes: dict[str, Axis]
    square: dict[str, float]
    tool: dict[str, float]
    stated_um: float  # standard uncertainty of the map, in its source
    # component to (2 WAVES,) um or urad
    errors: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def letters(self) -> str:
        return "".join(self.axes)

    @property
    def order(self) -> tuple[list[str], int]:
        """Axes from the workpiece to the tool, and how many of them carry the workpiece."""
        parts = self.chain.split("-")
        return [p for p in parts if p in XYZ], parts.index("b") - 1

    def column(self, component: str, position: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """What the user's map says: linear between nodes, of the direction in which the axis last
        moved."""
        axis = self.axes[component[2]]
        forward, reverse = axis.tables[component]
        up = np.interp(position, axis.nodes, forward)
        if forward is reverse:
            return up
        return np.where(direction > 0, up, np.interp(position, axis.nodes, reverse))

    def waves(self, letter: str, position: np.ndarray) -> np.ndarray:
        """(2 WAVES, N): the curves of which errors of the map are made."""
        axis = self.axes[letter]
        phase = np.pi * (position - axis.low) / axis.length
        return np.array([f(h * phase) for h in range(1, WAVES + 1) for f in (np.cos, np.sin)])

    def components(self) -> list[str]:
        return [c for axis in self.axes.values() for c in axis.tables]

    def lean(self, name: str, position: np.ndarray) -> np.ndarray:
        """(N, 3) um for one urad of a squareness such as C0Y: a small turn of the axis that
        leans."""
        turn, along = np.zeros(3), np.zeros((len(position), 3))
        turn[ABC.index(name[0])] = 1e-3
        along[:, XYZ.index(name[2])] = position[:, XYZ.index(name[2])]
        return np.cross(turn, along)

    def carry(self, component: str, value: np.ndarray, position: np.ndarray) -> np.ndarray:
        """(N, 3) um at the tool of one component (N,) at positions (N, 3): a rotation acts with its
        arm."""
        result = np.zeros((len(value), 3))
        if component[1] in XYZ:
            result[:, XYZ.index(component[1])] = value
            return result
        order, carrying = self.order
        at = order.index(component[2])
        arm = np.tile(
            [self.tool.get(x, 0.0) - self.axes[component[2]].measured_at.get(x, 0.0) for x in XYZ],
            (len(value), 1),
        )
        for other in order[at if at < carrying else at + 1 :]:
            arm[:, XYZ.index(other)] += position[:, XYZ.index(other)]
        turn = np.zeros((len(value), 3))
        turn[:, ABC.index(component[1])] = value * 1e-3
        return np.cross(turn, arm)

    def deviation(
        self, position: np.ndarray, direction: np.ndarray, known: bool = False
    ) -> np.ndarray:
        """(N, 3) um of the true geometry, or of the map only."""
        total = np.zeros(position.shape)
        for component in self.components():
            i = XYZ.index(component[2])
            value = self.column(component, position[:, i], direction[:, i])
            if not known:
                value = value + self.errors[component] @ self.waves(component[2], position[:, i])
            total += self.carry(component, value, position)
        for name, angle in self.square.items():
            total += (angle + (0.0 if known else self.errors[name][0])) * self.lean(name, position)
        return total

    def rotation(self, position: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """(N, 3) urad, the sum over the axes."""
        total = np.zeros(position.shape)
        for component in self.components():
            if component[1] in ABC:
                i = XYZ.index(component[2])
                value = self.column(component, position[:, i], direction[:, i])
                value = value + self.errors[component] @ self.waves(component[2], position[:, i])
                total[:, ABC.index(component[1])] += value
        return total


def draw(rng: np.random.Generator, masked: bool = False) -> Machine:
    """A machine and its map. masked: positioning errors of 80 to 110 um, so that they hide 2 to 8
    um tenfold."""
    form = str(rng.choice(["grinder", "lathe", "mill"], p=[0.28, 0.27, 0.45]))
    size = log_uniform(rng, 8.0, 100.0)
    if masked:
        size = rng.uniform(80.0, 110.0)
    number = int(rng.integers(100, 1000))
    least = float(rng.choice([0.001, 0.0001], p=[0.3, 0.7]))
    fast = bool(rng.random() < 0.5)
    turning = bool(rng.random() < (0.28 if form == "mill" else 0.75))
    if form == "mill":
        spans = {
            "X": _round(rng.uniform(400, 1000)),
            "Y": _round(rng.uniform(250, 600)),
            "Z": _round(rng.uniform(200, 500)),
        }
        chain = str(rng.choice(["w-b-X-Y-Z-t", "w-X-b-Y-Z-t", "w-X-Y-b-Z-t", "w-Y-b-X-Z-t"]))
        control = str(rng.choice(["fanuc-mill", "linuxcnc", "haas", "siemens", "heidenhain-iso"]))
        title, square = "Three-axis milling machine", {"C0Y": rng.normal(0, 40)}
        if rng.random() < 0.5:
            square |= {"B0Z": rng.normal(0, 30), "A0Z": rng.normal(0, 30)}
        place = str(rng.choice(["zero", "middle"], p=[0.7, 0.3]))
        # a rotation of a mill acts with the arm of the third axis: the plane of the tests is where
        # that arm is zero
        lows = {x: 0.0 if place == "zero" else -spans[x] / 2 for x in "XY"} | {
            "Z": -spans["Z"] if turning else 0.0
        }
        tool = {}
    else:
        spans = {"X": _round(rng.uniform(150, 280)), "Z": _round(rng.uniform(300, 1000))}
        chain, control = "w-b-Z-X-t", "fanuc-lathe"
        title = "Two-axis cylindrical grinder" if form == "grinder" else "Two-axis lathe"
        square = {"B0X": rng.normal(0, 60)}
        lows = {x: float(rng.choice([0.0, -5.0])) for x in "XZ"}
        tool = {"X": 20.0, "Z": 40.0} if rng.random() < 0.3 else {}
    axes = {}
    for x, span in spans.items():
        at = {}
        if turning and form != "mill" and x == "Z":
            at = {"X": round(lows["X"] + float(rng.choice([0.0, 0.5])) * spans["X"], 1)}
        axes[x] = _axis(
            rng, x, lows[x], lows[x] + span, least, fast, at, size, "".join(spans), turning, masked
        )
    return Machine(
        form,
        f"{form}-{number}",
        title,
        control,
        chain,
        axes,
        {k: float(np.round(v, 3)) for k, v in square.items()},
        tool,
        round(float(rng.uniform(0.2, 0.45)), 2),
    )


def _round(value: float) -> float:
    return float(10 * round(value / 10))


def _axis(rng, x, low, high, least, fast, at, size, letters, turning, masked) -> Axis:
    step = next(s for s in (10.0, 20.0, 25.0, 30.0, 50.0) if (high - low) / s <= 42)
    nodes = low + step * np.arange(int(np.ceil((high - low) / step)) + 1)
    nodes[-1] = max(high, nodes[-2] + 1.0) if nodes[-1] > high + 1e-9 else nodes[-1]
    u = (nodes - low) / (high - low)
    tables: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    reach = size * (1.0 if masked else min(1.0, (high - low) / 250.0) * rng.uniform(0.6, 1.0))
    own = _smooth(rng, u, reach)
    gap = rng.uniform(0.6, 4.0) * (
        1 + 0.3 * np.sin(np.pi * u * rng.uniform(0.5, 2) + rng.uniform(0, 6))
    )
    tables[f"E{x}{x}"] = (np.round(own - gap / 2, 3), np.round(own + gap / 2, 3))  # a slide lags
    for other in letters:
        if other == x:
            continue
        bend = _smooth(rng, u, log_uniform(rng, 1.5, 9.0))
        if rng.random() < 0.2:
            lost = rng.uniform(0.3, 1.5)
            tables[f"E{other}{x}"] = (np.round(bend + lost / 2, 3), np.round(bend - lost / 2, 3))
        else:
            bend = np.round(bend, 3)
            tables[f"E{other}{x}"] = (bend, bend)
    if turning and (len(letters) == 3 or x == "Z"):
        for turn in "ABC" if len(letters) == 3 else "B":
            value = np.round(
                _smooth(
                    rng, u, log_uniform(rng, 8.0, 45.0) if len(letters) == 2 else rng.uniform(3, 12)
                ),
                3,
            )
            tables[f"E{turn}{x}"] = (value, value)
    return Axis(
        x,
        low,
        high,
        least,
        float(rng.choice([12000.0, 15000.0, 20000.0] if fast else [8000.0, 10000.0])),
        float(rng.choice([1500.0, 2500.0])),
        at,
        nodes,
        tables,
        float(rng.choice([5.0, 8.0, 10.0, 12.0, 16.0, 20.0])),
    )


def _smooth(rng, u: np.ndarray, reach: float) -> np.ndarray:
    """A curve from zero whose range is `reach`: a line, an arch and some waves."""
    value = rng.normal(0, 1) * u
    for h in (1, 2, 3, 4):
        value = value + rng.normal(0, 0.7 / h) * np.sin(np.pi * h * u + rng.uniform(0, 2 * np.pi))
    value = value - value[0]
    return value * reach / max(np.ptp(value), 1e-9)


def errors_of(
    machine: Machine, rng: np.random.Generator, factor: float = 1.0
) -> dict[str, np.ndarray]:
    """How the map is wrong: of the stated size, or `factor` times it."""
    size = machine.stated_um * factor / np.sqrt(WAVES)
    found = {c: rng.normal(0, size, 2 * WAVES) for c in machine.components()}
    return found | {
        name: rng.normal(0, 2 * machine.stated_um * factor, 1) for name in machine.square
    }
