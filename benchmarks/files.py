"""The four NC programs that the benchmarks run on, made from a seed: the same seed and length give
the same bytes.

    python benchmarks/files.py DIR [--lines N] [--only a,c]

| file | what | lines for N = 1,000,000 |
|---|---|---|
| a.nc | three-axis surfacing, 95 % of the lines are a bare `X..Y..Z..` | 1,000,010 |
| a2.nc | the same surface, every line `N123 G1 X.. Y.. Z.. F1200` | 1,000,006 |
| b.nc | turning in diameters (G18 G7), a G01 and a G04 by turns | 1,000,005 |
| c.nc | connected arcs, every line `G2 X.. Y.. I.. J..` or G3, a fifth of the length | 200,006 |

a, a2 and c stay inside X 0..400, Y 0..300, Z -100..0; b inside diameter 0..340, Z 0..510 (all mm).
"""

from __future__ import annotations

import argparse
import math
import random
from collections.abc import Callable, Iterator
from itertools import count, islice
from pathlib import Path

import numpy as np

SEED = 20_260
LINES = 1_000_000

# ---- a, a2: a raster over a freeform surface -----------------------------------------------------

ROW_X = (5.0, 395.0)
ROW_Y = (5.0, 295.0)
PITCH = 0.2  # between rows, mm
ROWS = round((ROW_Y[1] - ROW_Y[0]) / PITCH)
ROWS_PER_PASS = 20  # rows between two retracts


def surface(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the part, between -91 and -9 mm; its slope along X stays below 0.66, so that steps
    stay below 1 mm."""
    return -50.0 + 25.0 * np.sin(x / 60.0) + 12.0 * np.cos(y / 33.0) + 4.0 * np.sin((x + y) / 17.0)


def raster(rng: np.random.Generator) -> Iterator[np.ndarray]:
    """The rows of the raster, each (n, 3) in mm, there and back along X; at the far edge the raster
    turns round."""
    for row in count():
        steps = rng.uniform(0.3, 0.75, size=int((ROW_X[1] - ROW_X[0]) / 0.3) + 1)
        x = ROW_X[0] + np.cumsum(steps)
        x = x[x < ROW_X[1]]
        if row % 2:
            x = x[::-1]
        turned = row % (2 * ROWS)
        y = ROW_Y[0] + PITCH * min(turned, 2 * ROWS - turned) + 1.5 * np.sin(x / 30.0)
        yield np.column_stack([x, y, surface(x, y)])


def surfacing_lines(rng: np.random.Generator) -> Iterator[str]:
    """Body of a.nc. Every fifth pass is written with four decimals, as a second post would."""
    number = 0
    for row, points in enumerate(raster(rng)):
        decimals = 4 if row // ROWS_PER_PASS % 5 == 4 else 3
        word = f"%.{decimals}f"
        lines = (f"X{word}Y{word}Z{word}\n" * len(points) % tuple(points.ravel())).splitlines()
        for at in np.flatnonzero(rng.random(len(lines)) < 0.043):
            lines[at] = f"G1{lines[at]}F{rng.choice((800, 1200, 1800))}"
        for at in np.flatnonzero(rng.random(len(lines)) < 0.003):
            x, y, z = points[at]
            lines[at] = f"G1 X{x:.{decimals}f} Z{z:.{decimals}f}"
        if row % ROWS_PER_PASS == 0:
            x, y, z = points[0]
            plunge = [f"X{x:.3f}Y{y:.3f}", f"Z{z + 2.0:.3f}", f"G1Z{z:.3f}F400"]
            lines[:1] = [f"(PASS {row // ROWS_PER_PASS + 1})", "G0Z0.", *plunge]
            lines[5] = lines[5].partition("F")[0] + "F1200"
        for line in lines:
            number += 1
            yield f"N{number}{line}" if number % 1000 == 0 and line[0] != "(" else line


def write_a(lines: int) -> Iterator[str]:
    yield from ("%", "(surfacing)", "G21 G90 G17 G54 G94", "G40 G80", "S12000 M3", "G1 F1200")
    yield from islice(surfacing_lines(np.random.default_rng(SEED)), lines)
    yield from ("G0Z0.", "M5", "M30", "%")


def numbered_lines(rng: np.random.Generator) -> Iterator[str]:
    number = 0
    for points in raster(rng):
        for x, y, z in points.tolist():
            number += 1
            yield f"N{number} G1 X{x:.3f} Y{y:.3f} Z{z:.3f} F1200"


def write_a2(lines: int) -> Iterator[str]:
    yield from ("%", "G21 G90 G17 G54 G94", "S12000 M3")
    yield from islice(numbered_lines(np.random.default_rng(SEED + 1)), lines)
    yield from ("M5", "M30", "%")


# ---- b: turning ----------------------------------------------------------------------------------

# (Z, diameter) of a shaft with tapers, shoulders and a groove, mm.
SHAFT = np.array(
    [
        (2, 290),
        (60, 290),
        (60, 250),
        (130, 238),
        (131, 236),
        (200, 236),
        (200, 180),
        (230, 180),
        (231, 168),
        (236, 168),
        (237, 180),
        (330, 150),
        (330, 96),
        (420, 96),
        (423, 90),
        (490, 90),
        (492, 60),
        (508, 20),
    ],
    dtype=float,
)
STOCK = 25.0  # on diameter, taken off in PASSES passes
PASSES = 40


def turning_lines(rng: np.random.Generator) -> Iterator[str]:
    """Body of b.nc: along the shaft there and back at a falling stock, steps of 0.2 to 1 mm, a
    dwell after each."""
    legs = np.hypot(np.diff(SHAFT[:, 0]), np.diff(SHAFT[:, 1]) / 2.0)
    length = np.concatenate([[0.0], np.cumsum(legs)])
    for turn in count():
        way = np.cumsum(rng.uniform(0.2, 1.0, size=int(length[-1] / 0.2)))
        way = way[way < length[-1]]
        if turn % 2:
            way = way[::-1]
        z = np.interp(way, length, SHAFT[:, 0])
        diameter = np.interp(way, length, SHAFT[:, 1]) + STOCK * (
            1.0 - turn % PASSES / (PASSES - 1)
        )
        dwells = rng.integers(1, 50, size=len(way)) / 100.0
        for x_, z_, dwell in zip(diameter.tolist(), z.tolist(), dwells.tolist(), strict=True):
            yield f"G01 X{x_:.4f} Z{z_:.4f}"
            yield f"G04 P{dwell:g}"


def write_b(lines: int) -> Iterator[str]:
    yield from ("%", "G21 G90 G18 G7 G54 G94", "S800 M3 F200")
    yield from islice(turning_lines(np.random.default_rng(SEED + 2)), lines)
    yield from ("M30", "%")


# ---- c: arcs -------------------------------------------------------------------------------------

ARC_AREA = (2.0, 2.0, 398.0, 298.0)  # every whole circle stays inside


def fits(x: float, y: float, radius: float) -> bool:
    left, low, right, high = ARC_AREA
    return left + radius <= x <= right - radius and low + radius <= y <= high - radius


def arc_lines(rng: random.Random) -> Iterator[str]:
    """Body of c.nc: each arc leaves along the tangent of the last one, unless it would leave the
    area.

    The radius is taken from the printed I and J, so only the rounding of the end point, 0.07 um, is
    left of mismatch.
    """
    x, y, heading = 200.0, 150.0, 0.0
    while True:
        radius = rng.uniform(0.5, 20.0)
        turn = rng.choice((1, -1))  # 1 anticlockwise (G3)
        for _ in range(50):
            side = heading + turn * math.pi / 2.0
            i, j = round(radius * math.cos(side), 4), round(radius * math.sin(side), 4)
            radius = math.hypot(i, j)
            if fits(x + i, y + j, radius):
                break
            radius, turn, heading = max(0.6, radius * 0.8), -turn, heading + rng.uniform(-1.0, 1.0)
        else:
            raise AssertionError(f"no arc fits at {x} {y}")
        start = math.atan2(-j, -i)
        end = start + turn * rng.uniform(0.35, 5.0)
        x, y = round(x + i + radius * math.cos(end), 4), round(y + j + radius * math.sin(end), 4)
        heading = end + turn * math.pi / 2.0
        yield f"G{3 if turn > 0 else 2} X{x:.4f} Y{y:.4f} I{i:.4f} J{j:.4f}"


def write_c(lines: int) -> Iterator[str]:
    yield from ("%", "G21 G90 G91.1 G17 G54 G94", "S12000 M3 F1200", "G0 X200 Y150 Z-10")
    yield from islice(arc_lines(random.Random(SEED + 3)), lines // 5)
    yield from ("M30", "%")


# ---- writing -------------------------------------------------------------------------------------

PROGRAMS: dict[str, Callable[[int], Iterator[str]]] = {
    "a": write_a,
    "a2": write_a2,
    "b": write_b,
    "c": write_c,
}


def write_program(name: str, path: Path, lines: int = LINES) -> None:
    program = PROGRAMS[name](lines)
    unfinished = path.with_suffix(".part")
    with unfinished.open("w", encoding="ascii", newline="") as file:
        while block := list(islice(program, 20_000)):
            file.write("\n".join(block) + "\n")
    unfinished.replace(path)


def names_of(text: str) -> list[str]:
    """The programs of a list such as `a,c`, for argparse."""
    names = text.split(",")
    if unknown := [name for name in names if name not in PROGRAMS]:
        raise argparse.ArgumentTypeError(f"{unknown[0]!r} is not one of {', '.join(PROGRAMS)}")
    return names


def main() -> None:
    parser = argparse.ArgumentParser(description="Write the NC programs of the benchmarks.")
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument(
        "--lines",
        type=int,
        default=LINES,
        help="lines of motion (default %(default)s; c has a fifth)",
    )
    parser.add_argument(
        "--only", type=names_of, default=list(PROGRAMS), metavar="a,c", help="write only these"
    )
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        write_program(name, options.folder / f"{name}.nc", options.lines)


if __name__ == "__main__":
    main()
