"""G10 L2 R: a work offset of LinuxCNC that is turned about its zero in XY, as measured on its
interpreter 2.9.

R is taken out of the text, so the output is right where the control itself holds no turn
(parameters 5230, 5250, ... are 0).
"""

from __future__ import annotations

from postproc.nc.cycles.affine import Affine, rotation
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.frame_control import FrameControl
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import Scene

DATA, REFERENCES = 100, (280, 300)
RESTORES = {922, 923}  # G92.2 and G92.3: the shift of G92 goes and comes back
WORK = (540, 550, 560, 570, 580, 590, 591, 592, 593)


class LinuxcncRotation(FrameControl):
    """`turns`: degrees by the number of the work offset (1: G54)."""

    codes = takers = (DATA,)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.frames.why = "a turned work offset (G10 L2 R)"
        self.turns: dict[int, float] = {}

    @property
    def active(self) -> bool:
        return bool(self.turns)

    def take(self, block: Block) -> list[bytes]:
        scene = self.scene
        if DATA in block.codes:
            return self._data(block)
        if not self.active:
            return [block.text]
        self._hold()
        references = [c for c in block.codes if c in REFERENCES]
        taken = [c for c in block.codes if c in scene.table and scene.table[c].takes]
        shifts = [c for c in taken if c not in REFERENCES]
        if not self.frames.map.identity:
            self._check(block, references, bool(shifts) or not RESTORES.isdisjoint(block.codes))
        # They speak of the machine, or change the zero itself: their words are no places in turned
        # coordinates.
        if references or shifts or 530 in block.codes:
            self.frames.forget()
            return [block.text]
        return self.frames.take(block)

    def _check(self, block: Block, references: list[int], shifted: bool) -> None:
        """Raises ProgramError for what moves the zero, or goes home, within a turn."""
        place = any(w.letter in "XY" for w in block.words)
        if shifted and (place or not block.words[1:]):
            raise self.scene.fault(
                f"G92 or G52 within {self.frames.why}",
                "shift the coordinates with G10 L2 X Y instead",
            )
        if references and place:
            raise self.scene.fault(
                f"G{references[0] // 10} over a place within {self.frames.why}",
                "name no X and Y in it",
            )

    def system(self) -> int:
        """The work offset in force."""
        held = self.scene.code("work offset")
        return WORK.index(held) + 1 if held in WORK else 1

    def _hold(self) -> None:
        """The turn of the work offset in force."""
        degrees = self.turns.get(self.system(), 0.0)
        new = rotation("X", "Y", degrees) if degrees % 360 else Affine()
        if new != self.frames.map:
            frame = self.scene.tracker.state.frame
            if frame is not None and any(frame.preset[:2]) and not new.identity:
                raise self.scene.fault(
                    f"G92 or G52 is in force within {self.frames.why}", "end it before: G92.1"
                )
            self.frames.set_map(new)

    def _data(self, block: Block) -> list[bytes]:
        """G10 L2 P R: remember the turn and take it out of the text."""
        scene, line, angle = self.scene, block.get("L"), block.get("R")
        if line in (10, 11, 20) and self.turns:
            raise scene.fault(
                f"G10 L{line:g} within {self.frames.why}",
                "set the offset with G10 L2, a tool with G10 L1",
            )
        if line != 2:
            return [block.text]
        number = block.get("P") or 0.0
        # P0 is the offset in force, P1 is G54.
        system = int(number) if number else self.system()
        self.frames.forget()
        if angle is None:
            return [block.text]
        self.turns[system] = angle
        # G10 L2 P1 R30 alone says nothing else: all of it goes out. With X, Y or Z the shift stays.
        letters = "R" if any(w.letter in "XYZABCUVW" for w in block.words) else "RLP"
        out = own_words(block, letters, {DATA} if letters != "R" else set())
        # While a frame is at work a turn by 0 is kept, since it has to end what an older one began.
        self.turns = {
            n: degrees for n, degrees in self.turns.items() if degrees or self.frames.active
        }
        text = block.written(out)
        return [text] if text.strip(b" \t\r/") else []
