"""Mirrored and turned coordinates of Heidenhain Klartext, cycles 8 and 10: the lines behind them
written in the coordinates beneath.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, cycle programming, "Mirroring (cycle 8)",
"Rotation (cycle 10)": about the active datum, which cycle 7 or a preset has set; the angle counts
from X in the working plane, IROT from the angle in force; ROT 0 and cycle 8 without axes end them;
a mirror of one axis turns the sense of motions round (RL becomes RR). Cycle 247 resets both. What
depends on places (poles, corners, cycles) is written out first, in the program's coordinates
(klartext_paths.py); on the control the cycles stand at nothing then, as ROT+0 and 8.1.

Refused: both together and a datum shift of the axes that they mix, for their order is not said in a
text that was found; a mirrored tool axis; scaling (11, 26), which reaches the tool axis or not by a
parameter of the machine; APPR and DEP, and tilted planes within.
"""

from __future__ import annotations

import re

from postproc.nc.cycles.affine import AXES, Affine, point, rotation, scaling
from postproc.nc.cycles.klartext_holes import signed
from postproc.nc.cycles.klartext_paths import KlartextPaths
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line
from postproc.nc.klartext import BUILDER, HEAD, MACHINE

MIRROR, ROTATION, PRESET, SHIFT = 8, 10, 247, 7
DEFINED = re.compile(rb"CYCL[ \t]+DEF[ \t]*([0-9]+)[ \t]*(?:\.[ \t]*([0-9]+))?")
ANGLE = re.compile(rb"(I?)ROT[ \t]*([-+]?[0-9]*\.?[0-9]+)")
PLACE = re.compile(rb"(?<![A-Z])(I?)([XY])[ \t]*([-+]?[0-9]*\.?[0-9]+)")
MOVED = re.compile(rb"(?<![A-Z])I?[XY][ \t]*[-+]?[0-9]*\.?[0-9]*[1-9]")
SIDE = re.compile(rb"(?<=[ \t])R([LR])(?![A-Z0-9.+-])")
STRAIGHT = re.compile(rb"L(?![A-Z])")
REFUSED = re.compile(rb"(APPR|DEP|PLANE)(?![A-Z])(?![ \t]+RESET)")
DATUM = re.compile(rb"TRANS[ \t]+DATUM(?![ \t]+RESET)")
END = "end it before: CYCL DEF 10.1 ROT+0, CYCL DEF 8.1"


class KlartextTurns:
    """The map in force, and what comes before it. `exact`: the programmed place behind the last
    line, before rounding, and the place as it was written."""

    rigid = False
    codes = KlartextPaths.codes

    def __init__(self, scene: Scene):
        self.scene, self.paths = scene, KlartextPaths(scene)
        self.map, self.angle = Affine(), 0.0
        self.mirrored: tuple[str, ...] = ()
        self.loose = False  # whether the control's manual leaves open where X and Y stand
        self.tilted = False
        self.exact: tuple[dict[str, float], dict[str, float]] = {}, {}
        scene.frame = self.known

    def wants(self, line: Line) -> bool:
        return self.paths.wants(line)

    def finish(self) -> list[Line]:
        return [line._replace(text=self._mapped(line.text, {})) for line in self.paths.finish()]

    def known(self, axis: str) -> float | None:
        """The programmed coordinate at which an axis stands."""
        if axis not in ("X", "Y") or self.map.identity:
            return self.scene.work(axis)
        work = {x: self.scene.work(x) for x in self.map.partners(axis)}
        if self.loose or any(value is None for value in work.values()):
            return None
        programmed, written = self.exact
        if all(written.get(x) == self.scene.rounded(x, v or 0.0) for x, v in work.items()):
            return programmed[axis]
        return self.map.inverse(point(work))[AXES.index(axis)]

    def take(self, line: Line) -> list[Line]:
        """The line, or the lines that it becomes. Raises ProgramError."""
        head = HEAD.match(line.text)
        assert head is not None
        code = line.text[head.end() :].partition(b";")[0].rstrip(b" \t\r~")
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
        """Whether cycle 7 moves an axis of the plane, but for back to the preset."""
        found = DEFINED.match(code)
        return bool(found and int(found[1]) == SHIFT and MOVED.search(code[found.end() :]))

    def _define(self, code: bytes) -> list[bytes] | None:
        """What stays of cycle 8 or 10; None: the line is none of them."""
        found = DEFINED.match(code)
        number = int(found[1]) if found else 0
        if number == PRESET:
            self._hold((), 0.0)
        if found is None or number not in (MIRROR, ROTATION) or found[2] in (None, b"0"):
            return None
        rest = code[found.end() :].upper()
        if number == MIRROR:
            axes = tuple(rest.decode().split())
            if any(x not in ("X", "Y") for x in axes):
                raise self.scene.fault(
                    f"cycle 8 with {' '.join(axes)}", "only X and Y of the plane are mirrored"
                )
            self._hold(axes, self.angle)
            return [code[: found.end()] if axes else code]
        angle = ANGLE.search(rest)
        if angle is None:
            raise self.scene.fault("cycle 10 without its angle", "write CYCL DEF 10.1 ROT+30")
        value = float(angle[2])
        self._hold(self.mirrored, value + (self.angle if angle[1] else 0.0))
        return [code if value == 0.0 and not angle[1] else code[: found.end()] + b" ROT+0"]

    def _hold(self, mirrored: tuple[str, ...], angle: float) -> None:
        """Another map holds from here on."""
        if mirrored and angle % 360:
            raise self.scene.fault("a mirror and a turn at once (cycles 8 and 10)", END)
        new = rotation("X", "Y", angle % 360) if angle % 360 else Affine()
        new = scaling(dict.fromkeys(mirrored, -1.0)) if mirrored else new
        self.mirrored, self.angle = mirrored, angle
        if new == self.map:
            return
        if self.tilted or self.scene.compensated:
            within = "a tilted plane" if self.tilted else "cutter radius compensation"
            raise self.scene.fault(f"cycle 8 or 10 within {within}", "end it before")
        if self.paths.corners.at_work:
            raise self.paths.corners.beside()
        self.paths.heading.lose()
        self.paths.pole = {}
        self.map, self.exact = new, ({}, {})
        self.loose = len(new.partners("X")) > 1
        self.scene.forget()

    def _mapped(self, text: bytes, here: dict[str, float]) -> bytes:
        """A straight line in the coordinates beneath; `here`: where the line's own statement has
        led to so far."""
        head = HEAD.match(text)
        assert head is not None
        body, semicolon, remark = text[head.end() :].partition(b";")
        if self.map.identity or not STRAIGHT.match(body):
            return text
        if MACHINE.search(body) or BUILDER.search(body):
            here.clear()
            return text
        if self.map.similarity("X", "Y") == -1.0:
            body = SIDE.sub(lambda m: b"R" + (b"R" if m[1] == b"L" else b"L"), body)
        words = list(PLACE.finditer(body))
        if words:
            body = self._placed(body, words, here)
        return text[: head.end()] + body + semicolon + remark

    def _end(
        self, words: list[re.Match[bytes]], here: dict[str, float], mixed: list[str]
    ) -> dict[str, float | None]:
        """The programmed X and Y behind a line. Raises ProgramError where one that is needed is not
        known."""
        to = {x: here[x] if x in here else self.known(x) for x in ("X", "Y")}
        for match in words:
            axis = match[2].decode()
            start = to[axis] if match[1] else 0.0
            to[axis] = float(match[3]) + (self.scene.at(axis) if start is None else start)
        for axis in mixed:
            if to[axis] is None:
                self.scene.at(axis)
        return to

    def _placed(self, body: bytes, words: list[re.Match[bytes]], here: dict[str, float]) -> bytes:
        """The same with other X and Y."""
        scene, named = self.scene, [match[2].decode() for match in words]
        mixed = list(self.map.partners(named[0])) if len(named) == 1 else ["X", "Y"]
        if self.loose and (set(mixed) - set(named) or any(match[1] for match in words)):
            raise scene.fault(
                "the first line within other coordinates does not name X and Y as places",
                "write both, without I, behind cycles 8 and 10",
            )
        to = self._end(words, here, mixed)
        here |= {x: v for x in mixed if (v := to[x]) is not None}
        out = dict(zip(AXES, self.map(point(to)), strict=True))
        self.loose = False
        self.exact = dict(here), {x: scene.rounded(x, out[x]) for x in here}
        first = words[0]
        for match in reversed(words[1:]):
            body = body[: match.start()].rstrip(b" \t") + body[match.end() :]
        texts = b" ".join(signed(scene, x, out[x]) for x in mixed)
        return body[: first.start()] + texts + body[first.end() :]
