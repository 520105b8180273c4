"""Mirrored, turned and scaled coordinates of Heidenhain Klartext, cycles 8, 10, 11 and 26: the
lines behind them written in the coordinates beneath.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, cycle programming, "Mirroring (cycle 8)",
"Rotation (cycle 10)": about the active datum, which cycle 7 or a preset has set; the angle counts
from X in the working plane, IROT from the angle in force; ROT 0 and cycle 8 without axes end them;
a mirror of one axis turns the sense of motions round (RL becomes RR). "Scaling (cycle 11)": every
coordinate by SCL from the active datum, about which mirror, turn and factor can be exchanged; in
the plane or along Z too by MP 7410 (iTNC 530), which --scaling says. "Axis-specific scaling (cycle
26)": a factor per axis about CCX, CCY. Cycle 247 resets them. What depends on places (poles,
corners, cycles) is written out first, in the program's coordinates (klartext_paths.py); on the
control the cycles stand at nothing then, as ROT+0 and 8.1.

Refused: mirror and turn together, cycle 26 with another, and a datum shift of the axes that they
change, for their order is not said in a text that was found; a mirrored tool axis; APPR and DEP,
and tilted planes within; factors above 10, by which chords of arcs would grow.
"""

from __future__ import annotations

import re

from postproc.nc.comments import uncommented
from postproc.nc.cycles.affine import AXES, Affine, point, rotation, scaling
from postproc.nc.cycles.before import Before
from postproc.nc.cycles.klartext_holes import TAPS
from postproc.nc.cycles.klartext_lines import signed
from postproc.nc.cycles.klartext_paths import KlartextPaths
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line
from postproc.nc.grammar import KLARTEXT
from postproc.nc.klartext import BUILDER, HEAD, MACHINE

MIRROR, ROTATION, SCALE, STRETCH, PRESET, SHIFT = 8, 10, 11, 26, 247, 7
LARGEST = 10.0  # factor
DEFINED = re.compile(rb"CYCL[ \t]+DEF[ \t]*([0-9]+)[ \t]*(?:\.[ \t]*([0-9]+))?")
ANGLE = re.compile(rb"(I?)ROT[ \t]*([-+]?[0-9]*\.?[0-9]+)")
FACTOR = re.compile(rb"(?<![A-Z])(SCL|CC[XYZ]|[XYZ])[ \t]*([-+]?[0-9]*\.?[0-9]+)")
PLACE = re.compile(rb"(?<![A-Z])(I?)([XYZ])[ \t]*([-+]?[0-9]*\.?[0-9]+)")
MOVED = re.compile(rb"(?<![A-Z])I?([XYZ])[ \t]*[-+]?[0-9]*\.?[0-9]*[1-9]")
SIDE = re.compile(rb"(?<=[ \t])R([LR])(?![A-Z0-9.+-])")
STRAIGHT = re.compile(rb"L(?![A-Z])")
REFUSED = re.compile(rb"(APPR|DEP|PLANE)(?![A-Z])(?![ \t]+RESET)")
DATUM = re.compile(rb"TRANS[ \t]+DATUM(?![ \t]+RESET)")
END = "end it before: CYCL DEF 10.1 ROT+0, 8.1, 11.1 SCL 1, 26.1 X1 Y1"


class KlartextTurns(Before):
    """The map in force, and what comes before it. `exact`: the programmed place behind the last
    line, before rounding, and the place as it was written."""

    codes = KlartextPaths.codes

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.paths = KlartextPaths(scene)
        self.map, self.angle, self.factor = Affine(), 0.0, 1.0
        self.mirrored: tuple[str, ...] = ()
        self.stretch = Affine()  # cycle 26
        self.loose = False  # whether the control's manual leaves open where X and Y stand
        self.tilted = False
        self.exact: tuple[dict[str, float], dict[str, float]] = {}, {}
        scene.frame = self.known

    def finish(self) -> list[Line]:
        """What the paths still hold, in the coordinates beneath."""
        return [line._replace(text=self._mapped(line.text, {})) for line in self.paths.finish()]

    def known(self, axis: str) -> float | None:
        """The programmed coordinate at which an axis stands."""
        if self.map.leaves(axis):
            return self.scene.work(axis)
        work = {x: self.scene.work(x) for x in self.map.partners(axis)}
        if self.loose or any(value is None for value in work.values()):
            return None
        # Not back from the written place, which was rounded: of I words the roundings would add up.
        programmed, written = self.exact
        if all(written.get(x) == self.scene.rounded(x, v or 0.0) for x, v in work.items()):
            return programmed[axis]
        return self.map.inverse(point(work))[AXES.index(axis)]

    def take(self, line: Line) -> list[Line]:
        """The line, or the lines that it becomes. Raises ProgramError."""
        head = HEAD.match(line.text)
        assert head is not None
        code = uncommented(line.text, KLARTEXT)[head.end() :].rstrip(b" \t\r~")
        if self.scene.passes(line.text):
            return self.paths.take(line)
        if code.startswith(b"PLANE"):
            self.tilted = b"RESET" not in code
        new = self._define(code)
        if new is not None:
            if head[1]:
                raise self.scene.fault("a turn in blocks that / may take out", "take the / out")
            return [line._replace(text=text) for text in new]
        if self.map.identity:
            return self.paths.take(line)
        if REFUSED.match(code):
            raise self.scene.fault(f"{code.split()[0].decode()} within turned coordinates", END)
        if DATUM.match(code) or self._shifts(code):
            raise self.scene.fault("a datum shift within turned coordinates", END)
        here: dict[str, float] = {}
        return [
            plain._replace(text=self._mapped(plain.text, here)) for plain in self.paths.take(line)
        ]

    def _shifts(self, code: bytes) -> bool:
        """Whether cycle 7 moves an axis that the map changes, but for back to the preset."""
        found = DEFINED.match(code)
        if not found or int(found[1]) != SHIFT:
            return False
        moved = MOVED.findall(code[found.end() :])
        return any(not self.map.leaves(axis.decode()) for axis in moved)

    # Whole: one cycle after the other, each with its own words.
    def _define(self, code: bytes) -> list[bytes] | None:
        """What stays of cycle 8, 10, 11 or 26; None: the line is none of them."""
        found = DEFINED.match(code)
        number = int(found[1]) if found else 0
        if number == PRESET:
            self.mirrored, self.angle, self.factor, self.stretch = (), 0.0, 1.0, Affine()
            self._hold()
        own = (MIRROR, ROTATION, SCALE, STRETCH)
        if found is None or number not in own or found[2] in (None, b"0"):
            return None
        #  CYCL DEF 10.1 ROT+30     the map turns; what stays is ROT+0
        #  CYCL DEF 8.1 X           the map mirrors; what stays is 8.1, which mirrors nothing
        #  CYCL DEF 11.1 SCL 1.2    the map scales; what stays is SCL 1
        rest = code[found.end() :].upper()
        if number in (SCALE, STRETCH):
            self._scaled(number, rest)
            return [code[: found.end()] + (b" SCL 1" if number == SCALE else b" X1 Y1")]
        if number == MIRROR:
            axes = tuple(rest.decode().split())
            if any(x not in ("X", "Y") for x in axes):
                raise self.scene.fault(
                    f"cycle 8 with {' '.join(axes)}", "only X and Y of the plane are mirrored"
                )
            self.mirrored = axes
            self._hold()
            return [code[: found.end()] if axes else code]
        angle = ANGLE.search(rest)
        if angle is None:
            raise self.scene.fault("cycle 10 without its angle", "write CYCL DEF 10.1 ROT+30")
        value = float(angle[2])
        self.angle = value + (self.angle if angle[1] else 0.0)
        self._hold()
        return [code if value == 0.0 and not angle[1] else code[: found.end()] + b" ROT+0"]

    def _scaled(self, number: int, rest: bytes) -> None:
        """Cycle 11 or 26 with its words."""
        words = {name.decode(): float(value) for name, value in FACTOR.findall(rest)}
        factors = {x: v for x, v in words.items() if not x.startswith("CC")}
        if not factors or any(not 0 < v <= LARGEST for v in factors.values()):
            raise self.scene.fault(
                f"a factor of cycle {number} that is missing, or is not above 0 to {LARGEST:g}",
                "write CYCL DEF 11.1 SCL 0.995, or 26.1 X1.1 Y0.9 CCX+15 CCY+20",
            )
        if number == SCALE:
            self.factor = words.get("SCL", 1.0)
        else:
            centre = {x: words.get("CC" + x, 0.0) for x in AXES}
            self.stretch = scaling({x: factors.get(x, 1.0) for x in AXES}, point(centre))
        self._hold()

    def _factors(self) -> dict[str, float]:
        """Of cycle 11."""
        how = self.scene.tracker.setup.scaling
        if self.factor != 1.0 and not how:
            raise self.scene.fault(
                "whether cycle 11 scales Z too is a parameter of the machine (MP 7410)",
                "say it: --scaling plane for X and Y alone, or --scaling space",
            )
        return dict.fromkeys("XYZ" if how == "space" else "XY", self.factor)

    def _hold(self) -> None:
        """The map that holds from here on."""
        turned, mirrored = bool(self.angle % 360), self.mirrored
        if mirrored and turned:
            raise self.scene.fault("a mirror and a turn at once (cycles 8 and 10)", END)
        # Mirror, turn and factor about one datum: a factor alike in the plane can be exchanged with
        # both.
        new = rotation("X", "Y", self.angle % 360) if turned else Affine()
        new = scaling(dict.fromkeys(mirrored, -1.0)) if mirrored else new
        if self.factor != 1.0:
            new = scaling(self._factors()).after(new)
        if not self.stretch.identity:
            if not new.identity:
                raise self.scene.fault("cycle 26 within cycle 8, 10 or 11", END)
            new = self.stretch
        if new == self.map:
            return
        if self.tilted or self.scene.compensated:
            within = "a tilted plane" if self.tilted else "cutter radius compensation"
            raise self.scene.fault(f"other coordinates within {within}", "end it before")
        if self.paths.corners.at_work:
            raise self.paths.corners.beside()
        self.paths.heading.lose()
        # The pole was set in the coordinates that end here.
        self.paths.pole = {}
        self.map, self.exact = new, ({}, {})
        # A mirror or a factor leaves X in X; a turn mixes X and Y, and the next line must name
        # both.
        self.loose = len(new.partners("X")) > 1
        self.scene.forget()

    def _mapped(self, text: bytes, here: dict[str, float]) -> bytes:
        """A straight line in the coordinates beneath; `here`: where the line's own statement has
        led to so far."""
        head = HEAD.match(text)
        assert head is not None
        body, semicolon, remark = text[head.end() :].partition(b";")
        if self.map.identity:
            return text
        if body.startswith(b"CYCL CALL") and not self._as_it_is():
            raise self.scene.fault(f"cycle {self.paths.holes.cycle} in other coordinates", END)
        if not STRAIGHT.match(body):
            return text
        if MACHINE.search(body) or BUILDER.search(body):
            here.clear()
            return text
        if (self.map.similarity("X", "Y") or 1.0) < 0:  # in a mirror left of the way is right
            body = SIDE.sub(lambda m: b"R" + (b"R" if m[1] == b"L" else b"L"), body)
        words = [m for m in PLACE.finditer(body) if not self.map.leaves(m[2].decode())]
        if words:
            body = self._placed(body, words, here)
        return text[: head.end()] + body + semicolon + remark

    def _end(
        self, words: list[re.Match[bytes]], here: dict[str, float], mixed: list[str]
    ) -> dict[str, float | None]:
        """The programmed places of `mixed` axes behind a line. Raises ProgramError where one of
        them is not known."""
        to = {x: here[x] if x in here else self.known(x) for x in mixed}
        for match in words:
            axis = match[2].decode()
            start = to[axis] if match[1] else 0.0
            to[axis] = float(match[3]) + (self.scene.at(axis) if start is None else start)
        for axis in mixed:
            if to[axis] is None:
                self.scene.at(axis)
        return to

    def _as_it_is(self) -> bool:
        """Whether the cycle that is called, and stays, does the same in the coordinates beneath."""
        return self.paths.holes.cycle in TAPS and self.map.leaves("Z")

    def _placed(self, body: bytes, words: list[re.Match[bytes]], here: dict[str, float]) -> bytes:
        """The same with other X, Y and Z."""
        scene, named = self.scene, [match[2].decode() for match in words]
        mixed = sorted({x for axis in named for x in self.map.partners(axis)})
        if self.loose and (set(mixed) - set(named) or any(match[1] for match in words)):
            raise scene.fault(
                "the first line within other coordinates does not name X and Y as places",
                "write both, without I, behind cycles 8 and 10",
            )
        to = self._end(words, here, mixed)
        here |= {x: v for x in mixed if (v := to[x]) is not None}
        out = dict(zip(AXES, self.map(point(to)), strict=True))
        self.loose = False
        # The place as it was meant, and as it is written: while the tracker says the latter, an I
        # word counts from the former.
        self.exact = dict(here), {x: scene.rounded(x, out[x]) for x in here}
        first = words[0]
        # From behind: places in front of a word that goes out stay what they are.
        for match in reversed(words[1:]):
            body = body[: match.start()].rstrip(b" \t") + body[match.end() :]
        texts = b" ".join(signed(scene, x, out[x]) for x in mixed)
        return body[: first.start()] + texts + body[first.end() :]
