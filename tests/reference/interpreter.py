"""NC text in, motions out: two dialects read one character and one block at a time, positions in
exact fractions.

Written from the languages, to judge the product: it imports nothing of it. What it does not know it
refuses.

linuxcnc      `;` begins a comment, G7/G8, G90.1/G91.1, P turns, G17 at the start.
fanuc-lathe   G-code system B: G90/G91, U V W are increments of X Y Z, `;` ends a block, comments in
              ( ) only, G4 takes X, U (s) or P (ms), G18 at the start. A number without a point
              counts whole units (mm, inch).

Positions are slide positions in machine coordinates, mm, radius. I J K R are radius values always.
"""

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

INCH = Fraction(254, 10)
DIALECTS = ("linuxcnc", "fanuc-lathe")
PLANES = {"G17": ("X", "Y"), "G18": ("Z", "X"), "G19": ("Y", "Z")}
CENTRE_LETTER = {"X": "I", "Y": "J", "Z": "K"}
INCREMENT_OF = {"U": "X", "V": "Y", "W": "Z"}

GROUPS = [
    {"G0", "G1", "G2", "G3"},
    {"G4", "G28", "G30", "G53"},
    {"G17", "G18", "G19"},
    {"G20", "G21"},
    {"G7", "G8"},
    {"G90", "G91"},
    {"G90.1", "G91.1"},
    {"G93", "G94", "G95"},
    {"G54", "G55", "G56", "G57", "G58", "G59"},
    {"G40"},
    {"G49"},
    {"G61", "G61.1", "G64"},
    {"G96", "G97"},
    {"G98", "G99"},
    {"G92"},
    {"G80"},
]
ONLY_LINUXCNC = {"G7", "G8", "G90.1", "G91.1", "G49", "G61.1"}
ONLY_FANUC = {"G92"}  # spindle speed limit; with axis words it is refused
REFUSED_M = {96, 97, 98, 99, 198}

# An arc is refused whose radii differ by 0.5 mm, or by both 0.0283 mm and 0.1 % (seen of LinuxCNC
# 2.9).
SPIRAL_LIMIT, SPIRAL_FINE, SPIRAL_PART = 0.5, 0.0283, 0.001
SHORT_RADIUS = 0.005  # mm that R may be too short to reach across, from rounding


class NotUnderstood(ValueError):
    """A place and a fact: the text is not in the language that the reference speaks."""


@dataclass
class Block:
    """One block and what it makes the machine do; start and end: {axis: mm, or None when
    unknown}."""

    line: int
    number: int
    kind: str  # rapid feed arc dwell none machine
    start: dict
    end: dict
    feed: float | None = None  # mm/min, mm/rev or 1/min, by feed_mode
    feed_mode: str = "G94"
    plane: str | None = None  # of an arc: G17 G18 G19
    centre: tuple | None = None  # of an arc: along the plane's first and second axis, mm
    sweep: float | None = None  # of an arc: rad, + from the first axis to the second
    dwell: float | None = None  # s
    codes: tuple = field(default=())  # M, S and T words, in order: ("M3", "S1200")

    @property
    def known(self):
        """Both ends are known in all axes."""
        return None not in self.start.values() and None not in self.end.values()

    @property
    def plane_axes(self):
        return PLANES[self.plane]

    def polar(self, t):
        """(angle, radius) of an arc at t."""
        angle, r0, r1 = self._arms
        return angle + self.sweep * t, r0 + (r1 - r0) * t

    @cached_property
    def _arms(self):
        """Of an arc: the angle of its start, the radius there and at its end."""
        first, second = self.plane_axes
        u0, v0 = self.start[first] - self.centre[0], self.start[second] - self.centre[1]
        u1, v1 = self.end[first] - self.centre[0], self.end[second] - self.centre[1]
        return math.atan2(v0, u0), math.hypot(u0, v0), math.hypot(u1, v1)

    def point(self, t):
        """{axis: mm} at t in [0, 1]; linear in t, on arcs the angle, the radius and the other axes
        are."""
        if not self.known:
            raise NotUnderstood(f"line {self.line}: the path is not known")
        if t in (0, 1):
            return dict(self.start if t == 0 else self.end)
        place = {
            axis: self.start[axis] + (self.end[axis] - self.start[axis]) * t for axis in self.start
        }
        if self.kind == "arc":
            angle, radius = self.polar(t)
            first, second = self.plane_axes
            place[first] = self.centre[0] + radius * math.cos(angle)
            place[second] = self.centre[1] + radius * math.sin(angle)
        return place

    @property
    def length(self):
        """mm along the path; None when it is not known."""
        if not self.known:
            return None
        if self.kind != "arc":
            return math.hypot(*(self.end[axis] - self.start[axis] for axis in self.start))
        rest = [
            self.end[axis] - self.start[axis] for axis in self.start if axis not in self.plane_axes
        ]
        r0, r1 = self.polar(0)[1], self.polar(1)[1]
        return math.hypot((r0 + r1) / 2 * self.sweep, r1 - r0, *rest)


def split(text, dialect):
    """Yield (line number, block without comments and blanks, in capitals), one character at a
    time."""
    line, code, comment, rest = 1, [], False, False
    for c in text.rstrip("\n") + "\n":
        if c == "\n":
            if comment:
                raise NotUnderstood(f"line {line}: the comment is not closed")
            yield line, "".join(code)
            line, code, rest = line + 1, [], False
        elif rest:
            pass
        elif comment:
            if c == "(":
                raise NotUnderstood(f"line {line}: a comment in a comment")
            comment = c != ")"
        elif c == "(":
            comment = True
        elif c == ";" and dialect == "linuxcnc":
            rest = True
        elif c == ";":
            yield line, "".join(code)
            code = []
        elif c not in " \t\r":
            code.append(c.upper())


def read_words(code, place):
    """[(letter, Fraction, text)] of a block without comments and blanks."""
    words, i = [], 0
    while i < len(code):
        letter = code[i]
        if not ("A" <= letter <= "Z"):
            raise NotUnderstood(f"{place}: {letter!r} begins no word")
        i += 1
        number = ""
        while i < len(code) and (code[i] in "0123456789." or (code[i] in "+-" and not number)):
            number += code[i]
            i += 1
        if not any(c.isdigit() for c in number) or number.count(".") > 1:
            raise NotUnderstood(f"{place}: {letter}{number} has no number")
        words.append((letter, Fraction(number.replace("+", "")), letter + number))
    return words


def code_name(value, place):
    """Fraction 90.1 -> "G90.1", 1 -> "G1"."""
    tenths = value * 10
    if tenths.denominator != 1 or tenths < 0:
        raise NotUnderstood(f"{place}: G{value} is no code")
    whole, tenth = divmod(int(tenths), 10)
    return f"G{whole}.{tenth}" if tenth else f"G{whole}"


def run(text, dialect, *, axes, diameter=(), offsets={}, block_delete=False, start={}):
    """Run a program; list[Block], one for each block that has a word.

    axes: names of the machine's axes; diameter: those whose words are diameters (G7 and G8
    overrule);
    offsets: {"G54": {axis: mm, radius}}; start: {axis: mm} known before the first block.
    """
    if dialect not in DIALECTS:
        raise ValueError(f"dialect {dialect!r}; known are {DIALECTS}")
    control = Control(dialect, axes, diameter, offsets, start)
    blocks, begun = [], False
    for line, code in split(text, dialect):
        place = f"line {line}"
        if code == "%":
            if begun:
                break
            begun = True
            continue
        if not code:
            continue
        begun = True
        if code[0] == "/":
            code = code[1:]
            if dialect == "fanuc-lathe" and code[:1].isdigit():
                code = code[1:]
            if block_delete:
                continue
        words = read_words(code, place)
        if not words:
            continue
        block = control.execute(words, line, len(blocks), place)
        blocks.append(block)
        if "M2" in block.codes or "M30" in block.codes:
            break
    return blocks


class Control:
    """The modal state; `execute` takes it through one block. Positions are Fractions or None."""

    def __init__(self, dialect, axes, diameter, offsets, start):
        self.dialect, self.axes = dialect, list(axes)
        self.offsets = {
            name: {axis: Fraction(str(value)) for axis, value in entry.items()}
            for name, entry in offsets.items()
        }
        self.position = {
            axis: None if start.get(axis) is None else Fraction(str(start[axis]))
            for axis in self.axes
        }
        self.diameter = set(diameter)
        self.motion, self.feed, self.feed_mode = None, None, "G94"
        self.plane = "G17" if dialect == "linuxcnc" else "G18"
        self.unit, self.incremental, self.absolute_centre = Fraction(1), False, False
        self.offset = self.offsets.get("G54", {})

    def execute(self, words, line, number, place):
        """One block, in the order in which a control does it."""
        codes, extra, values = [], [], {}
        for letter, value, text in words:
            if letter == "G":
                codes.append(code_name(value, place))
            elif letter in "MST":
                if letter == "M" and (
                    value.denominator != 1 or not 0 <= value < 1000 or value in REFUSED_M
                ):
                    raise NotUnderstood(f"{place}: {text} is not supported")
                extra.append(letter + (str(value) if value.denominator == 1 else str(float(value))))
            elif letter in values:
                raise NotUnderstood(f"{place}: {letter} stands twice")
            else:
                values[letter] = value
        self._check(codes, place)
        values.pop("N", None)
        values.pop("O", None)
        begin = dict(self.position)

        self._modes(codes, values, extra, place)
        block = Block(line, number, "none", {}, {}, feed_mode=self.feed_mode, codes=tuple(extra))
        if "F" in values:
            self.feed = values.pop("F") * (1 if self.feed_mode == "G93" else self.unit)
        elif self.feed_mode == "G93" or self.feed_mode_changed:
            self.feed = None
        if "G4" in codes:
            block.kind, block.dwell = "dwell", self._dwell(values, place)
        elif "G28" in codes or "G30" in codes:
            block.kind = "machine"
            self._home(values, place)
        elif "G53" in codes:
            block.kind = "machine"
            self._move_in_machine(values, place)
        else:
            self._move(block, values, place)
        if values:
            raise NotUnderstood(f"{place}: no use for {' '.join(sorted(values))}")
        block.start = {axis: None if v is None else float(v) for axis, v in begin.items()}
        block.end = {axis: None if v is None else float(v) for axis, v in self.position.items()}
        block.feed = None if self.feed is None else float(self.feed)
        if block.kind in ("feed", "arc") and self.feed_mode == "G93" and self.feed is None:
            raise NotUnderstood(f"{place}: G93 needs F in every block")
        return block

    def _check(self, codes, place):
        known = set().union(*GROUPS) - (ONLY_FANUC if self.dialect == "linuxcnc" else ONLY_LINUXCNC)
        for code in codes:
            if code not in known:
                raise NotUnderstood(f"{place}: {code} is not supported")
        for group in GROUPS:
            if sum(code in group for code in codes) > 1:
                raise NotUnderstood(f"{place}: {' '.join(codes)}: two codes of one group")

    def _modes(self, codes, values, extra, place):
        self.feed_mode_changed = False
        # another motion code on its line outlives it
        for code in sorted(codes, key=lambda code: code != "G80"):
            if code in ("G20", "G21"):
                self.unit = INCH if code == "G20" else Fraction(1)
            elif code in ("G7", "G8"):
                self.diameter = {"X"} if code == "G7" else set()
            elif code in PLANES:
                self.plane = code
            elif code in ("G90", "G91"):
                self.incremental = code == "G91"
            elif code in ("G90.1", "G91.1"):
                self.absolute_centre = code == "G90.1"
            elif code in ("G93", "G94", "G95"):
                self.feed_mode_changed = code != self.feed_mode
                self.feed_mode = code
            elif code in ("G54", "G55", "G56", "G57", "G58", "G59"):
                if code not in self.offsets:
                    raise NotUnderstood(f"{place}: the work offset {code} is not stated")
                self.offset = self.offsets[code]
            elif code in ("G0", "G1", "G2", "G3"):
                self.motion = code
            elif code == "G80":
                self.motion = None
            elif code == "G64" and self.dialect == "linuxcnc":
                values.pop("P", None)
                values.pop("Q", None)
            elif code == "G96" and self.dialect == "linuxcnc":
                values.pop("D", None)
            elif code == "G92" and (
                not any(c[0] == "S" for c in extra) or self._targets(dict(values), place)
            ):
                raise NotUnderstood(f"{place}: G92 is supported with S alone")

    def _dwell(self, values, place):
        letters = "P" if self.dialect == "linuxcnc" else "PXU"
        given = [letter for letter in letters if letter in values]
        if len(given) != 1:
            raise NotUnderstood(f"{place}: G4 needs one of {' '.join(letters)}")
        time = float(values.pop(given[0]))
        return time / 1000 if self.dialect == "fanuc-lathe" and given[0] == "P" else time

    def _length(self, axis, value):
        """A word of an axis, in mm of slide travel."""
        return value * self.unit / (2 if axis in self.diameter else 1)

    def _targets(self, values, place):
        """Take the axis words: {axis: ("at" or "by", mm)}."""
        targets = {}
        for axis in self.axes:
            if axis in values:
                targets[axis] = (
                    "by" if self.incremental else "at",
                    self._length(axis, values.pop(axis)),
                )
        if self.dialect == "fanuc-lathe":
            for letter, axis in INCREMENT_OF.items():
                if letter in values and axis in self.axes:
                    if axis in targets:
                        raise NotUnderstood(f"{place}: {axis} and {letter} in one block")
                    targets[axis] = ("by", self._length(axis, values.pop(letter)))
        return targets

    def _home(self, values, place):
        """G28, G30: the named axes go where the reference does not know."""
        targets = self._targets(values, place)
        if self.dialect == "fanuc-lathe":
            values.pop("P", None)
            if not targets:
                raise NotUnderstood(f"{place}: a return to reference names its axes")
        for axis in targets or self.axes:
            self.position[axis] = None

    def _move_in_machine(self, values, place):
        """G53: machine coordinates, for this block."""
        targets = self._targets(values, place)
        if not targets or any(how == "by" for how, _ in targets.values()):
            raise NotUnderstood(f"{place}: G53 needs absolute axis words")
        if self.dialect == "linuxcnc" and self.motion not in ("G0", "G1"):
            raise NotUnderstood(f"{place}: G53 needs G0 or G1")
        for axis, (_, value) in targets.items():
            self.position[axis] = value

    def _move(self, block, values, place):
        """Axis words by the motion mode."""
        targets = self._targets(values, place)
        arc = self.motion in ("G2", "G3")
        centre = {letter: values.pop(letter) for letter in "IJKR" if arc and letter in values}
        turns = values.pop("P", Fraction(1)) if arc and self.dialect == "linuxcnc" else Fraction(1)
        if not targets and not centre:
            return
        if self.motion is None:
            raise NotUnderstood(f"{place}: axis words without G0 G1 G2 G3")
        begin = dict(self.position)
        for axis, (how, value) in targets.items():
            if how == "at":
                self.position[axis] = self.offset.get(axis, 0) + value
            elif begin[axis] is not None:
                self.position[axis] = begin[axis] + value
        if not arc:
            block.kind = "rapid" if self.motion == "G0" else "feed"
            return
        block.kind, block.plane = "arc", self.plane
        first, second = PLANES[self.plane]
        if first not in self.axes or second not in self.axes:
            raise NotUnderstood(f"{place}: {self.plane} needs {first} and {second}")
        ends = (begin[first], begin[second], self.position[first], self.position[second])
        if None in ends:
            raise NotUnderstood(f"{place}: the arc begins at an unknown point")
        if turns.denominator != 1 or turns < 1:
            raise NotUnderstood(f"{place}: P counts whole turns")
        sign = 1 if self.motion == "G3" else -1
        if "R" in centre:
            if len(centre) > 1:
                raise NotUnderstood(
                    f"{place}: R and {' '.join(sorted(set(centre) - {'R'}))} in one block"
                )
            block.centre, sweep = arc_by_radius(ends, float(centre["R"] * self.unit), sign, place)
        else:
            block.centre, sweep = self._arc_by_centre(ends, centre, sign, place)
        block.sweep = sweep + sign * 2 * math.pi * (int(turns) - 1)

    def _arc_by_centre(self, ends, centre, sign, place):
        first, second = PLANES[self.plane]
        letters = CENTRE_LETTER[first], CENTRE_LETTER[second]
        if set(centre) - set(letters):
            raise NotUnderstood(f"{place}: {self.plane} takes {' '.join(letters)}")
        if not centre or (self.absolute_centre and len(centre) != 2):
            raise NotUnderstood(f"{place}: the arc has no centre")
        u0, v0, u1, v1 = ends
        if self.absolute_centre:
            u = self.offset.get(first, 0) + centre[letters[0]] * self.unit
            v = self.offset.get(second, 0) + centre[letters[1]] * self.unit
        else:
            u = u0 + centre.get(letters[0], 0) * self.unit
            v = v0 + centre.get(letters[1], 0) * self.unit
        r0, r1 = math.hypot(u0 - u, v0 - v), math.hypot(u1 - u, v1 - v)
        miss = abs(r0 - r1)
        if r0 == 0 or r1 == 0:
            raise NotUnderstood(f"{place}: the arc has no radius")
        if miss > SPIRAL_LIMIT or (miss > SPIRAL_FINE and miss > SPIRAL_PART * max(r0, r1)):
            raise NotUnderstood(f"{place}: the arc misses its end point by {miss:.6f} mm")
        if (u0, v0) == (u1, v1):
            return (float(u), float(v)), sign * 2 * math.pi
        turn = math.atan2(v1 - v, u1 - u) - math.atan2(v0 - v, u0 - u)
        turn = (sign * turn) % (2 * math.pi)
        # The same angle up to rounding is a whole turn: the points differ along the radius.
        if turn < 1e-12:
            turn += 2 * math.pi
        return (float(u), float(v)), sign * turn


def arc_by_radius(ends, radius, sign, place):
    """((u, v), sweep) of an arc with the R word: up to half a turn for R > 0, more for R < 0."""
    u0, v0, u1, v1 = (float(v) for v in ends)
    chord = math.hypot(u1 - u0, v1 - v0)
    if chord == 0 or radius == 0:
        raise NotUnderstood(f"{place}: an arc with R needs two points and a radius")
    half = chord / 2
    if half - abs(radius) > SHORT_RADIUS:
        raise NotUnderstood(f"{place}: R {radius} mm cannot reach an end {chord} mm away")
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    side = sign if radius > 0 else -sign  # left of the chord for the short way counterclockwise
    u = (u0 + u1) / 2 - side * height * (v1 - v0) / chord
    v = (v0 + v1) / 2 + side * height * (u1 - u0) / chord
    sweep = 2 * math.atan2(half, height)
    return (u, v), sign * (sweep if radius > 0 else 2 * math.pi - sweep)
