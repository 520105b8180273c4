"""Cycles of Heidenhain's DIN/ISO, written out as G00 and G01: drilling, and with the tool's radius
(G99 R, or --offset) bores, pockets, slots, studs and faces, called by G79 or M99.

What each does: klartext_called.py; HEIDENHAIN user's manuals, ISO programming, "Calling a cycle".
Behind them the motion code and the feed that were in force are named again. A program that
calls labels runs its text in another order than it stands in, so that it is unknown which cycle was
defined last: it is refused.
"""

from __future__ import annotations

import re

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.klartext_bore import DELTA, Tool
from postproc.nc.cycles.klartext_called import called
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_lines import without_own_feed
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line

CALL_CODE = 790
DEFINED = re.compile(rb"(?<![A-Z])G[ \t]*(2[0-9]{2})(?![0-9])")
DATUM = re.compile(rb"(?<![A-Z])Q([0-9]+)[ \t]*=[ \t]*([-+]?[0-9]*\.?[0-9]+)")
CALLED = re.compile(rb"[ \t]*(?<![A-Z])(?:G[ \t]*79|M[ \t]*0*99)(?![0-9])")
FEED = re.compile(rb"(?<![A-Z])F[ \t]*([0-9]*\.?[0-9]+)")
DWELL = re.compile(rb"(?<![A-Z])G[ \t]*0*4(?![0-9])")  # its F is a time
NUMBER = re.compile(rb"[ \t]*(?:/[ \t]*)?(?:N[ \t]*[0-9]+[ \t]*)?")
TOOL = re.compile(rb"(?<![A-Z])T[ \t]*([0-9]+)")
RADIUS = re.compile(rb"(?<![A-Z])R[ \t]*([+]?[0-9]*\.?[0-9]+)")
DEFINES = re.compile(rb"(?<![A-Z])G[ \t]*99(?![0-9])")
LABEL = re.compile(rb"(?<![A-Z;])L[ \t]*[0-9]+[ \t]*,", re.IGNORECASE)
MOTION = re.compile(rb"(?<![A-Z])G[ \t]*0*([0-35-7]|1[0-6])(?![0-9])")
PLAIN_MOTIONS = (0, 1)


class IsoHoles(Before):
    """Follows the cycle that is defined and the feed, and writes out its calls."""

    codes = (CALL_CODE,)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.holes, self.tool = Holes(scene), Tool(scene)
        self.feed, self.motion = b"", -1  # as the program named them last

    def take(self, line: Line) -> list[Line]:
        """The line, or the lines that it becomes. Raises ProgramError."""
        if self.scene.passes(line.text):
            return [line]
        body, star, rest = line.text.partition(b"*")
        code = body.partition(b";")[0].upper()
        defined = DEFINED.search(code)
        if defined:
            self.holes.define(int(defined[1]))
            self.holes.data = {int(q): value for q, value in DATUM.findall(code)}
            return [line]
        self._note(code)
        for motion in MOTION.findall(code):
            self.motion = int(motion)
        feed = FEED.search(without_own_feed(code))
        if feed and not DWELL.search(code):
            self.feed = feed[1]
        if not CALLED.search(code):
            return [line]
        self._may_be_called()
        #  N40 G00 X+10 Y+20 M99 *    without its call the block moves to the place, then the hole
        #  N50 G79 *                  nothing is left: the hole alone, where the tool stands
        bare = CALLED.sub(b"", body)
        number = NUMBER.match(bare)
        assert number is not None
        lines = [bare + star + rest] if bare[number.end() :].strip() else []
        # The block of the call moves first, and nobody has followed it yet.
        for word in Block.of(bare, self.scene.dialect.grammar).words:
            if word.letter in "XYZ" and word.value is not None:
                self.scene.moved(word.letter, word.value)
        lines += self._holes()
        return [line._replace(text=text) for text in lines]

    def _note(self, code: bytes) -> None:
        """What a block says of the tool and the spindle."""
        self.tool.note(code)
        found = TOOL.search(code)
        if found and DEFINES.search(code):
            radius = RADIUS.search(code)
            if radius:
                self.tool.defined[f"T{int(found[1])}"] = float(radius[1])
        elif found:
            delta = DELTA.search(code)
            self.tool.name = f"T{int(found[1])}"
            self.tool.more = float(delta[1]) if delta else 0.0

    def _may_be_called(self) -> None:
        scene = self.scene
        scene.forget()
        # L1,2 runs the blocks behind G98 L1 twice more: which cycle holds there the text does not
        # say.
        if any(LABEL.search(text.partition(b";")[0]) for text in scene.lines()):
            raise scene.fault(
                "a cycle in a program that calls labels", "write the program out without L first"
            )
        if scene.incremental or scene.plane[2] != "Z":
            raise scene.fault(
                "a cycle is called in G91, or not along Z", "write G90 and G17 before"
            )
        if self.motion not in PLAIN_MOTIONS:
            raise scene.fault(
                "a cycle is called where neither G00 nor G01 is in force", "write G00 before it"
            )

    def _holes(self) -> list[bytes]:
        """The holes, and what was in force before them."""
        lines = []
        for text in called(self.scene, self.tool, self.holes):
            lines += self._iso(text)
        if lines:
            feed = b" F" + self.feed if self.feed else b""
            # Modal again as the program left them: a hole ends with G00 and its own feed.
            lines.append(b"G%02d" % self.motion + feed + b"*")
        return lines

    def _iso(self, text: bytes) -> list[bytes]:
        """A statement of Klartext as a block."""
        if text.startswith(b"CYCL"):
            dwell = text.partition(b"DWELL ")[2]
            return [] if dwell == b"TIME" else [b"G04 F" + dwell + b"*"]
        words = text.split(b" ")[1:]
        code = b"G00" if b"FMAX" in words else b"G01"
        return [b" ".join([code, *(w for w in words if w != b"FMAX")]) + b"*"]
