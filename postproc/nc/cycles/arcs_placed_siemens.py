"""CIP and CT of Sinumerik: an arc through a point on its way, and one that goes on along the
tangent, both written with their centre.

Siemens, SINUMERIK 808D ADVANCED Programming and Operating Manual (Milling), 09/2017, "Circular
interpolation via intermediate point: CIP", page 98, and (Turning), 01/2017, page 91, with "Circle
with tangential transition: CT". CIP: the arc through where the axes stand, I1= J1= K1= and the end;
G90 and G91 hold for both points, distances count from the start, and the point says which way round
it goes. CT: the arc in the plane that touches the end of the segment before it (a line or an arc).
Both hold until another motion code.

Refused: points on one straight line, an arc that leaves the plane, diameters with CIP (whether I1=
is one), and CT behind anything that may have moved the axes or turned the coordinates since the
segment that it touches.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from postproc.nc.codes import code_number
from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.pole_arc import centre_of
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, PLANES, Scene
from postproc.nc.expand import Line

CIP, CT = code_number("CIP"), code_number("CT")
NAMES = {CIP: "CIP", CT: "CT"}
FOUND = re.compile(rb"(?<![A-Za-z0-9_$=\"])(?:CIP|CT)(?![A-Za-z0-9_=])", re.IGNORECASE)
WITHIN = {"X": "I1", "Y": "J1", "Z": "K1"}  # the words of the point on the way
STRANGE = ("I", "J", "K", "CR", "AR", "AP", "RP", "RPL", "TURN", "RND", "CHF", "CHR", "RNDM", "ANG")
IDLE = "NFSM"  # letters of blocks that a tangent outlasts
SWITCHES = (900, 910)  # codes in them
CHANGES_TOOL = 6
NEAR = 1e-9
# Both come from the same words, so that more than a rounding between them means that another block
# has moved the axes.
AGREES = 1e-6  # two places that are one, program's unit
WRITE = "write the arc with its end and its centre I J K"


class Touching(NamedTuple):
    """The end of a segment in the plane: where it is, as a complex number of the plane's two axes,
    and which way the tool went (of any length)."""

    plane: tuple[str, ...]
    place: complex
    way: complex


class PlacedArcs(Before):
    """Writes CIP and CT as G2 and G3."""

    codes = (CIP, CT)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.motion = 0  # CIP or CT, while it holds
        self.before: Touching | None = None
        self.watches: bool | None = None  # whether the text has one of the two

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here: all lines of a text that has such an arc."""
        # CT needs the segment before it, so all lines of a text with CT come through here, and no
        # others.
        if self.watches is None:
            self.watches = any(FOUND.search(text) for text in self.scene.lines())
        return self.watches or bool(FOUND.search(line.text))

    def written(self, block: Block) -> list[bytes]:
        """The block as it can be followed. Raises ProgramError."""
        self.watches = True
        if not block.plain:
            self.before = None
            return [block.text]
        own = self.scene.own_codes(block, "motion")
        if own:
            self.motion = own[-1] if own[-1] in NAMES else 0
        moves = any(w.letter in WITHIN or w.letter in WITHIN.values() for w in block.words)
        if not self.motion:
            self.before = self._touching(block, own) if moves else self._outlasting(block)
            return [block.text]
        plane = PLANES.get(self.scene.code_of(block, "plane"), PLANES[170])
        if not moves:  # the code alone, or nothing of ours
            self.before = self._outlasting(block)
            return [self._without_code(block)]
        return [self._arc(block, plane)]

    # -- the segment before ------------------------------------------------------------------------

    def _outlasting(self, block: Block) -> Touching | None:
        # A line of F, S, M or G90 between two segments moves nothing, so the tangent still holds;
        # M6 is left out, since a tool change may send the axes away.
        idle = all(w.letter in IDLE or w.letter in ("G", *NAMES.values()) for w in block.words)
        known = all(c in SWITCHES or c in NAMES for c in block.codes)
        return self.before if idle and known and CHANGES_TOOL not in block.m_codes() else None

    # Whole: half of it are the cases that are not known.
    def _touching(self, block: Block, own: list[int]) -> Touching | None:
        """The end of a line or an arc; None where it is not known."""
        scene = self.scene
        plane = PLANES.get(self.scene.code_of(block, "plane"), PLANES[170])[:2]
        code = own[-1] if own else scene.code("motion")
        here = [scene.known(x) for x in plane]
        if code not in (0, 10, CLOCKWISE, COUNTER) or None in here or scene.diameter_in_g90:
            return None
        # All but I J K and CR=, which are an arc's own: words of a shape that is not read here.
        if any(w.letter in STRANGE[4:] for w in block.words) or any(
            scene.group_of(c) not in ("motion", "plane", "distance") for c in block.codes
        ):
            return None
        start = complex(
            *(v / scene.double(x) for v, x in zip(here, plane, strict=True) if v is not None)
        )
        end = self._point(block, plane, plane, start)
        if code in (0, 10):
            way = end - start
        else:
            middle = self._middle(block, plane, start, end, code == COUNTER)
            if middle is None:
                return None
            # The tangent at the end is the radius there, turned by a quarter in the sense of the
            # motion.
            way = (end - middle) * (1j if code == COUNTER else -1j)
        return Touching(plane, end, way) if abs(way) > NEAR else None

    def _middle(
        self, block: Block, plane: tuple[str, ...], start: complex, end: complex, counter: bool
    ) -> complex | None:
        """The centre of an arc by I J K or CR=."""
        radius = block.get("CR")
        if radius is not None:
            chord = abs(end - start)
            if chord < NEAR or radius * radius < chord**2 / 4:
                return None
            points = (start.real, start.imag), (end.real, end.imag)
            return complex(*centre_of(*points, radius, 1 if counter else -1))
        own = [block.word(CENTRES[x]) for x in plane]
        if not any(own):
            return None
        at = [start.real, start.imag]
        for k, (word, axis) in enumerate(zip(own, plane, strict=True)):
            if word is not None:
                value = word.value or 0.0
                at[k] = value / self.scene.double(axis) if word.mode == "AC" else at[k] + value
        return complex(*at)

    # -- the arc -----------------------------------------------------------------------------------

    def _arc(self, block: Block, plane: tuple[str, str, str]) -> bytes:
        scene, name = self.scene, NAMES[self.motion]
        strange = next((w for w in block.words if w.letter in STRANGE), None)
        if strange is not None:
            raise scene.fault(f"{strange.letter} beside {name}", WRITE, strange)
        if scene.diameter_in_g90 or (
            self.motion == CIP and any(scene.is_diameter(x) for x in plane[:2])
        ):
            raise scene.fault(f"{name} while X is a diameter", "write DIAMOF before it, or G2, G3")
        start = complex(*(scene.at(x) / scene.double(x) for x in plane[:2]))
        end = self._point(block, plane[:2], plane[:2], start)
        self._in_plane(block, plane, name)
        if self.motion == CIP:
            inner = self._point(block, [WITHIN[x] for x in plane[:2]], plane[:2], start)
            middle, counter = self._through(start, inner, end)
        else:
            middle, counter = self._tangential(plane[:2], start, end)
        self.before = Touching(plane[:2], end, (end - middle) * (1j if counter else -1j))
        return self._centred(block, plane[:2], middle - start, counter)

    def _in_plane(self, block: Block, plane: tuple[str, str, str], name: str) -> None:
        """Raises ProgramError where an end or a point lies beside the plane."""
        scene, across = self.scene, plane[2]
        for letter in (across, WITHIN[across]):
            word = block.word(letter)
            if word is None:
                continue
            by = self._by(block, word)
            if abs(word.value or 0.0) > NEAR if by else scene.differs(across, word.value or 0.0):
                raise scene.fault(
                    f"{name} with {letter}, an arc that leaves the plane", WRITE, word
                )
        if self.motion == CIP and any(block.word(WITHIN[x]) is None for x in plane[:2]):
            first, second = (WITHIN[x] for x in plane[:2])
            raise scene.fault(f"CIP without both of {first}= and {second}=", WRITE)

    def _through(self, start: complex, inner: complex, end: complex) -> tuple[complex, bool]:
        """Centre and sense of the arc through three points."""
        a, b = inner - start, end - start
        turn = (a.conjugate() * b).imag
        if abs(turn) < NEAR * max(abs(a), abs(b), NEAR) ** 2:
            raise self.scene.fault(
                "CIP through points on one straight line, or twice through one", "write G1"
            )
        #         . i .          From the start, a leads to the point on the way, b to the end. The
        #    a .'   .   `.       centre m is as far from all three: m.a = |a|^2 / 2, m.b = |b|^2 /
        #     /     m     \      2; both together: m = i (|a|^2 b - |b|^2 a) / (-2 a x b). `turn` =
        #  start ---b---> end    a x b is above 0 where the way turns to the left.
        middle = start + 1j * (abs(a) ** 2 * b - abs(b) ** 2 * a) / (-2 * turn)
        return middle, turn > 0

    def _tangential(
        self, plane: tuple[str, ...], start: complex, end: complex
    ) -> tuple[complex, bool]:
        """Centre and sense of the arc that touches the segment before."""
        scene, before = self.scene, self.before
        if before is None or before.plane != plane or abs(before.place - start) > AGREES:
            raise scene.fault(
                "CT, and the segment before it is not known, or lies in another plane",
                WRITE + ", or CT right behind the line or arc in the plane that it touches",
            )
        #   end .--- .      The segment before ends at the start, pointing right. The centre lies on
        #      /      `     the normal, r to the left, and as far from the end: |chord|^2 = 2 r
        #     |    +   |    (normal . chord). r below 0: it lies to the right, and the arc runs
        #      `.  | r/     clockwise.
        #  --->  start
        normal = 1j * before.way / abs(before.way)  # to the left
        chord = end - start
        across = (normal.conjugate() * chord).real
        if abs(across) < NEAR * max(abs(chord), 1.0):
            raise scene.fault("CT to a place straight ahead or behind", "write G1")
        radius = abs(chord) ** 2 / (2 * across)
        return start + normal * radius, radius > 0

    def _centred(
        self, block: Block, plane: tuple[str, ...], middle: complex, counter: bool
    ) -> bytes:
        scene = self.scene
        out = own_words(block, (*WITHIN.values(), *NAMES.values()))
        words = [b"G3" if counter else b"G2"]
        words += [
            scene.text(CENTRES[x], v)
            for x, v in zip(plane, (middle.real, middle.imag), strict=True)
        ]
        # Before the first word but N: the code must not stand behind words that it rules.
        first = next((i for i, w in enumerate(block.words) if w.letter != "N"), 0)
        return block.written(out, b" ".join(words), min([*out, first]))

    def _without_code(self, block: Block) -> bytes:
        out = own_words(block, NAMES.values())
        return block.written(out) if out else block.text

    # -- words -------------------------------------------------------------------------------------

    def _by(self, block: Block, word: Word) -> bool:
        """Whether a word is a distance."""
        return word.mode == "IC" or (
            self.scene.code_of(block, "distance") == 910 and word.mode != "AC"
        )

    def _point(
        self,
        block: Block,
        letters: tuple[str, ...] | list[str],
        axes: tuple[str, ...],
        start: complex,
    ) -> complex:
        """A point of the plane by its words; a missing one leaves its axis."""
        by = self.scene.code_of(block, "distance") == 910
        return complex(
            *(
                self.scene.goes(block.word(letter), axis, here, by)
                for letter, axis, here in zip(letters, axes, (start.real, start.imag), strict=True)
            )
        )
