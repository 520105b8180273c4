"""POLY of Sinumerik: polynomials of every axis, written out as straight lines within the tolerance.

Siemens, SINUMERIK 840D/810D Programming Guide Advanced (04.00), "Polynomial interpolation, POLY",
pages 163 to 167, and Job Planning (03/2006), 5.5: PO[X]=(xe, a2, a3) is f(p) = a0 + a1 p + a2 p^2 +
a3 p^3 over p from 0 to PL, 1 where it is left out; a0 is where the axis stands, a1 follows from its
end xe; degrees up to 5. PO[]=(de, b2) is the common denominator, whose own a0 is 1: an axis is the
quotient then, and ends in xe all the same. Axes that are named plainly go evenly with p; without
any PO a block is straight. POLY ends with another motion code.

The lines leave the curve by the tolerance at most: poles of Bezier pieces say so (curve.py), if the
denominator's are above 0. Refused: G91, cutter radius compensation, G93, diameters, rotary words, a
plain axis beside a denominator, PO without POLY, corners (RND).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from postproc.nc.codes import code_number
from postproc.nc.comments import code_alone
from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.corners_siemens import Corners
from postproc.nc.cycles.curve import lines_of
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line

_VALUES = rb"\(([^()]*)\)|([-+]?[ \t]*[0-9.]+)"
PO = re.compile(
    rb"(?<![A-Za-z0-9_$])PO[ \t]*\[[ \t]*([A-Za-z]?)[ \t]*\][ \t]*=[ \t]*(?:" + _VALUES + rb")",
    re.IGNORECASE,
)
PL = re.compile(rb"(?<![A-Za-z0-9_$])PL[ \t]*=[ \t]*([-+]?[0-9.]+)", re.IGNORECASE)
WORD = re.compile(rb"(?<![A-Za-z0-9_$])POLY(?![A-Za-z0-9_])", re.IGNORECASE)
AXES, DEGREE = "XYZ", 5
DIAM90 = code_number("DIAM90")
DENOMINATOR = ""
WRITE = "let the CAM program write lines and arcs"


class Polynomials(Before):
    """Writes the blocks of POLY out; all other lines go on to `corners`."""

    codes = (code_number("POLY"),)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.corners, self.on = Corners(scene), False

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        if self.on or self.corners.wants(line):
            return True
        text = line.text
        return b"PO" in text.upper() and bool(WORD.search(text) or PO.search(text))

    def finish(self) -> list[Line]:
        return self.corners.finish()

    # Whole: the kinds of lines in their order of precedence.
    def take(self, line: Line) -> list[Line]:
        """Lines that can be followed. Raises ProgramError."""
        code, semicolon, remark = line.text.partition(b";")
        self.rigid = False
        # All other lines go through the corners, which hold some back until the next one is known.
        alone = code_alone(line.text, self.scene.dialect.grammar)
        if not self.on and not WORD.search(alone) and not PO.search(alone):
            self.rigid = True
            return self.corners.take(line)
        scene = self.scene
        if scene.passes(line.text):
            return [line]
        # An error points at the whole line until its words are known.
        scene.block = Block(line.text, (), True, False)
        if self.corners.held is not None or self.corners.modal:
            raise scene.fault("a polynomial beside corners (RND, CHF)", "write the corner out")
        found = {m[1].decode().upper(): m for m in PO.finditer(code)}
        length = PL.search(code)
        for match in [*found.values(), *filter(None, [length, WORD.search(code)])]:
            code = code.replace(match[0], b" " * len(match[0]), 1)
        begins = bool(WORD.search(line.text))
        code = re.sub(rb"[ \t]+", b" ", code.strip())
        block = Block.of(code + semicolon.replace(b";", b" ;") + remark, scene.dialect.grammar)
        scene.block = Block(line.text, block.words, True, block.skip)
        if scene.own_codes(block, "motion"):
            if begins or found:
                raise scene.fault(
                    "POLY or PO[ ] beside another motion code",
                    "write POLY alone, and no G0 or G1 with it",
                )
            self.on = False
            return [line]
        if found and not (self.on or begins):
            raise scene.fault(
                "PO[ ] without POLY",
                "the control goes straight to the end then: write POLY, or X Y Z",
            )
        self.on = True
        if not block.plain or (found and _more(block, len(code))):
            raise scene.fault(
                "a polynomial, and more than words and numbers", "write the numbers", None
            )
        if not found:
            return self._straight(line, block)
        values = {axis: self._values(match) for axis, match in found.items()}
        return self._curve(line, block, values, length)

    def _straight(self, line: Line, block: Block) -> list[Line]:
        """A block without polynomials: G1 where it names axes."""
        if not block.text.strip(b" \t\r/"):
            return []
        named = any(w.letter in self.scene.tracker.setup.axes for w in block.words)
        text = block.written(set(), b"G1", _behind_number(block)) if named else block.text
        return [line._replace(text=text)]

    def _values(self, match: re.Match[bytes]) -> list[float]:
        """The end and the coefficients behind it; what is left out is 0."""
        try:
            values = [
                float(x.strip() or b"0")
                for x in (match[2] if match[2] is not None else match[3]).split(b",")
            ]
        except ValueError:
            raise self.scene.fault(
                f"{match[0].decode('latin-1')} holds no numbers", "write numbers"
            ) from None
        if len(values) > DEGREE:
            raise self.scene.fault(f"a polynomial of degree {len(values)} (limit {DEGREE})", WRITE)
        return values

    def _curve(
        self,
        line: Line,
        block: Block,
        values: dict[str, list[float]],
        stated: re.Match[bytes] | None,
    ) -> list[Line]:
        scene, length = self.scene, float(stated[1]) if stated else 1.0
        self._check(block, values, length)
        plain = {w.letter: w.value or 0.0 for w in block.words if w.letter in AXES}
        axes = [x for x in AXES if x in values or x in plain]
        # One degree for all axes and the denominator, as poles of one Bezier piece need.
        count = max(len(v) for v in values.values()) + 1
        # No denominator is one of 1: the Bernstein ordinates of a constant are all 1.
        below = np.eye(1, count)[0]
        if DENOMINATOR in values:
            below = _coefficients(1.0, values[DENOMINATOR], 1.0, length, count)
        # The denominator at p = PL: an axis ends in xe, so its numerator ends in xe times this.
        end = float(below.sum())
        columns = [
            _coefficients(scene.at(x), values.get(x, [plain.get(x, 0.0)]), end, length, count)
            for x in axes
        ]
        # (K, D + 1), the coordinates times the weight and the weight: what curve.lines_of halves.
        # Above 0 the weights keep each piece within the hull of its poles.
        poles = np.column_stack([_bernstein(c) for c in [*columns, below]])
        if (poles[:, -1] <= 0).any():
            raise scene.fault("a denominator whose poles are not above 0", WRITE)
        points = lines_of(poles, scene.chord, len(axes))
        # The end as it is written, not as the sum of coefficients has it.
        points[-1] = [values[x][0] if x in values else plain[x] for x in axes]
        return self._lines(line, block, axes, points)

    def _lines(self, line: Line, block: Block, axes: list[str], points: np.ndarray) -> list[Line]:
        """The block with the words of the first line, and a block for each other line."""
        own = own_words(block, AXES)
        texts: list[bytes] = []
        for words in self._words(axes, points):
            if texts:
                texts.append((b"/" if block.skip else b"") + words)
            else:
                texts.append(block.written(own, words, _behind_number(block)))
        return [line._replace(text=text) for text in texts or [block.written(own)]]

    def _words(self, axes: list[str], points: np.ndarray) -> Iterator[bytes]:
        """A line to each of the points, where it moves an axis."""
        scene, here = self.scene, [self.scene.at(x) for x in axes]
        for to in points.tolist():
            moves = zip(axes, to, here, strict=True)
            # Only axes that move by a written digit: a block without a word would be G1 alone.
            words = [
                scene.text(x, v)
                for x, v, old in moves
                if scene.rounded(x, v) != scene.rounded(x, old)
            ]
            here = to
            if words:
                yield b" ".join([b"G1", *words])

    def _check(self, block: Block, values: dict[str, list[float]], length: float) -> None:
        scene = self.scene
        for mode, codes, what in (
            ("cutter", (410, 420), "cutter radius compensation on"),
            ("feed mode", (930,), "G93"),
        ):
            if scene.code_of(block, mode) in codes:
                raise scene.fault(f"{what} beside a polynomial", "end it before")
        if scene.code_of(block, "distance") == 910 or any(w.mode for w in block.words):
            raise scene.fault(
                "a polynomial in G91, or beside IC( )", "its ends are places here: write G90"
            )
        if length <= 0:
            raise scene.fault(f"PL={length:g} is no length of an interval", "write one above 0")
        self._check_axes(block, values)

    def _check_axes(self, block: Block, values: dict[str, list[float]]) -> None:
        scene, axes = self.scene, self.scene.tracker.setup.axes
        named = [*values, *(w.letter for w in block.words if w.letter in axes)]
        if other := next((x for x in named if x and x not in AXES), ""):
            raise scene.fault(
                f"the axis {other} in a polynomial", "only X Y Z are followed: " + WRITE
            )
        if any(map(scene.is_diameter, filter(None, values))) or scene.code("diameter") == DIAM90:
            raise scene.fault("a polynomial of a diameter", "write it in radii: DIAMOF")
        if DENOMINATOR in values and any(w.letter in AXES for w in block.words):
            raise scene.fault(
                "a plain axis beside a denominator polynomial", "write its end as PO[ ] too"
            )


def _coefficients(
    start: float, values: list[float], below: float, length: float, count: int
) -> np.ndarray:
    """(count,) coefficients over 0 to 1 of a numerator that begins at `start` and ends at the first
    value times the denominator's end, `below`."""
    # With u = p / PL a term a p^k is a PL^k u^k; at u = 1 all of them add up to the end, which
    # leaves a1, the one that a block does not state.
    found = np.zeros(count)
    found[0] = start
    for power, value in enumerate(values[1:], 2):
        found[power] = value * length**power
    found[1] = values[0] * below - found.sum()
    return found


def _bernstein(c: np.ndarray) -> np.ndarray:
    """(K,) Bezier ordinates over 0 to 1 of a polynomial with coefficients c (K,): u^i is the sum
    over j >= i of C(j, i) / C(n, i) times the Bernstein polynomial j of degree n (Farouki, The
    Bernstein polynomial basis, Computer Aided Geometric Design 29, 2012, 379)."""
    n = len(c) - 1
    return np.array(
        [sum(math.comb(j, i) / math.comb(n, i) * c[i] for i in range(j + 1)) for j in range(n + 1)]
    )


def _more(block: Block, stop: int) -> bool:
    """Whether anything but words stands before the comment, at `stop`: MSG("..")."""
    text = bytearray(block.text)
    for word in block.words:
        text[word.start : word.stop] = b" " * (word.stop - word.start)
    return bool(text[:stop].strip(b" \t\r/"))


def _behind_number(block: Block) -> int:
    """The place of the first word that is no block number."""
    return next((i for i, w in enumerate(block.words) if w.letter != "N"), len(block.words))
