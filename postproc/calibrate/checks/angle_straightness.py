"""A carriage that follows its rail points along it: its angle, integrated, is its straightness but
for a line.

After Ekinci and Mayer (the thesis' reference 22): a negative correlation means that the sign of one
of them is turned, an angle that predicts many times the curvature that was read is in another unit.
A rail's short waves, which a long carriage averages out, lower the correlation without meaning
anything.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component
from postproc.machine.chain import XYZ
from postproc.machine.tables import COMPONENTS
from postproc.units import UM

TURNED, FOLLOWS, TOO_MUCH = -0.5, 0.5, 3.0
FEEBLE = 0.15  # of what was read: a path that explains less agrees or not by chance
FEWEST = 5


def check(calibration: Calibration) -> Iterator[Finding]:
    for letter in [x for x in calibration.options.chain.axes if x in XYZ]:
        for turn in range(3):
            own = XYZ.index(letter)
            if turn == own:
                continue
            across = 3 - own - turn
            angle = calibration.measured.get(f"{COMPONENTS[3 + turn]}{letter}")
            straight = calibration.measured.get(f"E{XYZ[across]}{letter}")
            if angle is None or straight is None:
                continue
            # eps x u_own points along `across` with this sign; seen from the workpiece's side both
            # turn round.
            sign = 1.0 if (turn + 1) % 3 == own else -1.0
            yield from _compare(calibration, letter, angle, straight, sign)


def _paths(
    calibration: Calibration, letter: str, angle: Component, straight: Component, sign: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """The straightness as it was read and as the angle makes it, mm, lines off both, in + and -
    where both were measured so; none where too little was."""
    # only where both were measured: an integral beyond the angle's own targets would be invented
    low, high = max(angle.nodes[0], straight.nodes[0]), min(angle.nodes[-1], straight.nodes[-1])
    nodes = np.unique(np.concatenate([angle.nodes, straight.nodes]))
    nodes = nodes[(nodes >= low) & (nodes <= high)]
    if len(nodes) < FEWEST or not np.any(angle.value) or not np.any(straight.value):
        return []
    both = angle.two_way and straight.two_way
    means = [c.value if both else [c.mean] for c in (angle, straight)]
    pairs = []
    on_table = calibration.options.chain.side(letter) == "workpiece"
    # of a point that stays on the table, whose path the rail makes
    stays = on_table and calibration.optics.get(letter) == "tool"
    for turns, reads in zip(*means, strict=True):
        turn, read = np.interp(nodes, angle.nodes, turns), np.interp(nodes, straight.nodes, reads)
        # On a table the tool's point wanders over it as the table moves: read there, the angle
        # times the way is in the reading, and the rail's own path is what is left.
        read = read - stays * sign * turn * nodes
        #       .-'''-.        The angle is the rail's slope: adding up angle times way draws the
        #     .' EBZ    '.     rail, but for its height (a constant) and its set-up (a line).
        path = np.concatenate([[0.0], np.cumsum((turn[1:] + turn[:-1]) / 2 * np.diff(nodes))])
        path *= -sign if on_table else sign
        pairs.append((_without_line(nodes, read), _without_line(nodes, path)))
    return pairs


def _compare(
    calibration: Calibration, letter: str, angle: Component, straight: Component, sign: float
) -> list[Finding]:
    pairs = _paths(calibration, letter, angle, straight, sign)
    if not pairs:
        return []
    measured, predicted = (max(float(np.ptp(p[i])) for p in pairs) for i in (0, 1))
    correlation = float(np.mean([_correlation(*p) for p in pairs]))
    numbers = {
        "correlation": correlation,
        "measured_um": measured / UM,
        "predicted_um": predicted / UM,
    }
    both = (
        f"{angle.name}, integrated, and {straight.name}, lines off both: correlation"
        f" {correlation:+.2f}, {predicted / UM:.2f} um predicted, {measured / UM:.2f} um read"
    )
    u = 0.0 if not np.isfinite(straight.largest_u) else straight.largest_u
    level, of, says = _verdict(angle.name, straight.name, measured, predicted, correlation, u)
    return [Finding("angle-straightness", level, of, f"{both}: {says}", numbers)]


def _without_line(nodes: np.ndarray, values: np.ndarray) -> np.ndarray:
    return values - np.polyval(np.polyfit(nodes, values, 1), nodes)


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size else 0.0


def _verdict(
    angle: str, straight: str, measured: float, predicted: float, correlation: float, u: float
) -> tuple[str, str, str]:
    """Level, component and sentence; measured, predicted and u in mm."""
    # 4 u: the range of two values that are each known to 2 u
    if measured < 4 * u:
        return "note", straight, "within the uncertainty, nothing can be said"
    if predicted > TOO_MUCH * measured and predicted > 1 * UM:
        says = (
            f"the angle is {predicted / measured:.0f} times too large for it. Its unit (or the"
            " arm's) is probably wrong"
        )
        return "doubt", angle, says
    if predicted < FEEBLE * measured:
        return "note", straight, "the angle explains too little of it to say anything"
    if correlation < TURNED:
        return "doubt", straight, f"the sign of {angle} or of {straight} is probably turned"
    if correlation > FOLLOWS:
        return "note", straight, "they agree"
    return "note", straight, "they neither agree nor contradict each other"
