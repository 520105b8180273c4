"""Machines that are known, and what a laser would read on them. Written from the rigid-body
equation of the contract with numpy alone; nothing of the package under test computes a truth here,
it only carries the recordings.

reading(q) = n . (d(q) + eps(q) x (p + the others' positions in the arm - m)) + set-up zero + set-up
slope q + noise
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from postproc.recordings import Recording

UM, URAD = 1e-3, 1e-6
XYZ = "XYZ"


@dataclass
class Slide:
    """One axis of a known machine: targets (K,) mm; forward, reverse: component to (K,) um or urad;
    arm: the other axes that count; measured_at: mm, where `forward` and `reverse` hold."""

    letter: str
    targets: np.ndarray
    forward: dict[str, np.ndarray]
    reverse: dict[str, np.ndarray]
    arm: tuple[str, ...] = ()
    measured_at: dict[str, float] = field(default_factory=dict)

    def vector(self, kind: str, way: int, q: np.ndarray) -> np.ndarray:
        """(3, N) mm ("E") or rad ("EA") at positions q, approached in `way`."""
        names = [f"E{i}{self.letter}" for i in (XYZ if kind == "E" else "ABC")]
        one = UM if kind == "E" else URAD
        side = self.forward if way > 0 else self.reverse
        return np.stack(
            [
                one * np.interp(q, self.targets, side.get(n, np.zeros(len(self.targets))))
                for n in names
            ]
        )

    def lateral(self, way: int, q: np.ndarray, rest: dict[str, float]) -> np.ndarray:
        """(3, N) mm: translations at positions q while the others stand at `rest`."""
        away = np.array(
            [rest[x] - self.measured_at.get(x, 0.0) if x in self.arm else 0.0 for x in XYZ]
        )
        return self.vector("E", way, q) + np.cross(self.vector("EA", way, q), away[:, None], axis=0)


def wave(rng, targets: np.ndarray, size: float, waves: int = 3) -> np.ndarray:
    """A smooth curve of about `size`, zero nowhere in particular."""
    t = (targets - targets[0]) / np.ptp(targets)
    return sum(
        size / (k + 1) * np.sin(np.pi * (k + 1) * t * rng.uniform(0.7, 1.3) + rng.uniform(0, 6))
        for k in range(waves)
    )


def slide(rng, letter, targets, names, arm=(), measured_at=None, reversal=2.0) -> Slide:
    """A made-up axis: 8 um or 15 urad, with a reversal that is not the same everywhere."""
    forward, reverse = {}, {}
    for name in names:
        size = 8.0 if name[1] in XYZ else 15.0
        forward[name] = wave(rng, targets, size)
        reverse[name] = forward[name] + reversal * (1 + 0.3 * wave(rng, targets, 1.0))
    return Slide(letter, targets, forward, reverse, arm, measured_at or {})


def two_axes(rng) -> dict[str, Slide]:
    """w-b-Z-X-t: Z carries X."""
    return {
        "Z": slide(rng, "Z", np.linspace(0, 510, 18), ("EXZ", "EZZ", "EBZ"), ("X",), {"X": 30.0}),
        "X": slide(rng, "X", np.linspace(-10, 170, 13), ("EXX", "EZX")),
    }


def three_axes(rng) -> dict[str, Slide]:
    """w-X-Y-b-Z-t, all 18 components; X and Y carry the table."""

    def names(x):
        return tuple(f"E{i}{x}" for i in "XYZABC")

    return {
        "X": slide(
            rng, "X", np.linspace(0, 400, 11), names("X"), ("Y", "Z"), {"Y": 100.0, "Z": 50.0}
        ),
        "Y": slide(rng, "Y", np.linspace(0, 300, 9), names("Y"), ("Z",), {"Z": 80.0}),
        "Z": slide(rng, "Z", np.linspace(-200, 0, 9), names("Z"), (), {}),
    }


def recording(
    rng,
    axis: Slide,
    component: str,
    rest: dict[str, float],
    runs=5,
    noise=0.3,
    u=None,
    ways=(1, -1),
    file="",
    aligned=False,
    **head,
) -> Recording:
    """Targets up and down, `runs` times. noise: um or urad; aligned: no slope of the set-up."""
    letter, direction = axis.letter, component[1]
    angle = direction in "ABC"
    position, approach, run, reading = [], [], [], []
    zero, slope = (
        rng.normal(0, 20),
        0.0 if angle or direction == letter or aligned else rng.normal(0, 40),
    )
    for j in range(runs):
        for way in ways:
            q = axis.targets if way > 0 else axis.targets[::-1]
            if angle:
                true = axis.vector("EA", way, q)["ABC".index(direction)] / URAD
            else:
                true = axis.lateral(way, q, rest)[XYZ.index(direction)] / UM
            position.append(q)
            approach.append(np.full(len(q), float(way)))
            run.append(np.full(len(q), j + 1.0))
            reading.append(true + zero + slope * 1e-3 * q + rng.normal(0, noise, len(q)))
    places = {
        f"{x}_mm": np.full(len(axis.targets) * runs * len(ways), at) for x, at in rest.items()
    }
    places[f"{letter}_mm"] = np.concatenate(position)
    columns = {
        "run": np.concatenate(run),
        "t_s": 10.0 * np.arange(len(places[f"{letter}_mm"])),
    } | places
    columns[f"approach_{letter}"] = np.concatenate(approach)
    columns["reading_urad" if angle else "reading_um"] = np.concatenate(reading)
    quantity = "angle" if angle else "displacement" if direction == letter else "straightness"
    sensitive = {XYZ["ABC".index(direction)] if angle else direction: 1.0}
    text = {"quantity": quantity, "sensitive": sensitive, "control_tables": "off"} | head
    if u is not None:
        text["u_um"] = u
    return Recording(
        "targets", text, columns, file or f"{component}.csv", np.arange(len(columns["run"])) + 10
    )


def everything(rng, machine: dict[str, Slide], rest: dict[str, float], **how) -> list[Recording]:
    """A recording of every component, the other axes at `rest`."""
    return [
        recording(rng, axis, name, {x: at for x, at in rest.items() if x != axis.letter}, **how)
        for axis in machine.values()
        for name in axis.forward
    ]


def truth(axis: Slide, component: str, rest: dict[str, float], lined=True, datum=0.0) -> np.ndarray:
    """(2, K) um or urad: what a perfect calibration gives at the targets: as seen from `rest`,
    straightnesses about the least-squares line of the mean of both directions, that mean zero at
    the datum."""
    q, direction = axis.targets, component[1]
    if direction in "ABC":
        value = (
            np.stack([axis.vector("EA", way, q)["ABC".index(direction)] for way in (1, -1)]) / URAD
        )
    else:
        value = np.stack([axis.lateral(way, q, rest)[XYZ.index(direction)] for way in (1, -1)]) / UM
        if direction != axis.letter and lined:
            a = np.column_stack([q, np.ones(len(q))])
            value = value - a @ np.linalg.solve(a.T @ a, a.T @ value.mean(axis=0))
    return value - np.interp(datum, q, value.mean(axis=0))


def coverage(
    make, chain, rest, options, calibrate, trials: int, seed: int, **how
) -> tuple[int, int, float, float]:
    """Values within 2 u, values in all, root mean square of the normalised error, mean u; over
    `trials` machines."""
    rng = np.random.default_rng(seed)
    inside = count = 0
    square = sum_u = 0.0
    for _ in range(trials):
        machine = make(rng)
        calibration = calibrate(everything(rng, machine, rest, **how), options)
        for name, component in calibration.components.items():
            one = URAD if name[1] in "ABC" else UM
            others = {x: at for x, at in rest.items() if x != component.letter}
            off = component.value / one - truth(machine[component.letter], name, others)
            u = component.u / one
            inside += int((np.abs(off) <= 2 * u).sum())
            count += off.size
            square += float(((off / u) ** 2).sum())
            sum_u += float(u.sum())
    return inside, count, (square / count) ** 0.5, sum_u / count
