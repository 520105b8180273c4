"""ROT, MIRROR, SCALE and their additive kin of Sinumerik, and polar words: AP= RP= about a pole of
G110 G111 G112.

Siemens, SINUMERIK NC Programming Manual, "Frame instructions" and "Travel commands with polar
coordinates". ROT, MIRROR, SCALE and TRANS replace the whole programmable frame; AROT, AMIRROR,
ASCALE and ATRANS go on in the coordinates that hold. TRANS stays in the text while nothing is
turned; within turned coordinates ATRANS becomes part of the map. An arc in polar words has its
centre in the pole ("Circular interpolation with polar coordinates").

Assumed: the settable frames (G54 ...) are shifts alone. Refused: turns about more than one axis in
one block, axes left unnamed in the first block behind a change, and a pole and polar words in a
plane whose X is a diameter (G18): whether RP and the pole's X are diameters then is in no manual
that was found.
"""

from __future__ import annotations

from postproc.nc.codes import code_number
from postproc.nc.cycles.affine import AXES, Affine, exact_turn, point, rotation, scaling
from postproc.nc.cycles.block import Block, number_of
from postproc.nc.cycles.frame_control import FrameControl
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, Scene

TURNS = {"X": ("Y", "Z"), "Y": ("Z", "X"), "Z": ("X", "Y")}  # about an axis: from one to the other
NAMES = ("TRANS", "ATRANS", "ROT", "AROT", "MIRROR", "AMIRROR", "SCALE", "ASCALE")
FRAMES = {code_number(name): name for name in NAMES}
SHIFTS = ("TRANS", "ATRANS")
FROM_HERE, POLE, FROM_POLE = 1100, 1110, 1120
POLES = (FROM_HERE, POLE, FROM_POLE)
SMALLEST = 1e-3
OWN_CENTRE = ("I", "J", "K", "CR", "AR")
CANCEL = "end it before: TRANS or ROT without words"


class SiemensFrames(FrameControl):
    """The programmable frame but for a shift that stays in the text, and the pole."""

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.codes = self.takers = (*FRAMES, *POLES)
        self.frames.why, self.frames.strict = "the programmed frame", True
        self.pole: dict[str, float] = {}
        self.polar: dict[str, float] = {}

    @property
    def active(self) -> bool:
        return self.frames.active or bool(self.polar)

    # Whole: the kinds of blocks in their order of precedence.
    def take(self, block: Block) -> list[bytes]:
        own = [c for c in block.codes if c in FRAMES]
        if own:
            return self._frame(block, FRAMES[own[-1]])
        pole = [c for c in block.codes if c in POLES]
        if pole:
            return self._set_pole(block, pole[-1])
        polar = [w for w in block.words if w.letter in ("AP", "RP")]
        if not polar and any(w.letter in self.scene.plane[:2] for w in block.words):
            self.polar = {}
        if not polar and not self.frames.active:
            return [block.text]
        self._check(block)
        if polar:
            block = self._right_angled(block)
        if any(c in self.scene.table and self.scene.table[c].number == 530 for c in block.codes):
            self.frames.forget()
            return [block.text]
        return self.frames.take(block)

    def _check(self, block: Block) -> None:
        """Codes that a frame can not hold together with."""
        if self.frames.map.identity:
            return
        named = [
            w.letter
            for w in block.words
            if w.letter in AXES and not self.frames.map.leaves(w.letter)
        ]
        for code in block.codes:
            row = self.scene.table.get(code)
            if row is None:
                continue
            if row.group == "units":
                raise self.scene.fault(f"{row.word} within {self.frames.why}", CANCEL)
            if row.refuses or ((row.takes or row.number == 530) and (named or row.takes)):
                raise self.scene.fault(
                    f"{row.word} ({row.meaning}) within {self.frames.why}", CANCEL
                )

    # -- the frame ---------------------------------------------------------------------------------

    def _frame(self, block: Block, name: str) -> list[bytes]:
        """A frame instruction: the text that stays of it."""
        scene, frames = self.scene, self.frames
        out = {i for i, w in enumerate(block.words) if w.letter != "N"}
        strange = next(
            (
                w
                for w in block.words
                if w.letter not in (*AXES, "RPL", "N") and number_of(w) not in FRAMES
            ),
            None,
        )
        if strange:
            raise scene.fault(
                f"{strange.letter} beside {name}",
                "Sinumerik wants a frame in a block of its own",
                strange,
            )
        #  TRANS, ATRANS, nothing turned    stay: the interpreter follows shifts, bytes are kept
        #  TRANS, something turned          stays and ends the map: it replaces the whole frame
        #  ATRANS, something turned         goes into the map: its way is turned too
        if name in SHIFTS and (frames.map.identity or name == "TRANS"):
            if not frames.map.identity:
                self._hold(Affine())
            frames.forget()
            return [block.text]
        part = self._part(block, name)
        if name.startswith("A"):
            self._hold(frames.map.after(part))
            rest = block.written(out)
            return [rest] if rest.strip(b" \t\r/") else []
        self._hold(part)  # what stands in the text of an older shift ends with it
        return [block.written(out, b"TRANS")]

    def _part(self, block: Block, name: str) -> Affine:
        """What the words of an instruction do."""
        scene = self.scene
        values = {w.letter: w.value or 0.0 for w in block.words if w.letter in (*AXES, "RPL")}
        kind = name.removeprefix("A")
        if "RPL" in values and kind != "ROT":
            raise scene.fault(f"RPL in {name}", "it is the angle of ROT and AROT")
        if kind == "TRANS":
            return Affine(shift=point(values))
        if kind == "MIRROR":
            return scaling(dict.fromkeys(values, -1.0))
        if kind == "SCALE":
            wrong = next(
                (x for x, v in values.items() if not SMALLEST <= abs(v) <= 1 / SMALLEST), None
            )
            if wrong:
                raise scene.fault(
                    f"{name} {wrong}{values[wrong]:g}",
                    f"factors are {SMALLEST:g} to {1 / SMALLEST:g}, in one step",
                )
            return scaling(values)
        if len(values) > 1:
            raise scene.fault(
                f"{name} about {len(values)} axes",
                "one at a time: how they follow each other is machine data",
            )
        if not values:
            return Affine()
        ((axis, degrees),) = values.items()
        first, second = scene.plane[:2] if axis == "RPL" else TURNS[axis]
        return rotation(first, second, degrees)

    def _hold(self, new: Affine) -> None:
        frames = self.frames
        # Mixed by the old or the new map: a block that names one of them moves both, from a place
        # that is not said; so the first one names all.
        mixed = {x for old in (frames.map, new) for x in AXES if len(old.partners(x)) > 1}
        frames.set_map(new)
        if not frames.map.can_be_undone:
            raise self.scene.fault("the frames together leave nothing of an axis", CANCEL)
        frames.loose |= mixed

    # -- polar words -------------------------------------------------------------------------------

    def _set_pole(self, block: Block, code: int) -> list[bytes]:
        """G110, G111, G112: no motion."""
        scene = self.scene
        names = scene.plane[:2]
        self._by_radius(names)
        given = {w.letter: w.value or 0.0 for w in block.words if w.letter in names}
        if any(w.letter in ("AP", "RP") for w in block.words):
            raise scene.fault("a pole in polar words", "write the pole with the axes of the plane")
        for axis in names:
            # G110 counts from where the tool stands, G111 from the zero point, G112 from the last
            # pole.
            base = (
                0.0
                if code == POLE
                else self.pole.get(axis, 0.0)
                if code == FROM_POLE
                else self._stands(axis)
            )
            self.pole[axis] = base + given.get(axis, 0.0)
        self.polar = {}
        out = own_words(block, names, (code,))
        rest = block.written(out)
        return [rest] if rest.strip(b" \t\r/") else []

    def _hold_polar(self, block: Block) -> None:
        """AP and RP of the block hold. Raises ProgramError where one of them is not known then."""
        scene = self.scene
        for word in block.words:
            if word.letter in ("AP", "RP") and word.value is not None:
                if word.mode == "IC" and word.letter not in self.polar:
                    raise scene.fault(
                        f"{word.letter}=IC without a value before",
                        "write it as a place first",
                        word,
                    )
                self.polar[word.letter] = word.value + (
                    self.polar[word.letter] if word.mode == "IC" else 0.0
                )
        missing = [x for x in ("AP", "RP") if x not in self.polar]
        if missing:
            raise scene.fault(
                f"polar words without {missing[0]}", "name RP and AP in the first block"
            )

    def _right_angled(self, block: Block) -> Block:
        """The block with X and Y (Z and X, Y and Z) in the place of AP and RP."""
        scene = self.scene
        first, second, _ = scene.plane
        self._by_radius((first, second))
        both = next((w for w in block.words if w.letter in (first, second)), None)
        if both:
            raise scene.fault(
                f"{both.letter} beside polar words",
                "the place in the plane is AP and RP alone",
                both,
            )
        self._hold_polar(block)
        # AP counts from the plane's first axis, counter-clockwise.
        cosine, sine = exact_turn(self.polar["AP"])
        at = {first: self.pole.get(first, 0.0) + self.polar["RP"] * cosine,
              second: self.pole.get(second, 0.0) + self.polar["RP"] * sine}  # fmt: skip
        scene.extra_decimals = 0 if self.frames.map.identity else 4
        texts: list[bytes] = []
        for axis, value in at.items():
            text = scene.text(axis, value)
            texts.append(axis.encode() + b"=AC(" + text[1:] + b")" if scene.incremental else text)
        texts += self._about_pole(block, (first, second))
        scene.extra_decimals = 0
        out = own_words(block, ("AP", "RP"))
        if self.frames.map.identity:
            self.frames.loose -= {first, second}
        return Block.of(block.written(out, b" ".join(texts)), scene.dialect.grammar)

    def _by_radius(self, names: tuple[str, ...]) -> None:
        """Raises ProgramError where one of these axes is a diameter."""
        scene = self.scene
        if any(map(scene.is_diameter, names)) or ("X" in names and scene.diameter_in_g90):
            raise scene.fault("a pole or polar words while X is a diameter", "write DIAMOF before")

    def _about_pole(self, block: Block, names: tuple[str, str]) -> list[bytes]:
        """The centre of an arc that has none of its own: the pole."""
        scene = self.scene
        if scene.code("motion") not in (CLOCKWISE, COUNTER) or any(
            w.letter in OWN_CENTRE for w in block.words
        ):
            return []
        return [
            scene.text(CENTRES[axis], self.pole.get(axis, 0.0) - self._stands(axis))
            for axis in names
        ]

    def _stands(self, axis: str) -> float:
        value = self.frames.known(axis)
        if value is None:
            value = self.scene.at(axis)
        return value
