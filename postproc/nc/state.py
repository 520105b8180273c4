"""What the text layer is told of the machine, and what one batch of blocks hands to the next."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np

from postproc.nc.shifted import Shifted
from postproc.records import columns, mutable, record
from postproc.spaces import Kinematics, Space
from postproc.units import TICKS_PER_MM

NONE = -1  # no code of that group yet
UNSAID = np.iinfo(np.int64).min  # ticks: an axis that no block has named yet


@record
class Setup:
    """What the text must be told of the machine: its axes, which words are diameters, least
    increments (mm), work and tool offsets (mm by axis, by name "G54", "T0101"), where it stands at
    the start and after homing (mm, machine coordinates), and how block delete and arc centres are
    read (None: as the dialect does), and what a coordinate without a decimal point counts ("": as
    in the dialect). scaling: which axes cycle 11 of Heidenhain scales, "plane", "space", "" not
    said.
    tool: the one in the spindle at the start, 0: none, -1: not said.
    kinematics: of a machine with rotary axes, whose tool tip can be followed."""

    axes: tuple[str, ...]
    diameter: frozenset[str] = frozenset()
    least_increment: dict[str, float] = field(default_factory=dict)
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)
    start: dict[str, float] = field(default_factory=dict)
    block_delete: bool = False
    arc_centre: str = "incremental"
    integers: str = ""
    scaling: str = ""
    tool: int = -1
    kinematics: Kinematics | None = None
    home: dict[str, float] = field(default_factory=dict)


@columns
class Frame:
    """Shifts of the coordinates that a program has set beside its work offset; ticks (A,) each,
    radius.

    local: G52; preset: G92, in force while preset_on; length: the tool's, G43; trans: TRANS of
    Siemens, added: whether parts of it were (ATRANS); zeros: where each axis was named last, the
    sum of its work offset (or what SUPA made of it), trans and length, UNSAID: nowhere yet: the
    next increment travels what has changed of it. extended: the name of the work offset that G54.1
    P has chosen. length_units: ten times the code of the units in which the length was set.
    unknown: message and advice, by part, for a shift that is in force and not known. lapsed: axes
    whose length G28 has taken back. tip: the tool point's frame, plane: a tilted plane's, face:
    that of polar interpolation, where they are in force."""

    local: np.ndarray
    preset: np.ndarray
    length: np.ndarray
    trans: np.ndarray
    zeros: np.ndarray
    preset_on: bool = True
    extended: str = ""
    length_units: int = 210
    unknown: dict[str, tuple[str, str]] = field(default_factory=dict)
    lapsed: tuple[str, ...] = ()
    tip: Space | None = None
    plane: Space | None = None
    face: Space | None = None
    added: bool = False

    @cached_property
    def space(self) -> Space | None:
        """The frame in which X Y Z are places of the tool tip; None: they are the slides'."""
        # the only one in force: polar interpolation within another one is refused (face.py)
        if self.face is not None:
            return self.face
        if self.tip is not None and self.plane is not None:
            return self.tip.of(self.plane)
        return self.tip if self.plane is None else self.plane

    @cached_property
    def shift(self) -> np.ndarray:
        """(A,) ticks: their sum. Words that are places of the tool tip know no length."""
        #   machine zero                                                  where the slide stands
        #        |--- work offset ---|- G52, TRANS -|- G43 -|- G92 -|--- coordinate --->|
        #   So position = work + shift + coordinate; what a G92 or a G10 L20 sets follows from the
        #   coordinate that it names, solved for its own part.
        total: np.ndarray = self.local + self.trans
        total = total + self.length if self.space is None else total
        return total + self.preset if self.preset_on else total


def no_frame(axes: int) -> Frame:
    """No shift at all."""
    zero = np.zeros(axes, np.int64)
    return Frame(zero, zero, zero, zero, np.full(axes, UNSAID))


@record
class Cycle:
    """What a canned cycle keeps from block to block: the axis that drills, where R and the bottom
    lie on it (ticks, machine coordinates, None: never said), the initial level, whether that is
    known, the letter whose 0 has stored words for the next hole, whether its first hole was in G90
    (None: there was none), and whether R was named where the tool stood at another level."""

    letter: str
    level: int | None = None
    bottom: int | None = None
    initial: int = 0
    known: bool = False
    stored: str = ""
    absolute: bool | None = None
    away: bool = False


@record
class Beside:
    """Cutter radius compensation. on: whether the last motion was inside it; side: +1 left, -1
    right; radius: mm, + where the centre lies left of the path, nan: not stated; nose: mm along the
    plane's axes from the centre of a lathe tool's nose to the point that is driven; offset: the D
    number in force, -1: none; shifted: follows the centre where it is known (never changed in
    place); fault: what the control has refused already. Where D names an edge of a tool: tool, that
    tool; by_m6: whether M6 has brought one, so that T alone names the next; waits: the edge of that
    next one."""

    on: bool = False
    side: int = 1
    radius: float = float("nan")
    nose: tuple[float, float] = (0.0, 0.0)
    offset: int = NONE
    shifted: Shifted | None = None
    fault: str = ""
    tool: int = NONE
    by_m6: bool = False
    waits: int = NONE


@columns
class ModalState:
    """All that one batch hands to the next: a code per modal group, position (A,) ticks and whether
    it is known, the tool offset and F in force, whether the program has ended, and whether a motion
    code was named since the last motion. origin (A,): ticks, where the zero of absolute words lies
    behind the batch, and zero_known: whether it does; offsets: work and tool offsets that the
    program itself has set, mm, beside those of the Setup. frame: other shifts in force; sent (A,):
    axes that G28 has taken elsewhere since the last motion; changed (A,): axes that a tool change
    has taken away and no block has named since; cycle: the canned cycle in force;
    beside: how the tool stands beside the contour; tool_number: the tool in the spindle, which G43
    without H means, and next_tool the last T; -1: none named. loose: axes that an engraving left
    beside its text, by an unknown way."""

    codes: dict[str, int]
    position: np.ndarray
    known: np.ndarray
    tool: str = ""
    feed: float = float("nan")
    ended: bool = False
    renamed: bool = False
    origin: np.ndarray | None = None
    zero_known: bool = True
    frame: Frame | None = None
    sent: np.ndarray | None = None
    changed: np.ndarray | None = None
    cycle: Cycle | None = None
    beside: Beside = Beside()
    tool_number: int = -1
    next_tool: int = -1
    loose: tuple[str, ...] = ()
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)

    @cached_property
    def modes(self) -> tuple[object, ...]:
        """All but the position and F, to be compared with that of other states."""
        columns = (self.known, self.origin, self.sent, self.changed)
        return (
            tuple(self.codes), tuple(self.codes.values()), self.tool, self.ended, self.renamed,
            self.zero_known, self.frame, self.cycle, self.beside, self.tool_number, self.next_tool,
            self.loose, repr(self.offsets) if self.offsets else "",
            *(None if column is None else column.tobytes() for column in columns),
        )  # fmt: skip

    def at(self, position: np.ndarray, feed: float) -> ModalState:
        """The same modes at another position (A,), ticks, and another F."""
        # past the checks of a new record, for each line of a stream; `modes` is what it was, and
        # costs most of all to work out
        state = object.__new__(ModalState)
        state.__dict__.update(self.__dict__, modes=self.modes, position=position, feed=feed)
        return state


def ticks_of(setup: Setup, place: dict[str, float]) -> np.ndarray:
    """(A,) ticks of mm by axis."""
    return np.array([round(place.get(x, 0.0) * TICKS_PER_MM) for x in setup.axes], np.int64)


@mutable
class InCycle:
    """The blocks of a segment that a cycle holds: `blocks` (k,) those with a hole, `mask` (B,) all
    of them, and per hole (k,) the ticks where the axis ends up, the bottom, R, the zero of the
    bottom's word, that word, whether the axis goes back to the initial level, and `higher`, `flush`
    and `level_word` of Holes, `away` of Cycle. begins: whether the cycle does."""

    letter: str
    row: int
    mask: np.ndarray
    blocks: np.ndarray
    target: np.ndarray
    bottom: np.ndarray
    level: np.ndarray
    zero: np.ndarray
    word: np.ndarray
    initial: np.ndarray
    code: np.ndarray
    known: bool
    after: Cycle | None
    begins: bool = True
    away: bool = False
    higher: np.ndarray | None = None
    flush: np.ndarray | None = None
    level_word: np.ndarray | None = None
