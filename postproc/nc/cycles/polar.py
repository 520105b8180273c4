"""G16: the first axis' word of the plane is a radius, the second's an angle in degrees, until G15.

Fanuc B-64304EN-2, "Polar coordinate command": in G90 the radius counts from the zero of the work
coordinates, in G91 from where the tool stands; the angle is absolute in G90 and counts from the
last one in G91. A word that is not named holds.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from postproc.nc.cycles.affine import exact_turn
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.frames import Frames
from postproc.nc.cycles.scene import Scene


@dataclass
class Polar:
    """The pole, radius and angle in force; `here`: the place that was made of the last ones."""

    scene: Scene
    frames: Frames
    on: bool = False
    pole: tuple[float, float] = (0.0, 0.0)
    radius: float | None = None
    angle: float | None = None
    here: tuple[float, float] | None = None
    residue: dict[str, float] = field(default_factory=dict)

    def begin(self) -> None:
        self.on, self.pole, self.radius, self.angle = True, (0.0, 0.0), None, None
        self.forget()

    def forget(self) -> None:
        """Something else moved the axes."""
        self.here, self.residue = None, {}

    # Whole: a list of refusals between the steps that they guard.
    def take(self, block: Block) -> Block:
        """The block with right-angled words. Raises ProgramError."""
        scene = self.scene
        first, second, _ = scene.plane
        radius, angle = block.word(first), block.word(second)
        if radius is None and angle is None:
            return block
        incremental = scene.incremental
        if radius:
            self.pole = self._stands(first, second) if incremental else (0.0, 0.0)
        elif not incremental and self.pole != (0.0, 0.0):
            raise scene.fault(
                f"G16 in G90 without {first}, behind a pole set in G91",
                f"name the radius {first} too",
            )
        if radius:
            self.radius = None if radius.value is None else scene.length(radius, first)
        if angle:
            # In G91 the angle goes on from the last one, in G90 it counts from the first axis.
            before = self.angle if incremental else 0.0
            self.angle = None if before is None else before + scene.degrees(angle)
        if self.radius is None or self.angle is None:
            raise scene.fault(
                f"the first block behind G16 must name the radius {first} and the angle {second},"
                " in G90",
                "write both: what holds before is not defined",
            )
        # Quarter turns without a rounding, so that a hole at 90 degrees has X0 and not X0.0000001.
        cosine, sine = exact_turn(self.angle)
        to = (self.pole[0] + self.radius * cosine, self.pole[1] + self.radius * sine)
        old = self._stands(first, second) if incremental else (0.0, 0.0)
        texts = {}
        # An increment is written in whole increments: what its rounding leaves goes into the next
        # one, so that a row of holes does not drift.
        for axis, value, start in zip((first, second), to, old, strict=True):
            exact = value - start + (self.residue.get(axis, 0.0) if incremental else 0.0)
            self.residue[axis] = exact - scene.rounded(axis, exact)
            texts[axis] = scene.text(axis, exact)
        self.here = to
        return self._written(block, texts)

    def _written(self, block: Block, texts: dict[str, bytes]) -> Block:
        """The block with these words, changed ones and those that come in."""
        numbers = {w.letter: i for i, w in enumerate(block.words)}
        changed = {numbers[x]: texts.pop(x) for x in list(texts) if x in numbers}
        beside = min(changed)
        at = beside + any(x > block.words[beside].letter for x in texts)
        text = block.written(set(), b"".join(texts.values()), at, changed)
        return Block.of(text, self.scene.dialect.grammar)

    def _stands(self, first: str, second: str) -> tuple[float, float]:
        if self.here is not None:
            return self.here
        places = [self.frames.known(x) for x in (first, second)]
        for axis, place in zip((first, second), places, strict=True):
            if place is None:
                self.scene.at(axis)
        return places[0] or 0.0, places[1] or 0.0
