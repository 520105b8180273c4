"""The motions of a cycle as plain lines: what is named once is not named again, and rounding does
not add up."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from postproc.nc.cycles.block import Block, number_of
from postproc.nc.cycles.scene import Scene

END_OF_PROGRAM_OR_STOP = (0, 1, 2, 30, 60)


class Moves:
    """Collects the plain lines that a cycle's block becomes. `positions` are programmed
    coordinates.

    The first line keeps the block's other words; M codes that a control executes behind the motion
    (M0 M1 M2 M30 M60, and `after_motion`) go to the last one.
    """

    def __init__(self, scene: Scene, own: set[int], after_motion: tuple[int, ...] = ()):
        self.scene, self.block = scene, scene.block
        self.lines: list[bytes] = []
        self._code = ""
        self._sep = b" " if self.block.spaced else b""
        later = END_OF_PROGRAM_OR_STOP + after_motion
        self._last = [
            i
            for i, w in enumerate(self.block.words)
            if w.letter == "M" and w.value in later and i not in own
        ]
        self._out = own | set(self._last)
        # Where the cycle's first word stood, so that N, F, S and T keep their order around the
        # motion.
        self._place = min(own) if own else None

    def _join(self, words: list[bytes]) -> bytes:
        return self._sep.join(words)

    def line(self, *words: bytes) -> None:
        """A line of words as they are; the first one goes in among the words of the block."""
        text = self._join(list(words))
        if not self.lines:
            self.lines.append(self.block.written(self._out, text, self._place))
        else:
            self.lines.append((b"/" if self.block.skip else b"") + text)

    def words(self, code: str, *words: bytes) -> None:
        """A motion whose axis words are written already."""
        # The first line always names it: what was in force before is the program's, not ours.
        named = code != self._code or not self.lines or not self.scene.dialect.modal_motion
        head = [code.encode()] if named else []
        self._code = code
        self.line(*head, *words)

    def move(self, code: str, to: Mapping[str, float], *more: bytes) -> None:
        """A straight motion (or, with `more`, an arc) to programmed coordinates; in G91 the words
        are distances."""
        scene, words = self.scene, []
        for axis, value in to.items():
            # An arc names all its axes: an end that is left out is the start, and could mean a full
            # circle.
            if more or scene.differs(axis, value):
                words.append(self.word(axis, value))
        if words or more:
            self.words(code, *words, *more)

    def word(self, axis: str, value: float) -> bytes:
        """The word that takes an axis to a programmed coordinate."""
        scene = self.scene
        # Rounded places, and distances between rounded places: the roundings of G91 do not add up.
        value = scene.rounded(axis, value)
        word = scene.text(
            axis, value - scene.rounded(axis, scene.at(axis)) if scene.incremental else value
        )
        scene.moved(axis, value)
        return word

    def finish(self) -> list[bytes]:
        """The lines."""
        if not self.lines:
            self.lines.append(self.block.written(self._out))
        if self._last:
            words = [
                self.block.text[self.block.words[i].start : self.block.words[i].stop]
                for i in self._last
            ]
            if len(self.lines) == 1:
                self.line(*words)
            else:
                self.lines[-1] += self._sep + self._join(words)
        return [line for line in self.lines if line.strip(b" \t\r/")]


def own_words(block: Block, letters: Collection[str], codes: Collection[int] = ()) -> set[int]:
    """The numbers of the words that belong to the cycle: its letters and its codes."""
    return {i for i, w in enumerate(block.words) if w.letter in letters or number_of(w) in codes}
