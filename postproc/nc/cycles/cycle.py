"""What the resolver asks of a canned cycle, and what a cycle answers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

# -1 is a program that has named none yet (Scene.code).
UNDEFINED = -2


class Outcome(NamedTuple):
    """What a block becomes, what the tracker shall hear instead where the block itself stays (None:
    the same), the source lines, first and last, that the control steps over behind it, and ten
    times the motion code in force behind a cycle that is not modal (None: that before it,
    UNDEFINED: manuals do not say); stays: the tracker follows it as the cycle that it is. loose: an
    axis that the control may leave elsewhere than the lines do, so that nothing may count from
    there."""

    lines: list[bytes]
    heard: list[bytes] | None = None
    skip: tuple[int, int] | None = None
    then: int | None = None
    stays: bool = False
    loose: str = ""


class Cycle:
    """A cycle of one block, unless a subclass says more. `codes`: ten times each G number that
    calls it; `form`: its words."""

    codes: Iterable[int]
    form: Form

    @property
    def modal(self) -> bool:
        """Whether later blocks without a motion code may be its own."""
        return False

    def forms(self, code: int) -> tuple[Form, ...]:
        """The ways in which it is written."""
        return (self.form,)

    def wants(self, scene: Scene, block: Block) -> bool:
        """Whether a later block without a motion code is its own."""
        return False

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        raise NotImplementedError

    def end(self) -> None:
        """G80 or another motion code: it is over. Raises ProgramError where it is not complete."""
