"""What a drawing says in a lathe's shape: corners and angles in the place of points.

Fanuc B-64304EN-1, "Direct drawing dimension programming" and "Chamfering and corner R": C and R of
a straight line (with a comma or without) are the way of a chamfer from the corner, and the radius
of an arc that touches both lines; A, with a comma or without, is the angle of the line from the
first axis of the plane, Z, in degrees. With A one of X and Z may be missing; with A alone the end
lies on the next line, which says its own A, X and Z. I of a line along Z and K of one along X are
chamfers to a line across, the way of their sign. LinuxCNC has none of this, and nor has Haas' A.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Any

from postproc.errors import ProgramError
from postproc.nc.cycles.bend import NEAR, Bend, Point, bent
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene

COMMA = re.compile(rb",[ \t]*([CR])[ \t]*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))", re.IGNORECASE)
COMMENT = re.compile(rb"\([^()\n]*\)|;.*", re.DOTALL)
ANGLE = re.compile(rb",(?=[ \t]*A)", re.IGNORECASE)
ACROSS = {"I": "X", "K": "Z"}  # the axis along which a chamfer of this letter ends
WRITE = "write its end as X and Z"


@dataclass(frozen=True)
class Corner:
    """`round`: an arc of this radius, else a chamfer that begins so far before the corner; `way`:
    the letter and sign of I or K, "": none."""

    round: bool
    size: float
    way: str = ""


def split(text: bytes) -> tuple[bytes, re.Match[bytes] | None]:
    """A block without its ",C" or ",R", and that one."""
    found = COMMA.search(COMMENT.sub(lambda m: b" " * len(m[0]), text)) if b"," in text else None
    if found is None:
        return text, None
    return text[: found.start()].rstrip(b" \t") + text[found.end() :], found


def without_comma(text: bytes) -> bytes:
    """A block with A for its ",A", as long."""
    code = COMMENT.sub(lambda m: b" " * len(m[0]), text) if b"," in text else b""
    for found in ANGLE.finditer(code):
        # A blank in its place: what was found behind it stays where it was found.
        text = text[: found.start()] + b" " + text[found.end() :]
    return text


def corner_of(scene: Scene, block: Block, found: re.Match[bytes] | None) -> Corner | None:
    """The corner that a straight block names, with a comma or without. Raises ProgramError."""
    words = [w for w in block.words if w.letter in bare(scene, "CRIK")]
    if found is not None:
        raw = found[2].decode()
        words.append(Word(found[1].decode().upper(), float(raw), raw, 0, 0))
    if len(words) > 1:
        raise scene.fault("two corners in one block", "keep one")
    size = abs(scene.length(words[0], "Z")) if words else 0.0
    if not size:
        return None
    letter = words[0].letter
    if letter in ACROSS:
        one_way(scene, words[0], [w.letter for w in block.words])
        return Corner(False, size, letter + "-" * words[0].raw.startswith("-"))
    return Corner(letter == "R", size)


def elsewhere(scene: Scene, letter: str) -> ProgramError:
    """What is said of a chamfer by I or K whose next line is none across."""
    return scene.fault(
        f"{letter} makes a chamfer to a line across it, the way of its sign, and the next line goes"
        " elsewhere",
        "write the corner out",
    )


def one_way(scene: Scene, word: Word, letters: list[str]) -> None:
    """Raises ProgramError unless the block of I or K moves across the axis that it ends along."""
    along = ACROSS[word.letter]
    other = "XZ".replace(along, "")
    own = {x: x + scene.increment(x) for x in (along, other)}
    if any(x in own[along] for x in letters) or not any(x in own[other] for x in letters):
        raise scene.fault(
            f"{word.letter} as a chamfer stands behind a motion of {other} alone",
            "write the corner out",
            word,
        )


def bare(scene: Scene, letters: str) -> str:
    """Of these letters those that a straight block of a lathe may name without a comma."""
    # A lathe with an axis C or A has no corner and no angle of that letter without a comma.
    drawn = set(scene.dialect.drawn) - set(scene.tracker.setup.axes)
    return "".join(x for x in letters if x in drawn)


def on_line(scene: Scene, here: Point, angle: float, z: float | None, x: float | None) -> Point:
    """The end of a line at `angle`, degrees, one of whose coordinates (z, x radius) is missing.
    Raises ProgramError where the line does not lead there."""
    #   X ^    . end       The angle counts from the plane's first axis, Z, towards its second, X, a
    #     |  .' A          radius here: A45 is the 45 degrees of the drawing.
    #     +-'-------> Z
    slope = math.tan(math.radians(angle))
    if z is not None and x is None:
        if abs(math.cos(math.radians(angle))) < NEAR:
            raise scene.fault(f"A{angle:g} and no X", WRITE)
        return z, here[1] + (z - here[0]) * slope
    assert x is not None
    if abs(slope) < NEAR:
        raise scene.fault(f"A{angle:g} and no Z", WRITE)
    return here[0] + (x - here[1]) / slope, x


def meeting(scene: Scene, here: Point, first: float, end: Point, second: float) -> Point:
    """Where a line from `here` at an angle (`first`, degrees) meets the next one (`second`), which
    ends at `end`; (z, x radius). Raises ProgramError where they are parallel."""
    #   here --first--> o --second--> end    here + far a = end - t b, crossed with b: far = (way x
    #                                        b) / (a x b). Below 1e-6 both are parallel for
    #                                        practice: the point would be a million times farther
    #                                        than the lines are apart.
    a = complex(math.cos(math.radians(first)), math.sin(math.radians(first)))
    b = complex(math.cos(math.radians(second)), math.sin(math.radians(second)))
    across = (a.conjugate() * b).imag
    if abs(across) < 1e-6:
        raise scene.fault("two lines of the shape, by their angles A, never meet", WRITE)
    way = complex(end[0] - here[0], end[1] - here[1])
    far = (way.conjugate() * b).imag / across
    return here[0] + far * a.real, here[1] + far * a.imag


def rounded(scene: Scene, elements: list[Any], corners: dict[int, Corner]) -> list[Any]:
    """The elements with the corners between them. `corners`: by number of the element before.
    Raises ProgramError for one that does not fit."""
    result, start = [], None
    for k, e in enumerate(elements):
        # The corner before has taken the beginning of this line.
        if start is not None:
            e = replace(e, start=start)
            start = None
        corner = corners.get(k)
        if corner is None:
            result.append(e)
            continue
        behind = elements[k + 1] if k + 1 < len(elements) else None
        if behind is None or e.is_arc or behind.is_arc:
            raise scene.fault(
                "a corner of the shape at an arc, or behind its last line", "write the corner out"
            )
        bend = bent(e.start, e.end, behind.end)
        first, second = bend.ends(_away(scene, corner, bend))
        made = replace(e, start=first, end=second, code=e.code)
        if corner.round:
            code, centre = COUNTER if bend.left else CLOCKWISE, bend.centre(corner.size)
            made = replace(made, code=code, centre=centre, words=(scene.text("R", corner.size),))
        result += [replace(e, end=first), made]
        start = second
    return result


def _away(scene: Scene, corner: Corner, bend: Bend) -> float:
    """How far from its point a corner begins. Raises ProgramError."""
    if corner.way:
        # b is the direction of the line behind, (Z, X) as (real, imag): along one axis it is 1 or
        # -1.
        along = bend.b.imag if ACROSS[corner.way[0]] == "X" else bend.b.real
        if abs(abs(along) - 1.0) > NEAR or (along < 0) != (corner.way[1:] == "-"):
            raise elsewhere(scene, corner.way[0])
    if bend.back or bend.straight:
        raise scene.fault("a corner of the shape where it goes straight on", "take it out")
    away = bend.away(corner.size) if corner.round else corner.size
    if away > bend.length + 1e-6:
        raise scene.fault(
            f"a corner of {corner.size:g} begins {away:.4g} before its point, and a line of the"
            f" shape there has {bend.length:.4g}",
            "make it smaller, or write the corner out",
        )
    return away
