"""@ and ^ of LinuxCNC: radius and angle of a place in XY, about the zero of the program, as X and
Y.

LinuxCNC documentation, "Polar coordinates"; measured on 2.9 (tests/expand/test_polar.py). One that
is left out is that of the place where the tool stands; in G91 both are added to it. Motions in G17
alone, without X or Y and without G53.
"""

from __future__ import annotations

import math
import re

from postproc.nc.expand import Refusal
from postproc.nc.expand.linuxcnc_parameters import SAY, Memory
from postproc.nc.expand.tracker import number

WORD = re.compile(rb"\([^()]*\)|;.*|([@^])[ \t]*([-+]?[ \t]*[\d.][\d. \t]*)", re.DOTALL)
# codes that take the axis words, or have none; G53
NO_MOTION = {40, 530, 100, 280, 281, 300, 301, 520, 920, 921, 922, 923, 431}
UNITS, DISTANCE = {200: True, 210: False}, {900: False, 910: True}


# Whole: radius and angle, each stated, incremental or kept.
def right_angled(text: bytes, codes: set[int], letters: str, memory: Memory) -> bytes:
    """A plain line with X and Y in the place of @ and ^. codes: ten times its G numbers. Raises
    Refusal."""
    found = {m[1]: float(re.sub(rb"[ \t]", b"", m[2])) for m in WORD.finditer(text) if m[1]}
    _check(codes, letters, memory)
    by = next((DISTANCE[c] for c in codes if c in DISTANCE), memory.tracker.code("distance") == 910)
    radius, angle = found.get(b"@"), found.get(b"^")
    here = _here(codes, memory) if by or radius is None or angle is None else (0.0, 0.0)
    at, to = math.hypot(*here), math.degrees(math.atan2(here[1], here[0]))
    if angle is None and at < 1e-12:
        raise Refusal(
            "@ without ^, and the tool stands at the zero of the program", "name the angle"
        )
    # one that is not written is that of the place where the tool stands; in G91 both are added to
    # it
    radius = at + (radius or 0.0) if by or radius is None else radius
    angle = to + (angle or 0.0) if by or angle is None else angle
    x, y = radius * math.cos(math.radians(angle)), radius * math.sin(math.radians(angle))
    if by:
        x, y = x - here[0], y - here[1]
    half = 2.0 if _diameter(codes, memory) else 1.0
    words = (
        f"X{number(x * half, memory.decimals('X'))} Y{number(y, memory.decimals('Y'))} ".encode()
    )
    places = iter([words])  # the first of the two words makes way for both
    put = lambda m: next(places, b"") if m[1] else m[0]  # noqa: E731
    return WORD.sub(put, text).rstrip(b" \t")


def _check(codes: set[int], letters: str, memory: Memory) -> None:
    """Raises Refusal where LinuxCNC takes no polar words."""
    if letters.count("@") > 1 or letters.count("^") > 1:
        raise Refusal("a radius or an angle stands twice in the line", "keep one")
    if "x" in letters or "y" in letters:
        raise Refusal("@ or ^ beside X or Y", "LinuxCNC refuses it: name the place in one way")
    plane = next((c for c in codes if c in (170, 180, 190)), memory.tracker.code("plane"))
    if plane not in (-1, 170):
        raise Refusal("@ or ^ outside of G17", "LinuxCNC refuses it: write G17 before")
    if codes & NO_MOTION:
        raise Refusal(
            "@ or ^ in a line that is no motion, or with G53", "LinuxCNC refuses it: write X and Y"
        )


def _diameter(codes: set[int], memory: Memory) -> bool:
    own = next((c for c in codes if c in (70, 80)), None)
    return own == 70 if own is not None else memory.tracker.is_diameter("X")


def _here(codes: set[int], memory: Memory) -> tuple[float, float]:
    """Where the tool stands, X as a radius. Raises Refusal."""
    if codes & set(UNITS) or "turned" in memory.noticed or any(540 <= c <= 593 for c in codes):
        raise Refusal(
            "@ and ^ from where the tool stands, with units or a turned zero that change there",
            "name both in G90, or write X and Y",
        )
    place = []
    for axis in "XY":
        value = memory.tracker.work(axis)
        if value is None:
            raise Refusal(f"@ and ^ count from where {axis} stands, and that is not known", SAY)
        place.append(value / 2 if memory.tracker.is_diameter(axis) else value)
    return place[0], place[1]
