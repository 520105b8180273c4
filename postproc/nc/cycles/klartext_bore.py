"""Bore milling of Heidenhain Klartext, cycle 208, written out as L.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, cycle programming, "Bore milling": from the
set-up clearance Q200 above the surface Q203 the tool goes to the wall of the bore (Q335 across),
down along a helix of Q334 a turn at Q206 to the depth Q201, once around there, back to the middle
and FMAX to the clearance, then to the second one, Q204, where it lies higher. Q351 +1 is climb
milling (with M3 against the clock), -1 up-cut.

Wall, depth and direction are those of the manual. How the tool gets to the wall the manual leaves
open ("on a rounded arc if enough space is available"): here along X, at the clearance, above the
part. Every turn goes equally deep, Q334 at most. Refused: no radius of the tool, a bore no wider
than the tool, no Q351, a spindle that does not turn by M3.
"""

from __future__ import annotations

import math
import re

from postproc.nc.comments import STRINGS
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_lines import Lines
from postproc.nc.cycles.pole_arc import Arc, ends
from postproc.nc.cycles.scene import Scene

TOOL_DEF = re.compile(rb"TOOL[ \t]+DEF[ \t]*([0-9]+)[^;]*?(?<![A-Z])R[ \t]*([+]?[0-9]*\.?[0-9]+)")
TOOL_CALL = re.compile(rb"TOOL[ \t]+CALL[ \t]*(?:([0-9]+)|(\"[^\"]*\"))?")
DELTA = re.compile(rb"(?<![A-Z])DR[ \t]*([-+]?[0-9]*\.?[0-9]+)")
SPINDLE = re.compile(rb"(?<![A-Z])M[ \t]*0*([345]|13|14)(?![0-9])")
BORE = 208
MOST_TURNS = 10_000
NEAR = 1e-9
HELP = "let the CAM program write this bore out as L"


class Tool:
    """The radius of the tool in the spindle, as far as the program or the user says it, and the way
    the spindle turns."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.defined: dict[str, float] = {}
        self.name, self.more, self.turn = "", 0.0, 0

    def note(self, code: bytes) -> None:
        """What a statement says of it."""
        if found := TOOL_DEF.match(code):
            self.defined[f"T{int(found[1])}"] = float(found[2])
        elif called := TOOL_CALL.match(code):
            if called[1] or called[2]:
                # A tool by its name has no number: 9999, as klartext.py hands it on.
                self.name = f"T{int(called[1])}" if called[1] else "T9999"
            delta = DELTA.search(STRINGS.sub(b"", code))
            self.more = float(delta[1]) if delta else 0.0
        for spindle in SPINDLE.findall(STRINGS.sub(b"", code)):
            self.turn = {3: 1, 13: 1, 4: -1, 14: -1}.get(int(spindle), 0)

    def radius(self, cycle: int) -> float:
        """Program's unit. Raises ProgramError."""
        if self.name in self.defined:
            return self.defined[self.name] + self.more
        tracker, name = self.scene.tracker, self.name or "T1"
        place = tracker.state.offsets.get(name) or tracker.setup.offsets.get(name) or {}
        if not self.name or "R" not in place:
            raise self.scene.fault(
                f"the radius of the tool of cycle {cycle} is not stated",
                f"say it in mm: --offset {name}=Z0,R5",
            )
        # --offset is in mm, TOOL DEF and DR in the program's unit.
        return place["R"] / self.scene.unit + self.more

    def check_sense(self, cycle: int, way: float) -> None:
        """`way`: Q351. Raises ProgramError where it is not said which way a cycle turns."""
        if way not in (1.0, -1.0):
            raise self.scene.fault(
                f"cycle {cycle} without Q351, the way that it turns",
                "write Q351=+1 for climb milling, Q351=-1 for up-cut",
            )
        if self.turn != 1:
            raise self.scene.fault(
                f"cycle {cycle} where the spindle does not turn by M3", "write M3 before it"
            )


def bore(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """The cycle where the tool stands. Raises ProgramError."""
    clear, depth, top, pitch, wide = (data.value(n) for n in (200, 201, 203, 334, 335))
    way, feed, radius = data.value(351, 0.0), data.feed(206), tool.radius(BORE)
    reach = wide / 2 - radius
    if reach < NEAR:
        raise scene.fault(
            f"the bore of cycle 208 is {wide:g} wide, and the tool {2 * radius:g}", HELP
        )
    tool.check_sense(BORE, way)
    #  Q200  ---. o .---    From the middle o to the wall at the clearance, above the part, where
    #  Q203  === '. .' =    its way does not matter; down by Q334 a turn at most, all alike; once
    #        | .'- -'. |    around at the depth, and back to the middle.
    #        |  '- -'  |
    #  Q201  '---------'
    high, low = top + clear, top + depth
    turns = math.ceil((high - low) / pitch - NEAR) if pitch > NEAR else MOST_TURNS + 1
    if turns > MOST_TURNS:
        raise scene.fault("cycle 208 with too many turns", "check Q201 and Q334")
    x, y = scene.at("X"), scene.at("Y")
    wall = x + reach, y
    # In a bore climb milling with M3 goes counter-clockwise, so Q351 is the sense of the arc
    # itself.
    circle = ends(scene, Arc(wall, wall, (x, y), way, math.tau))
    lines = Lines(scene)
    lines.to(None, high)
    lines.to(wall, None, feed)
    count = turns * len(circle)
    for k in range(count):
        lines.to(circle[k % len(circle)], high + (low - high) * (k + 1) / count, feed)
    for place in [*circle, (x, y)]:
        lines.to(place, None, feed)
    lines.to(None, high)
    second = data.value(204, clear)
    if second > clear:
        lines.to(None, top + second)
    return lines.texts
