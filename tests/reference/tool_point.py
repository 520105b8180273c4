"""A five-axis machine with tool centre point control, made up at random, and what its control and
its errors do to a program.

Shares nothing with the product: exact 4 x 4 transforms of the whole chain (ISO 230-1, ISO 841;
tests/reference/kinematics), slides by solving the nominal chain for the tip as such a control does,
errors read from tables of its own, words read by a reader of its own. The folder that the product
is given is written from the same numbers.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from tests.reference.kinematics import Link, tip

UM, URAD = 1e-3, 1e-6
CHAINS = (
    "w-C-A-b-X-Y-Z-t", "w-C-B-b-X-Y-Z-t",  # two tables
    "w-C-b-X-Y-Z-B-t", "w-A-X-b-Y-Z-B-t", "w-C-Y-b-X-Z-A-t",  # a table and a head
    "w-b-X-Y-Z-C-B-t", "w-X-b-Y-Z-C-A-t",  # two heads
)  # fmt: skip
TURN = {"A": 0, "B": 1, "C": 2}
WORD = re.compile(r"([XYZABCF])\s*([-+]?\d*\.?\d+)")


@dataclass
class Truth:
    """The machine: chain, tool point, centre lines, and its errors. table: axis to nodes and six
    columns, mm and rad, and what the reverse direction adds to half of them."""

    chain: str
    tool: np.ndarray
    centre: dict[str, np.ndarray]
    table: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]
    lean: dict[str, np.ndarray]
    shift: dict[str, np.ndarray]
    travel: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def axes(self) -> list[str]:
        return [x for x in self.chain.split("-") if x in "XYZABC"]

    @property
    def rotary(self) -> list[str]:
        return [x for x in self.axes if x in "ABC"]

    def links(
        self,
        pose: dict[str, float],
        sense: dict[str, float] | None = None,
        nominal: bool = False,
    ) -> list[Link]:
        """One per axis; nominal: without its errors, which nobody asks for then."""
        carried = self.chain.split("-").index("b") - 1
        found = []
        for k, x in enumerate(self.axes):
            nodes, mean, half = self.table[x]
            turn = (sense or {}).get(x, 0.0)
            value = (
                np.zeros(6)
                if nominal
                else np.array(
                    [
                        np.interp(pose[x], nodes, m + turn * h)
                        for m, h in zip(mean, half, strict=True)
                    ]
                )
            )
            found.append(
                Link(
                    x,
                    "workpiece" if k < carried else "tool",
                    pose[x],
                    value[:3],
                    value[3:],
                    self.shift[x],
                    self.lean[x],
                    np.zeros(3),
                    self.centre[x],
                )
            )
        return found

    def nominal(self, pose: dict[str, float], length: float = 0.0) -> np.ndarray:
        """(3,) mm of the tip in the part."""
        return tip(self.links(pose, nominal=True), self.tool - [0, 0, length], 0.0)

    def actual(
        self, pose: dict[str, float], length: float, sense: dict[str, float] | None = None
    ) -> np.ndarray:
        """(3,) mm of the tip in the part, with every error."""
        return tip(self.links(pose, sense), self.tool - [0, 0, length], 1.0)

    def axis(self, pose: dict[str, float], scale: float) -> np.ndarray:
        """(3,) direction of the tool in the part."""
        chain = np.eye(4)
        for link in self.links(pose, nominal=scale == 0.0):
            chain = chain @ link.motion(scale)
        return chain[:3, 2]

    def reaches(self, pose: dict[str, float]) -> float:
        """How far the tool turns at least, whichever way, rad per rad of the rotary axes
        together."""
        step = 0.01
        ways = [
            (self.axis({**pose, x: pose[x] + step}, 0.0) - self.axis(pose, 0.0)) / np.radians(step)
            for x in self.rotary
        ]
        return float(np.linalg.svd(np.stack(ways), compute_uv=False)[-1])

    def slides(
        self, place: np.ndarray, angles: dict[str, float], length: float
    ) -> dict[str, float]:
        """The pose in which the nominal control holds the tip at `place` (3,) mm of the part."""
        rest = {**dict.fromkeys("XYZ", 0.0), **angles}
        zero = self.nominal(rest, length)
        ways = np.stack([self.nominal({**rest, x: 1.0}, length) - zero for x in "XYZ"], axis=1)
        return {
            **rest,
            **dict(zip("XYZ", np.linalg.solve(ways, place - zero).tolist(), strict=True)),
        }

    def write(self, folder: Path, control: str = "linuxcnc", more: str = "") -> Path:
        """The folder gcomp-machine/1."""
        lines = [
            'format = "gcomp-machine/1"',
            'name = "random"',
            f'control = "{control}"',
            f'chain = "{self.chain}"',
        ]
        for x in self.axes:
            low, high = self.travel[x]
            lines += [
                f"[axes.{x}]",
                f"travel = [{low}, {high}]",
                "least_increment = 0.0001",
                f'table = "{x}.csv"',
            ]
            if x in TURN:
                centre = ", ".join(
                    f"{d} = {float(self.centre[x][i])!r}"
                    for i, d in enumerate("XYZ")
                    if i != TURN[x]
                )
                lines.append(f"centre = {{ {centre} }}")
        square = [
            f"{'ABC'[i]}0{x} = {float(v[i] / URAD)!r}"
            for x, v in self.lean.items()
            for i in range(3)
            if v[i]
        ]
        shift = [
            f"{'XYZ'[i]}0{x}_um = {float(v[i] / UM)!r}"
            for x, v in self.shift.items()
            for i in range(3)
            if v[i]
        ]
        lines += ["[squareness]", *square, "[location]", *shift, "[tool]"]
        lines += [f"{d} = {float(self.tool[i])!r}" for i, d in enumerate("XYZ")]
        lines += ["[offsets]", "G54 = { X = 0.0, Y = 0.0, Z = 0.0 }", more]
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "machine.toml").write_text("\n".join(lines) + "\n")
        for x, (nodes, mean, half) in self.table.items():
            unit = "deg" if x in TURN else "mm"
            names = [f"E{c}{x}_um" for c in "XYZ"] + [f"E{c}{x}_urad" for c in "ABC"]
            scale = np.array([UM] * 3 + [URAD] * 3)[:, None]
            columns = []
            for k, name in enumerate(names):
                if half[k].any():
                    columns += [
                        (name + "_fwd", (mean[k] + half[k]) / scale[k]),
                        (name + "_rev", (mean[k] - half[k]) / scale[k]),
                    ]
                else:
                    columns.append((name, mean[k] / scale[k]))
            rows = [",".join([f"{x}_{unit}", *(n for n, _ in columns)])]
            rows += [
                ",".join([repr(float(n)), *(repr(float(c[i])) for _, c in columns)])
                for i, n in enumerate(nodes)
            ]
            (folder / f"{x}.csv").write_text("\n".join(rows) + "\n")
        return folder


def random_truth(
    rng: np.random.Generator, chain: str, play: float = 0.0, size: float = 1.0
) -> Truth:
    """A machine of this chain: 15 um and 20 urad of errors, `play` mm of lost motion in every
    slide."""
    axes = [x for x in chain.split("-") if x in "XYZABC"]
    carried = axes[: chain.split("-").index("b") - 1]
    tool = np.array([0.0, 0.0, -float(rng.integers(100, 200))])
    centre, table, lean, shift, travel = {}, {}, {}, {}, {}
    for x in axes:
        turning = x in TURN
        travel[x] = (-400.0, 400.0) if turning else (-900.0, 900.0)
        count = 33 if turning else 19
        nodes = np.linspace(*travel[x], count)
        mean = np.concatenate(
            [rng.normal(0, 5 * UM * size, (3, count)), rng.normal(0, 7 * URAD * size, (3, count))]
        )
        smooth = np.array([0.25, 0.5, 0.25])
        mean = np.stack([np.convolve(np.pad(m, 1, "edge"), smooth, "valid") for m in mean])
        half = np.zeros_like(mean)
        if not turning and play:
            half["XYZ".index(x)] = -play / 2 * rng.uniform(0.7, 1.3)
        table[x] = nodes, mean, half
        own = TURN[x] if turning else "XYZ".index(x)
        lean[x] = np.where(np.arange(3) == own, 0.0, rng.normal(0, 15 * URAD * size, 3))
        shift[x] = (
            np.where(np.arange(3) == own, 0.0, rng.normal(0, 8 * UM * size, 3))
            if turning
            else np.zeros(3)
        )
        where = (
            rng.uniform(-60, 60, 3).round(2)
            if x in carried
            else np.array([0.0, 0.0, float(rng.uniform(20, 80).__round__(2))])
        )
        centre[x] = np.where(np.arange(3) == own, 0.0, where) if turning else np.zeros(3)
    return Truth(chain, tool, centre, table, lean, shift, travel)


def random_program(
    rng: np.random.Generator, rotary: list[str], on: str, off: str, blocks: int = 4
) -> str:
    """Feeds with rotary axes, under the tool point."""
    zero = " ".join(f"{x}0." for x in rotary)
    lines = ["G90 G54 G17", f"G0 X0. Y0. Z50. {zero}", *on.splitlines(), "G0 X0. Y0. Z50."]
    for k in range(blocks):
        words = [f"{x}{rng.uniform(-60, 60):.3f}" for x in "XYZ"]
        words += [f"{x}{rng.uniform(-75, 75):.3f}" for x in rotary]
        drop = set(rng.choice(len(words), int(rng.integers(0, 3)), replace=False).tolist())
        lines.append(
            "G1 "
            + " ".join(w for i, w in enumerate(words) if i not in drop)
            + (" F500." if not k else "")
        )
    numbered = [f"N{10 * (k + 1)} {line}" for k, line in enumerate([*lines, off, "M30"])]
    return "\n".join(numbered) + "\n"


def read(text: str, on: str, off: str) -> list[tuple[bool, bool, dict[str, float], str]]:
    """Of each block with axis words: whether the tool point is on, whether it feeds, the words in
    force, and the number of the block, or of the last numbered one before it, of which it is a
    part."""
    here: dict[str, float] = dict.fromkeys("XYZABC", 0.0)
    tip_on = feed = False
    number, found = "", []
    for line in re.sub(r"\([^)]*\)|;.*", "", text).splitlines():
        if off and re.search(rf"\b{re.escape(off)}(?![.\d])", line):
            tip_on = False
        if re.search(rf"{re.escape(on)}(?![.\d])", line):
            tip_on = True
        numbers = re.findall(r"^\s*N(\d+)", line)
        number = numbers[0] if numbers else number
        codes = re.findall(r"G0*([01])(?![\d.])", line)
        feed = {"0": False, "1": True}[codes[-1]] if codes else feed
        words = WORD.findall(re.sub(r"G\d+(\.\d+)?", " ", line))
        if any(x in "XYZABC" for x, _ in words):
            here = {**here, **{x: float(v) for x, v in words if x != "F"}}
            found.append((tip_on, feed, here, number))
    return found


@dataclass
class Judged:
    """The largest distance of the tip, mm, and lean of the tool, rad, with the program and with the
    nominal one."""

    tip: float = 0.0
    lean: float = 0.0
    tip_before: float = 0.0
    lean_before: float = 0.0


def judge(
    truth: Truth,
    nominal: str,
    output: str,
    on: str,
    off: str,
    length: float = 0.0,
    turned: bool = False,
) -> Judged:
    """Run the output on the erroneous machine, with the control's own nominal kinematics, and
    measure it against the nominal program's tip path in the part. Each output block is sampled; how
    far the nominal program is follows from the rotary axes where they turn, from the way elsewhere;
    `turned`: from the way always, since rotary words are corrected too, and the lean is judged.
    Feeds that begin and end with the tool point on count."""
    result = Judged()
    wanted, written = read(nominal, on, off), read(output, on, off)
    stroke = {number: k for k, (_, _, _, number) in enumerate(wanted)}
    for (on0, _, begin, _), (on1, feed, end, number) in zip(written[:-1], written[1:], strict=True):
        if not (on0 and on1 and feed):
            continue
        low, high = wanted[stroke[number] - 1][2], wanted[stroke[number]][2]
        for share in (0.0, 0.21, 0.48, 0.77, 1.0):
            at = {x: begin[x] + (end[x] - begin[x]) * share for x in begin}
            _measure(truth, result, at, low, high, length, turned)
    return result


def _measure(truth: Truth, result: Judged, at, low, high, length: float, turned: bool) -> None:
    """One place `at` of the output, against the nominal stroke from low to high."""
    pose = truth.slides(
        np.array([at[x] for x in "XYZ"]) + truth.tool, {x: at[x] for x in truth.rotary}, length
    )
    tip = truth.actual(pose, length)
    t = _progress(low, high, at, tip - truth.tool, [] if turned else truth.rotary)
    should = {x: low[x] + (high[x] - low[x]) * t for x in low}
    place = np.array([should[x] for x in "XYZ"]) + truth.tool
    right = truth.slides(place, {x: should[x] for x in truth.rotary}, length)
    result.tip = max(result.tip, float(np.linalg.norm(tip - place)))
    result.tip_before = max(
        result.tip_before, float(np.linalg.norm(truth.actual(right, length) - place))
    )
    # near a pole the rotary axes can not turn the tool any way
    if not turned or truth.reaches(right) < 0.1:
        return
    axis = truth.axis(right, 0.0)
    way = max(float(np.linalg.norm([high[x] - low[x] for x in "XYZ"])), 0.001)
    ahead = {x: low[x] + (high[x] - low[x]) * (t + 0.001 / way) for x in low}
    turn = truth.axis({**right, **ahead}, 0.0) - axis  # of the nominal tool over 1 um of the way
    off = truth.axis(pose, 1.0) - axis  # where the tip is behind on its path the tool may be so too
    off = off - turn * np.clip(off @ turn / max(turn @ turn, 1e-30), -1, 1)
    result.lean = max(result.lean, float(np.linalg.norm(off)))
    result.lean_before = max(
        result.lean_before, float(np.linalg.norm(np.cross(truth.axis(right, 1.0), axis)))
    )


def _progress(low, high, at, tip: np.ndarray, rotary) -> float:
    """How far the nominal stroke is: by the axis that turns most, or, where none turns, by the
    place nearest to the tip."""
    turning = max(rotary, key=lambda x: abs(high[x] - low[x]), default="X")
    if rotary and abs(high[turning] - low[turning]) > 0.5:
        return (at[turning] - low[turning]) / (high[turning] - low[turning])
    way = np.array([high[x] - low[x] for x in "XYZ"])
    return float(np.clip((tip - [low[x] for x in "XYZ"]) @ way / max(way @ way, 1e-30), 0, 1))


def played(truth: Truth, nominal: str, output: str, on: str, off: str, length: float) -> np.ndarray:
    """(K,) mm from the nominal tip path along the output's feeds, each slide led through its play:
    it stands at the nearest place of command +- half the play to where it stood."""
    wanted, written = read(nominal, on, off), read(output, on, off)
    stroke = {number: k for k, (_, _, _, number) in enumerate(wanted)}
    stands: dict[str, float] = {}
    result = []

    def lead(pose: dict[str, float]) -> None:
        for x in "XYZ":
            half = abs(float(truth.table[x][2]["XYZ".index(x), 0]))
            stands[x] = min(max(stands.get(x, pose[x]), pose[x] - half), pose[x] + half)

    def held(at: dict[str, float]) -> dict[str, float]:
        return truth.slides(
            np.array([at[x] for x in "XYZ"]) + truth.tool, {x: at[x] for x in truth.rotary}, length
        )

    for (on0, _, begin, _), (on1, feed, end, number) in pairwise([(False, False, {}, 0), *written]):
        if not (on0 and on1):
            lead(held(end) if on1 else end)
            continue
        low, high = wanted[stroke[number] - 1][2], wanted[stroke[number]][2]
        for share in (0.25, 0.5, 0.75, 1.0):
            at = {x: begin[x] + (end[x] - begin[x]) * share for x in begin}
            pose = held(at)
            lead(pose)
            if feed:
                tip = truth.actual({**pose, **stands}, length)
                t = _progress(low, high, at, tip - truth.tool, truth.rotary)
                place = np.array([low[x] + (high[x] - low[x]) * t for x in "XYZ"]) + truth.tool
                result.append(float(np.linalg.norm(tip - place)))
    return np.array(result)
