"""Where the program stands, for those who must know while it is written out: variables that hold
positions, and cycles.

Plain lines are only collected until somebody asks; then the one interpreter runs over them as a
batch.
"""

from __future__ import annotations

from collections.abc import Callable

from postproc.errors import BlockFault
from postproc.motions import Motions
from postproc.nc.batch import DIAM90
from postproc.nc.expand import Line
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import Words, lex
from postproc.nc.state import NONE, ModalState
from postproc.units import TICKS_PER_INCH, TICKS_PER_MM

NOTHING_AHEAD: tuple[bytes | None, ModalState | None, Words | None] = (None, None, None)
LIMITS = (50, 92)  # G codes beside which S is the highest speed of the spindle


class Tracker:
    """Follows plain lines. Everything asked for is as it stands behind the last line taken."""

    def __init__(self, interpreter: Interpreter):
        self.interpreter = interpreter
        self.setup, self.dialect = interpreter.setup, interpreter.dialect
        self._state = interpreter.initial()
        self._next = NOTHING_AHEAD
        self._speed: float | None = None
        # a block with numbers in place of its expressions, as they are now; None: it is more
        self.rendered: Callable[[bytes], bytes | None] = lambda raw: None
        # the plain lines of a subroutine that a cycle calls for its shape, whose motions begin
        # behind the block given and move nothing; None: nobody runs it
        self.shape: Callable[[int, bytes], list[bytes] | None] = lambda number, begin: None
        # the text of a subprogram, up to its M99; None: there is none
        self.program: Callable[[int], list[bytes] | None] = lambda number: None
        # a first block, so that the zero in force is known from the start
        self._waiting: list[bytes] = [b""]
        self._origins: list[Line | None] = [None]  # of those waiting
        self.unread: Line | None = None  # the line of the last BlockFault

    @property
    def counts(self) -> bool:
        """Whether a length without a decimal point counts least increments."""
        return (self.setup.integers or self.dialect.integers) == "least increments"

    def take(self, line: bytes, origin: Line | None = None) -> None:
        """A plain line (without its end) that the control executes now, and what an error in it is
        told at. A "%" line is no block."""
        if not line.lstrip().startswith(b"%"):
            self._waiting.append(line)
            self._origins.append(origin)

    def beside(self) -> Tracker:
        """Another one, which goes on from here by itself."""
        other = Tracker(self.interpreter)
        other._state, other._waiting, other._origins = self.state, [], []
        other._speed = self._speed
        return other

    @property
    def state(self) -> ModalState:
        """The modal state behind the last line taken. Raises BlockFault for one that is no plain
        block."""
        # `ahead` has run this very line: its state is taken over, not worked out again
        line, behind, seen = self._next  # looked at ahead
        if behind is not None and seen is not None and self._waiting == [line]:
            self._hear(seen)
            self._state, self._next = behind, NOTHING_AHEAD
            self._waiting, self._origins = [], []
        elif self._waiting:
            text, origins = b"\n".join(self._waiting) + b"\n", self._origins
            self._waiting, self._origins = [], []
            words = lex(text, self.dialect.grammar, self.setup.block_delete)
            self._next = NOTHING_AHEAD
            self._hear(words)
            try:
                self._state = self.interpreter.run(words, self._state)[1]
                if words.fault and not self._state.ended:
                    raise words.fault
            except BlockFault as error:
                # a line that could not be cut into words has no block: its number is that of its
                # text
                read = error.block < len(words.line)
                row = words.line[error.block] if read else words.text.count(b"\n", 0, error.start)
                self.unread = origins[int(row)]
                raise
        return self._state

    def motion_code(self) -> list[bytes]:
        """The motion code in force as it is written, none for G0 and before any is named."""
        held = self.code("motion")
        code = self.dialect.by_number.get(held) if held > 0 else None
        return [code.word.encode()] if code else []

    def ahead(self, line: bytes) -> tuple[Motions, ModalState] | None:
        """What one more plain line would be to the filter, and the state behind it; None: it would
        be refused. The line is not taken."""
        state = self.state
        words = lex(line + b"\n", self.dialect.grammar, self.setup.block_delete)
        try:
            motions, state, _ = self.interpreter.run(words, state)
        except BlockFault:
            return None
        if words.fault:
            return None
        self._next = line, state, words
        return motions, state

    @property
    def speed(self) -> float | None:
        """The last S of the program, None: none yet; nan: it is the spindle's highest speed."""
        _ = self.state  # hears all lines that wait
        return self._speed

    def _hear(self, words: Words) -> None:
        """Keep the last S of blocks that the control executes."""
        place = (words.letter == ord("S")).nonzero()[0]
        if not len(place):
            return
        last = place[-1]
        codes = words.mantissa[
            (words.block == words.block[last]) & (words.letter == ord("G")) & (words.decimals == 0)
        ]
        number = float(words.mantissa[last] / 10.0 ** words.decimals[last])
        self._speed = float("nan") if set(codes.tolist()) & set(LIMITS) else number

    def code(self, group: str) -> int:
        """Ten times the G number in force in a modal group ("motion", "plane", "distance", ...),
        -1: none yet."""
        return int(self.state.codes.get(group, -1))

    @property
    def inch(self) -> bool:
        return self.code("units") == 200

    def is_diameter(self, axis: str, distance: bool | None = None) -> bool:
        """Whether words of this axis are diameters now; distance: those that are one, by G91 unless
        given (DIAM90)."""
        mode = self.code("diameter") if axis == "X" else NONE
        if mode == DIAM90:
            return not (self.code("distance") == 910 if distance is None else distance)
        return mode == 70 if mode in (70, 80) else axis in self.setup.diameter

    def work(self, axis: str) -> float | None:
        """The programmed coordinate (program's unit, diameter where such) at which the axis stands,
        None: not known."""
        state, row = self.state, self.setup.axes.index(axis)
        if not state.known[row] or state.origin is None or not state.zero_known:
            return None
        # ticks of one of the program's own units: half as many where its words are diameters
        unit = (TICKS_PER_INCH if self.inch and axis in "XYZUVW" else TICKS_PER_MM) / (
            2 if self.is_diameter(axis, distance=False) else 1
        )
        return float((state.position[row] - state.origin[row]) / unit)

    def machine(self, axis: str) -> float | None:
        """mm (degrees), slide position, radius; None: not known."""
        state, row = self.state, self.setup.axes.index(axis)
        return float(state.position[row] / TICKS_PER_MM) if state.known[row] else None

    def offset(self, name: str, axis: str, missing: float | None = 0.0) -> float | None:
        """mm: a work or tool offset ("G54", "T0101", "H1") as stated or as set by the program,
        None: not stated, or set to what is not known. missing: where it is stated without the
        axis."""
        own = self.state.offsets.get(name)
        place = self.setup.offsets.get(name) if own is None else own or None
        return None if place is None else place.get(axis, missing)

    def decimals(self, letter: str) -> int:
        """How many decimals a number behind this letter is written with: a least increment for an
        axis, more elsewhere."""
        if letter in "XYZABCUVWIJKRE":
            least = min(self.setup.least_increment.values(), default=1e-4)
            return (
                len(f"{least:.9f}".rstrip("0").split(".")[1])
                + self.dialect.expand_decimals
                + self.inch
            )
        return 6


def number(value: float, decimals: int) -> str:
    """A number as controls read it: no exponent, always a point, no zeros behind that say nothing,
    never minus zero."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0") if "." in text else text + "."
    return text[1:] if text in ("-0.", "-0") else text
