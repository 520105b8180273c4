"""Which words a cycle takes: every cycle declares them, and a word that is not among them stops the
program by name.

The table in docs/CYCLES.md is made of these declarations (`python -m tests.cycles_doc`), and
tests/expand/test_words.py changes every one of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.scene import Scene

GENERAL = "NGFSTM"  # mean the same in every block, so they stay in it
NONE: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Form:
    """One way to write a cycle.

    `kind`: what it is, with its article; `name`: which of several ways ("" where there is one).
    `takes`: letter to what is done with it; `keeps`: letter to what a later cycle does with it.
    `refused`: letter to what the control means by it, where that is not followed; those in `zero`
    may stand with the value 0, those in `one` with 1, those in `idle` with any: they say nothing,
    which a notice tells. `axes`: words of the machine's other axes say
    the place too;
    `increments`: U V W H are distances, each beside its axis' own letter. `unless`: letters
    whose presence says that the block is written another way. `stays`: the block goes to the
    control as it is written; `never`: why it is refused, whatever its words are; `whole`: but not
    where the cycle may stay as it is.
    """

    kind: str
    takes: Mapping[str, str] = field(default_factory=lambda: NONE)
    keeps: Mapping[str, str] = field(default_factory=lambda: NONE)
    refused: Mapping[str, str] = field(default_factory=lambda: NONE)
    zero: str = ""
    idle: str = ""
    one: str = ""
    axes: bool = False
    increments: bool = False
    name: str = ""
    unless: str = ""
    stays: bool = False
    never: str = ""
    whole: bool = False

    def letters(self, scene: Scene) -> set[str]:
        """All letters that are followed, or kept, on this machine."""
        axes = set(scene.tracker.setup.axes) if self.axes else set()
        by = (
            {u for u, x in scene.dialect.increments.items() if x in axes}
            if self.increments
            else set()
        )
        return {*self.takes, *self.keeps} | axes | by

    def check(self, scene: Scene, block: Block, code: int) -> None:
        """Raises ProgramError at the first word of the block that is not followed."""
        # A block that stays keeps all its words: what they mean the control alone has to know.
        if self.stays or self.never:
            return
        where, letters, seen = f"{self.kind} (G{code / 10:g})", self.letters(scene), set()
        for word in block.words:
            if word.letter in GENERAL:
                continue
            meant = (
                scene.dialect.increments.get(word.letter, word.letter)
                if self.increments
                else word.letter
            )
            # Where U V W H are distances, X and U are one word: a place named twice is refused.
            if meant in seen:
                raise scene.fault(
                    f"{meant} is named twice in {where}",
                    "which one holds differs: write it once",
                    word,
                )
            seen.add(meant)
            if word.letter not in letters and not self._idle(word):
                raise self._fault(scene, word, where)

    def _idle(self, word: Word) -> bool:
        """Whether a word has the value with which it may stand."""
        if word.letter in self.idle:
            return True
        return (word.letter in self.zero and word.value == 0) or (
            word.letter in self.one and word.value == 1
        )

    def _fault(self, scene: Scene, word: Word, where: str) -> Exception:
        meaning = self.refused.get(word.letter)
        if meaning is None:
            return scene.fault(
                f"{word.letter} in {where}: that is no word of it",
                "take it out, or write it in another block",
                word,
            )
        return scene.fault(
            f"{word.letter}{word.raw} in {where}: {meaning}, which is not followed",
            f"write the cycle without {word.letter}, or let the CAM program write it out as G0 G1"
            " G2 G3",
            word,
        )


def form_of(forms: tuple[Form, ...], block: Block) -> Form:
    """The way in which a block is written."""
    # The ways that are told by a letter first; the last one is what any other block is.
    return next(
        f for f in forms if f is forms[-1] or not any(w.letter in f.unless for w in block.words)
    )


def named(meanings: Mapping[str, str], letters: str) -> dict[str, str]:
    """The rows of these letters."""
    return {x: meanings[x] for x in letters}
