"""The statements L that a cycle of Heidenhain Klartext becomes, and the feed that a block says."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from postproc.nc.cycles.pole_arc import Point
from postproc.nc.cycles.scene import Scene

FAST = b" FMAX"
OWN_FEED = re.compile(rb"(?<![A-Z])M[ \t]*0*(?:103|128|140)(?![0-9]).*", re.DOTALL | re.IGNORECASE)


def without_own_feed(code: bytes) -> bytes:
    """A block up to an M function with an F of its own: a percentage (M103), the highest feed of
    compensating motions (M128), that of the way back (M140). HEIDENHAIN TNC 640 user's manual,
    "Miscellaneous functions for path behavior": L X+20 Y+20 RL F500 M103 F20."""
    return OWN_FEED.sub(b"", code) if b"M" in code.upper() else code


def signed(scene: Scene, axis: str, value: float) -> bytes:
    """X+10.5."""
    # The language writes a sign always, and no point behind a whole number.
    text = scene.text(axis, value).rstrip(b".")
    return text if text[1:2] == b"-" else text[:1] + b"+" + text[1:]


def places(scene: Scene, place: Point) -> list[bytes]:
    """The words X and Y of a place."""
    return [signed(scene, axis, v) for axis, v in zip("XY", place, strict=True)]


@dataclass
class Lines:
    """Collects them. FMAX holds in its own line alone, another feed until the next one."""

    scene: Scene
    texts: list[bytes] = field(default_factory=list)
    fed: bytes = b""

    def to(self, place: Point | None, z: float | None, feed: bytes = FAST) -> None:
        """To a place in the plane, and along the tool axis, as far as they are given."""
        words = [] if place is None else places(self.scene, place)
        words += [] if z is None else [signed(self.scene, "Z", z)]
        self.texts.append(b"L " + b" ".join(words) + (b"" if feed == self.fed else feed))
        self.fed = self.fed if feed == FAST else feed

    def anew(self, place: Point | None, z: float | None, feed: bytes) -> None:
        """The same, with the feed even where it holds."""
        self.fed = b""
        self.to(place, z, feed)
