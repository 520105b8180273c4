"""What the resolver asks of a control's frames, and what the controls share of the answer."""

from __future__ import annotations

from typing import Any

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.frames import Frames
from postproc.nc.cycles.scene import Scene


class FrameControl:
    """The frames in force. `codes`: those it looks at; `takers`: those of them whose axis words are
    no motion."""

    codes: tuple[int, ...]
    takers: tuple[int, ...]

    def __init__(self, scene: Scene):
        self.scene, self.frames = scene, Frames(scene)

    @property
    def active(self) -> bool:
        """Whether blocks must be looked at."""
        return self.frames.active

    def known(self, axis: str) -> float | None:
        """The programmed coordinate at which an axis stands."""
        return self.frames.known(axis)

    def take(self, block: Block) -> list[bytes]:
        """A plain block in programmed coordinates, in those beneath. Raises ProgramError."""
        raise NotImplementedError

    def _holders(self) -> tuple[object, ...]:
        """Whatever a block may change."""
        return self, self.frames

    # A tap is turned twice: as the control shall read it, and as the tracker hears it. The first
    # time must leave no trace in the places and residues that are kept here.
    def snapshot(self) -> Any:
        """What `restore` needs."""
        return [
            {k: v.copy() if isinstance(v, dict | set) else v for k, v in vars(holder).items()}
            for holder in self._holders()
        ]

    def restore(self, kept: Any) -> None:
        """As it was when the snapshot was taken."""
        for holder, values in zip(self._holders(), kept, strict=True):
            vars(holder).update(values)
