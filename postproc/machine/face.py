"""Polar interpolation: places of the face that C turns, and the slides that take the tool there.

The place (x, y) of the face, seen from the line of C, is reached with X at its distance from that
line and C at its angle: X = hypot(x, y), C = atan2(y, x), counted from where C stands when the
interpolation begins. That is all that the control does (Fanuc B-64604EN-1, "Polar coordinate
interpolation"). Coordinates x stand in the row of X, y in that of C, mm.
"""

from __future__ import annotations

import numpy as np

from postproc.spaces import Space

TURN = 360.0
ANY = (-np.inf, np.inf)


def slides_of(
    letters: tuple[str, ...], space: Space, place: np.ndarray, known: tuple[float, float] = ANY
) -> np.ndarray:
    """(A, N) slide positions at places (A, N) of the face: C within half a turn of where it stood
    at the call. known: degrees that C's tables know, into which it is taken by whole turns."""
    x, c = letters.index("X"), letters.index("C")
    result = place.copy()
    #       y (row of C)
    #       ^     o place     X goes out to hypot(x, y) from C's line, which is at X = shift;
    #       |   .'            C goes to the place's angle, counted from `heading`, where it
    #       | .' angle        stood at the call.
    #       +-------> x
    result[x] = np.hypot(place[x], place[c]) + space.shift
    angle = space.heading + np.degrees(np.arctan2(place[c], place[x]))
    # One whole turn at most is put on or taken off: arctan2 stays within half a turn, so this is
    # enough for a table of C that holds the turn in which the interpolation begins.
    angle = np.where(angle > known[1], angle - TURN, angle)
    result[c] = np.where(angle < known[0], angle + TURN, angle)
    if "Y" in letters:
        result[letters.index("Y")] += space.beside
    return result


def places_of(letters: tuple[str, ...], space: Space, slides: np.ndarray) -> np.ndarray:
    """(A, N) places of the face at slide positions (A, N): the other way round."""
    x, c = letters.index("X"), letters.index("C")
    result = slides.copy()
    radius, angle = slides[x] - space.shift, np.radians(slides[c] - space.heading)
    result[x], result[c] = radius * np.cos(angle), radius * np.sin(angle)
    if "Y" in letters:
        result[letters.index("Y")] -= space.beside
    return result
