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

from postproc.nc.cycles.klartext_holes import signed
from postproc.nc.cycles.pole_arc import Arc, ends
from postproc.nc.cycles.scene import Scene

TOOL_DEF = re.compile(rb"TOOL[ \t]+DEF[ \t]*([0-9]+)[^;]*?(?<![A-Z])R[ \t]*([+]?[0-9]*\.?[0-9]+)")
TOOL_CALL = re.compile(rb"TOOL[ \t]+CALL[ \t]*(?:([0-9]+)|(\"[^\"]*\"))?")
DELTA = re.compile(rb"(?<![A-Z])DR[ \t]*([-+]?[0-9]*\.?[0-9]+)")
SPINDLE = re.compile(rb"(?<![A-Z])M[ \t]*0*([345]|13|14)(?![0-9])")
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
                self.name = f"T{int(called[1])}" if called[1] else "T9999"
            delta = DELTA.search(code)
            self.more = float(delta[1]) if delta else 0.0
        for spindle in SPINDLE.findall(code):
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
        return place["R"] / self.scene.unit + self.more


def bore(scene: Scene, tool: Tool, data: dict[int, float], feed: bytes) -> list[bytes]:
    """The cycle where the tool stands; `data`: its values by number. Raises ProgramError."""
    radius = tool.radius(208)
    reach, pitch = data[335] / 2 - radius, data[334]
    if reach < NEAR:
        raise scene.fault(
            f"the bore of cycle 208 is {data[335]:g} wide, and the tool {2 * radius:g}", HELP
        )
    if data.get(351) not in (1.0, -1.0):
        raise scene.fault(
            "cycle 208 without Q351, the way that it turns",
            "write Q351=+1 for climb milling, Q351=-1 for up-cut",
        )
    if tool.turn != 1:
        raise scene.fault("cycle 208 where the spindle does not turn by M3", "write M3 before it")
    high, low = data[203] + data[200], data[203] + data[201]
    turns = math.ceil((high - low) / pitch - NEAR) if pitch > NEAR else MOST_TURNS + 1
    if turns > MOST_TURNS:
        raise scene.fault("cycle 208 with too many turns", "check Q201 and Q334")
    x, y = scene.at("X"), scene.at("Y")
    wall = x + reach, y
    circle = ends(scene, Arc(wall, wall, (x, y), data[351], math.tau))

    def to(place: tuple[float, float], z: float | None, end: bytes = b"") -> bytes:
        words = [signed(scene, axis, v) for axis, v in zip("XY", place, strict=True)]
        words += [] if z is None else [signed(scene, "Z", z)]
        return b"L " + b" ".join(words) + end

    lines = [b"L " + signed(scene, "Z", high) + b" FMAX", to(wall, None, feed)]
    count = turns * len(circle)
    for k in range(count):
        z = high + (low - high) * (k + 1) / count
        lines.append(to(circle[k % len(circle)], z))
    lines += [to(place, None) for place in circle]
    return [*lines, to((x, y), None), b"L " + signed(scene, "Z", high) + b" FMAX"]
