"""A lathe with polar interpolation, and what its errors do to a program of the face.

Shares nothing with the product: words are read by a reader of its own, the control makes X and C
of them by distance and angle, and the tip is carried to the part by exact 4 x 4 transforms of the
whole chain (tests/reference/kinematics).
"""

from __future__ import annotations

import re

import numpy as np

from tests.reference.tool_point import Truth

WORD = re.compile(r"([XYZCIJR])\s*([-+]?\d*\.?\d+)")
SHARES = np.linspace(0.0, 1.0, 9)


def strokes(text: str, second: str, on: str, off: str):
    """Of each block between `on` and `off` that moves: number, code, begin and end (3,) mm of the
    face (x, y, z), the centre or None, and what stood before the call: C in degrees, and Y."""
    scale = 0.5 if second == "C" else 1.0  # X is a diameter beside C
    slides = {"X": 0.0, "Y": 0.0, "Z": 0.0, "C": 0.0}
    here, code, number, active = np.zeros(3), 0, "", False
    for line in re.sub(r"\([^)]*\)", "", text).splitlines():
        named = re.match(r"\s*N(\d+)", line)
        number = named[1] if named else number
        codes = re.findall(r"G0*([0-3])(?![\d.])", line)
        code = int(codes[-1]) if codes else code
        words = dict(WORD.findall(re.sub(r"[GN]\d+(\.\d+)?", " ", line)))
        value = {k: float(v) for k, v in words.items()}
        if re.search(rf"{on}\b", line):
            active, here = True, np.array([slides["X"] / 2, 0.0, slides["Z"]])
            continue
        if re.search(rf"{off}\b", line):
            active = False
            continue
        if not active:
            slides |= {k: v for k, v in value.items() if k in slides}
            continue
        end = np.array(
            [
                value["X"] * scale if "X" in value else here[0],
                value.get(second, here[1]),
                value.get("Z", here[2]),
            ]
        )
        centre = None
        if code > 1 and "R" in value:
            centre = _by_radius(here, end, value["R"], code)
        elif code > 1:
            centre = here[:2] + [value.get("I", 0.0), value.get("J", 0.0)]
        if value:
            yield number, code, here, end, centre, slides["C"], slides["Y"]
        here = end


def _by_radius(start: np.ndarray, end: np.ndarray, radius: float, code: int) -> np.ndarray:
    chord = end[:2] - start[:2]
    length = float(np.hypot(*chord))
    height = np.sqrt(max(radius**2 - length**2 / 4, 0.0))
    left = np.array([-chord[1], chord[0]]) / length
    side = 1 if (code == 3) == (radius > 0) else -1
    return (start + end)[:2] / 2 + left * side * height


def points(stroke) -> np.ndarray:
    """(9, 3) mm of the face along a stroke."""
    _, code, start, end, centre, *_ = stroke
    result = start + (end - start) * SHARES[:, None]
    if centre is not None:
        arms = [complex(*(p[:2] - centre)) for p in (start, end)]
        sweep = np.angle(arms[1] / arms[0])
        if code == 3 and sweep <= 1e-9:
            sweep += 2 * np.pi
        if code == 2 and sweep >= -1e-9:
            sweep -= 2 * np.pi
        radius = abs(arms[0]) + (abs(arms[1]) - abs(arms[0])) * SHARES
        place = complex(*centre) + radius * np.exp(1j * (np.angle(arms[0]) + sweep * SHARES))
        result[:, 0], result[:, 1] = place.real, place.imag
    return result


def tips(truth: Truth, stroke, errors: bool, zero: float) -> np.ndarray:
    """(9, 3) mm of the tip in the part along a stroke, turned back by C at the call. zero: mm, the
    slide X on C's line."""
    *_, c, y = stroke
    found = []
    for place in points(stroke):
        angle = np.degrees(np.arctan2(place[1], place[0]))
        pose = {
            "X": float(np.hypot(*place[:2])) + zero, "Z": float(place[2]), "C": float(c + angle),
            "Y": y if errors else 0.0,
        }  # fmt: skip
        pose = {x: v for x, v in pose.items() if x in truth.axes}
        found.append(truth.actual(pose, 0.0) if errors else truth.nominal(pose))
    back = np.radians(-c)
    turn = np.array(
        [[np.cos(back), -np.sin(back), 0], [np.sin(back), np.cos(back), 0], [0, 0, 1.0]]
    )
    return np.array(found) @ turn.T


def _away(stroke, tip: np.ndarray) -> float:
    """mm from a tip to the nominal stroke."""
    _, _, start, end, centre, *_ = stroke
    if centre is None:
        way = end - start
        t = np.clip((tip - start) @ way / max(way @ way, 1e-30), 0, 1)
        return float(np.linalg.norm(tip - start - way * t))
    fine = np.linalg.norm(start[:2] - centre)
    return float(np.hypot(np.linalg.norm(tip[:2] - centre) - fine, tip[2] - start[2]))


def judge(
    truth: Truth, nominal: str, output: str, second: str, on: str, off: str, zero: float = 0.0
) -> tuple[float, float]:
    """mm: the largest distance of the tip from the nominal path with the output, and with the
    nominal program itself; each stroke's last end from its nominal end too. The first stroke leads
    from where the slides alone have brought the tip, and is not judged."""
    wanted = {s[0]: s for s in strokes(nominal, second, on, off)}
    largest = []
    for text in (output, nominal):
        worst, last = 0.0, {}
        for stroke in strokes(text, second, on, off):
            if stroke[0] == next(iter(wanted)):
                continue
            tip = tips(truth, stroke, True, zero) - [0, 0, truth.tool[2]]
            worst = max(worst, *(_away(wanted[stroke[0]], p) for p in tip))
            last[stroke[0]] = tip[-1]
        ends = [np.linalg.norm(tip - wanted[n][3]) for n, tip in last.items()]
        largest.append(max(worst, *ends))
    return largest[0], largest[1]
