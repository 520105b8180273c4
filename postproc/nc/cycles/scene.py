"""Where a cycle or a frame finds the program: modes and positions, asked of the tracker only where
they are not known here."""

from __future__ import annotations

from collections.abc import Callable

from postproc.errors import Notice, ProgramError
from postproc.motions import Motions
from postproc.nc.batch import DIAM90
from postproc.nc.codes import Code, code_number
from postproc.nc.cycles.block import Block, Word
from postproc.nc.expand.tracker import Tracker, number
from postproc.nc.state import ModalState
from postproc.units import TICKS_PER_INCH, TICKS_PER_MM

# message, advice, and what to point at in the line
Fault = Callable[[str, str, bytes], ProgramError]
CLOCKWISE, COUNTER = 20, 30
# first and second axis, and the one across
PLANES = {170: ("X", "Y", "Z"), 180: ("Z", "X", "Y"), 190: ("Y", "Z", "X")}
LINEAR = "XYZUVW"
CENTRES = {"X": "I", "Y": "J", "Z": "K"}
# how far lines may leave a curve where it is not stated: a least increment of most controls
CHORD_MM = 0.001


class Scene:
    """The program behind the last line taken, in the coordinates in which its words are written.

    `frame` maps a coordinate as the output has it to one as the program writes it, while a frame is
    at work.
    """

    def __init__(self, tracker: Tracker):
        self.tracker, self.dialect = tracker, tracker.dialect
        self.table: dict[int, Code] = {code_number(code.word): code for code in self.dialect.codes}
        self.spindle = 0  # M3 or M4, as last named; 5 or 0: it stands
        self.extra_decimals = 0
        self.turned = False  # a frame that is written out turns, scales or mirrors the block
        self.tolerance = CHORD_MM
        self.frame: Callable[[str], float | None] | None = None
        self.block = Block(b"", (), True, False)
        self.source = 0  # the line that the block stands in
        self.lines: Callable[[], list[bytes]] = list  # the text that the block stands in
        self.fault_at: Fault
        self.notices: list[Notice] = []  # what the user should know of what was written
        # whether the block's hole may stay a cycle
        self.keeps: Callable[[Motions], bool] | None = None
        self.unsure: set[str] = (
            set()
        )  # axes whose zero was moved by an unknown amount, and that no block has named since
        self._codes: dict[str, int] = {}
        self._places: dict[str, float] = {}
        self._decimals: dict[str, int] = {}

    def passes(self, text: bytes) -> bool:
        """Whether the control steps over this line: it begins with / and block delete is on."""
        return bool(self.tracker.setup.block_delete) and text.lstrip(b" \t").startswith(b"/")

    # -- modes -------------------------------------------------------------------------------------

    def group_of(self, code: int) -> str:
        """The modal group of a code as it is written ("" for none and for unknown codes)."""
        return self.table[code].group if code in self.table else ""

    def own_codes(self, block: Block, group: str) -> list[int]:
        """The codes of a modal group that a block names."""
        return [c for c in block.codes if self.group_of(c) == group]

    def code_of(self, block: Block, group: str) -> int:
        """The code of a group that holds in a block: its own, else the one in force."""
        own = self.own_codes(block, group)
        return own[-1] if own else self.code(group)

    def code(self, group: str) -> int:
        """Ten times the G number in force in a modal group, the block's own codes counted in; -1:
        none."""
        if group not in self._codes:
            self._codes[group] = self.tracker.code(group)
        return self._codes[group]

    def note(self, block: Block) -> None:
        """Let the modal codes of a block hold."""
        for code in block.codes:
            if code in self.table and self.table[code].group:
                self._codes[self.table[code].group] = self.table[code].number
        if self.dialect.one_code_per_group is False and 800 in block.codes:
            self._codes["cycle"] = 800

    def lose_code(self, group: str) -> None:
        """The code in force in a group is not the one that was noted."""
        self._codes.pop(group, None)

    @property
    def incremental(self) -> bool:
        return self.code("distance") == 910

    @property
    def compensated(self) -> bool:
        """Whether cutter radius compensation is on."""
        return self.code("cutter") in (410, 411, 420, 421)

    @property
    def inch(self) -> bool:
        return self.code("units") == 200

    @property
    def plane(self) -> tuple[str, str, str]:
        """First and second axis of the plane, and the axis across it."""
        return PLANES.get(self.code("plane"), PLANES[170])

    def increment(self, axis: str) -> str:
        """The letter of an axis' distances (U of X), "": none."""
        return next((u for u, x in self.dialect.increments.items() if x == axis), "")

    def is_diameter(self, axis: str) -> bool:
        """Whether words of this axis that are places are diameters."""
        mode = self.code("diameter") if axis == "X" else -1
        return mode != 80 if mode in (70, 80, DIAM90) else axis in self.tracker.setup.diameter

    @property
    def diameter_in_g90(self) -> bool:
        """Whether X is a diameter as a place and a radius as a distance: DIAM90."""
        return self.code("diameter") == DIAM90

    def double(self, axis: str) -> float:
        """By what the words of an axis are more than its way: 2 for diameters, else 1."""
        return 2.0 if self.is_diameter(axis) else 1.0

    @property
    def unit(self) -> float:
        """mm of the program's unit."""
        return 25.4 if self.inch else 1.0

    @property
    def chord(self) -> float:
        """How far straight lines may leave the curve that they stand for, program's unit."""
        return self.tolerance / self.unit

    # -- places ------------------------------------------------------------------------------------

    def known(self, axis: str) -> float | None:
        """The programmed coordinate at which an axis stands (program's unit, diameter where such),
        None: not known."""
        if axis not in self.tracker.setup.axes or axis in self.unsure:
            return None
        #   told by a cycle -> else the frame, back from beneath -> else the tracker, less its zeros
        if axis not in self._places:
            if self.tracker.state.origin is None:
                self.tracker.take(b"")  # before the first block the tracker does not know its zeros
            value = self.frame(axis) if self.frame else self.work(axis)
            if value is None:
                return None
            self._places[axis] = value
        return self._places[axis]

    def work(self, axis: str) -> float | None:
        """The coordinate beneath any frame, as the tracker has it; None: not known, or no axis of
        the machine."""
        axes, state = self.tracker.setup.axes, self.tracker.state
        if (
            axis not in axes
            or axis in self.unsure
            or state.origin is None
            or not state.known[axes.index(axis)]
        ):
            return None
        return self.coordinate(axis, int(state.position[axes.index(axis)]), state)

    def coordinate(self, axis: str, ticks: int, state: ModalState) -> float:
        """A machine coordinate as words have it beneath any frame, in a `state` whose zeros are
        known."""
        assert state.origin is not None
        unit = (TICKS_PER_INCH if self.inch and axis in "XYZUVW" else TICKS_PER_MM) / (
            2 if self.is_diameter(axis) else 1
        )
        # An offset that is not stated is in neither of the two, and a block has named the axis
        # behind it.
        return float((ticks - state.origin[self.tracker.setup.axes.index(axis)]) / unit)

    def shifted(self, named: set[str]) -> None:
        """A block has chosen a shift of the coordinates and named these axes in it."""
        state = self.tracker.state
        stated = {**self.tracker.setup.offsets, **self.tracker.state.offsets}
        work = self.table.get(state.codes.get("work offset", -1))
        unknown = bool(state.frame is not None and state.frame.unknown) or (
            work is not None and work.word not in stated
        )
        if self.dialect.tool_offsets and state.tool and state.tool not in stated:
            unknown = True
        if unknown:
            self.unsure = {"X", "Y", "Z"} & set(self.tracker.setup.axes)
            self.named(named)

    def named(self, axes: set[str]) -> None:
        """A motion has named these axes."""
        if self.unsure and not self.incremental:
            self.unsure -= axes

    def at(self, axis: str) -> float:
        """As `known`; raises ProgramError that asks for it."""
        value = self.known(axis)
        if value is None:
            if axis not in self.tracker.setup.axes:
                raise self.fault(f"the machine has no axis {axis}", "choose the right --machine")
            if self.tracker.machine(axis) is not None:
                raise self.fault(
                    f"the motions depend on where {axis} stands, and an offset in force is not"
                    " stated",
                    f"move {axis} to an absolute position behind the offset, or state it: --offset",
                )
            message = (
                f"the motions depend on where {axis} stands, and that is not known at this block"
            )
            lost = [x for x in self.tracker.setup.axes if x == axis or self._lost(x, axis)]
            if all(x in self.tracker.setup.start for x in lost):  # --start is no way out
                raise self.fault(
                    message,
                    f"move {axis} to an absolute position before: a tool change, homing or a macro"
                    " behind the start leads it nowhere known",
                )
            raise self.fault(
                message,
                f"move {axis} to an absolute position before, or say where {' and '.join(lost)}"
                f" {'stand' if lost[1:] else 'stands'}: --start {','.join(x + '0' for x in lost)}",
            )
        return value

    def _lost(self, axis: str, beside: str) -> bool:
        """Whether an axis in one plane with another stands at an unknown place."""
        return {axis, beside} <= set(self.plane[:2]) and self.tracker.machine(axis) is None

    def moved(self, axis: str, value: float) -> None:
        """An axis stands at this programmed coordinate now."""
        self._places[axis] = value

    def lose(self, axis: str) -> None:
        """An axis was moved, and nobody counted how far."""
        self._places.pop(axis, None)

    def differs(self, axis: str, value: float) -> bool:
        """Whether an axis stands elsewhere, as far as numbers are written, or at an unknown
        place."""
        here = self.known(axis)
        return here is None or self.rounded(axis, here) != self.rounded(axis, value)

    def settle(self) -> None:
        """A block went by whose codes have been noted: its modes hold on, and the axes may stand
        elsewhere."""
        self._places = {}

    def forget(self) -> None:
        """Something went by that was not looked at: ask the tracker next time."""
        self._codes, self._places, self._decimals = {}, {}, {}

    def goes(self, word: Word | None, axis: str, start: float, by: bool) -> float:
        """Where a word leads an axis from `start`, both as radii; by: whether it is a distance
        where it does not say so itself (IC, AC). No word leaves the axis."""
        if word is None:
            return start
        value = self.length(word, axis) / self.double(axis)
        return start + value if word.mode == "IC" or (by and word.mode != "AC") else value

    # -- numbers -----------------------------------------------------------------------------------

    def decimals(self, letter: str) -> int:
        """How many decimals a number behind this letter is written with."""
        if letter not in self._decimals:
            self._decimals[letter] = self.tracker.decimals(letter)
        return self._decimals[letter] + self.extra_decimals

    def rounded(self, letter: str, value: float) -> float:
        """As it would be written."""
        return round(value, self.decimals(letter))

    def text(self, letter: str, value: float) -> bytes:
        """A word: letter and number."""
        return f"{letter}{number(value, self.decimals(letter))}".encode()

    def length(self, word: Word, axis: str) -> float:
        """The length that a word of an axis (or of R, Q) says; without a point it may count least
        increments."""
        if self.tracker.counts and "." not in word.raw:
            return self.counted(word, axis)
        return word.value or 0.0

    def length_in(self, block: Block, letter: str, axis: str, missing: float = 0.0) -> float:
        """The length that a block's word of this letter says."""
        word = block.word(letter)
        return missing if word is None else self.length(word, axis)

    def counted(self, word: Word, axis: str = "Z") -> float:
        """A number that counts least increments where it has no point (P and Q of a lathe's
        cycles)."""
        value = word.value or 0.0
        if "." in word.raw:
            return value
        own = self.tracker.dialect.counts
        least = own or self.tracker.setup.least_increment.get(axis, 1e-3)
        # A control with 0.001 mm has 0.0001 inch; degrees are the same in both.
        return value * least / (10 if self.inch and axis in LINEAR else 1)

    def tool_radius(self, name: str, block: Block) -> float:
        """The radius that D of a block names, program's unit. Raises ProgramError."""
        radius = self.tracker.offset(f"D{block.get('D'):g}", "R", None)
        if radius is None:
            raise self.not_stated(name, block)
        return radius / self.unit

    def not_stated(self, name: str, block: Block) -> ProgramError:
        """The radius that D of a block names is not known."""
        number = block.get("D")
        return self.fault(
            f"the tool's radius D{number:g} of {name} is not stated",
            f"say it in mm: --offset D{number:g}=R5",
            block.word("D"),
        )

    def degrees(self, word: Word) -> float:
        """An angle in an axis' word; without a point it may count thousandths of a degree."""
        whole = self.tracker.counts and "." not in word.raw
        return (word.value or 0.0) * (1e-3 if whole else 1.0)

    def angle(self, word: Word) -> float:
        """Degrees of a word that is no axis'. Raises ProgramError where it has no point and lengths
        without one count least increments: of what size those of an angle are is a parameter
        (Fanuc 15i B-63324EN, "Coordinate system rotation": 0.001 or 0.00001 degrees, RTR)."""
        if self.tracker.counts and word.value and "." not in word.raw:
            raise self.fault(
                f"the angle {word.letter}{word.raw} has no decimal point",
                f"lengths without one count least increments here: write {word.letter}{word.raw}.",
                word if word in self.block.words else None,
            )
        return word.value or 0.0

    # -- notices and errors ------------------------------------------------------------------------

    def tell(self, code: str, said: str) -> None:
        """Leave a notice at the line at hand."""
        self.notices.append(Notice(code, said, self.source))

    def fault(self, message: str, advice: str, word: Word | None = None) -> ProgramError:
        """An error at the block at hand, or at one of its words."""
        return self.fault_at(
            message, advice, self.block.text[word.start : word.stop] if word else b""
        )
