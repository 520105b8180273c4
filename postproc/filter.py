"""The heart: program text in, corrected program text out. Files, pipes and wires all use it.

Text, motions and physics meet here and nowhere else. The filter opens nothing and keeps, between
two calls, only what a control keeps between two blocks: so any cut of the input gives the same
bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from functools import partial
from typing import TYPE_CHECKING

from postproc import __version__, intake, marks
from postproc.compensate import Compensator, Options, limits
from postproc.errors import BlockFault, MotionFault, Notice, Place, ProgramError
from postproc.machine.model import Machine
from postproc.machine.poses import Poses
from postproc.motions import Motions
from postproc.nc import checksums, faults
from postproc.nc.beside_corrected import Contours, follow_both
from postproc.nc.dialects import Dialect
from postproc.nc.emitter import Emitter
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import Words, lex
from postproc.nc.state import ModalState, Setup
from postproc.nc.writing import Written
from postproc.pieces import Pieces
from postproc.records import mutable, replace
from postproc.units import UM

if TYPE_CHECKING:
    from postproc.heat.follow import Heat, HeatState

# a batch, its output, the lines before it
Watcher = Callable[[Words, Motions, Pieces, bytes, int], None]
# bytes without a line end: no program, or one for which memory would not stay flat
MOST_ARCS = 5000
DEFAULTS = Options()
TOO_LONG = (
    f"a line of more than {intake.LINE:,} characters",
    "this is no NC program, or its line ends were lost",
)
DAMAGED = "the line came damaged, or was edited by hand: take N and * out of all lines"
IF_LEFT_OUT = "where the operator's switch leaves this block out, say so: --block-delete on"
OWN_OUTPUT = (
    "this program is gcomp's own output: it is corrected already",
    "give the nominal program; correcting twice doubles the correction",
)


def _portions(text: bytes) -> Iterator[bytes]:
    """Whole lines, all at once or, where there are many arcs, fewer: an arc takes many samples, and
    memory shall stay flat."""
    # `in` is ten times as fast as `count`
    letters = (b"I", b"J", b"K", b"R", b"i", b"j", b"k", b"r")
    arcs = max(text.count(letter) if letter in text else 0 for letter in letters)
    size = -(-len(text) // max(-(-arcs // MOST_ARCS), 1))
    start = 0
    while start < len(text):
        stop = text.find(b"\n", min(start + size, len(text)) - 1) + 1 or len(text)
        yield text[start:stop]
        start = stop


def _unwanted(text: bytes, checked: bool) -> tuple[int, str, str] | None:
    """Where the first line begins that is too long or gcomp's own mark, with what to say, or
    None."""
    found = []
    if mark := marks.PROGRAM[0].search(text):
        found.append((text.rfind(b"\n", 0, mark.start()) + 1, *OWN_OUTPUT))
    start = 0
    while len(text) - start > intake.LINE:
        stop = text.rfind(b"\n", start, start + intake.LINE + 1) + 1
        if not stop:
            found.append((start, *TOO_LONG))
            break
        start = stop
    wrong = checksums.check(text) if checked else None
    if wrong:
        start = 0
        for _ in range(wrong[0]):
            start = text.find(b"\n", start) + 1
        found.append((start, wrong[1], DAMAGED))
    return min(found) if found else None


@mutable
class Summary:
    """What was done so far. largest: mm, the largest correction of an axis."""

    lines: int = 0
    blocks: int = 0
    motions: int = 0
    changed: int = 0
    added: int = 0
    largest: float = 0.0


def setup_of(
    machine: Machine,
    offsets: dict[str, dict[str, float]] | None = None,
    start: dict[str, float] | None = None,
    block_delete: bool = False,
    arc_centre: str = "incremental",
    integers: str = "",
    scaling: str = "",
) -> Setup:
    """What the text layer must know of a machine, and of how its control is set. start: mm by axis,
    and under T the number of the tool in the spindle."""
    return Setup(
        axes=machine.letters,
        diameter=frozenset(machine.diameter),
        least_increment={x: axis.least_increment for x, axis in machine.axes.items()},
        offsets={**machine.offsets, **(offsets or {})},
        start={x: value for x, value in (start or {}).items() if x != "T"},
        tool=int((start or {}).get("T", -1)),
        block_delete=block_delete,
        arc_centre=arc_centre,
        integers=integers,
        scaling=scaling,
        kinematics=Poses(machine) if machine.chain.rotary else None,
        home=dict(machine.home),
    )


def marker_of(machine: Machine, tolerance: float) -> str:
    """The comment that tells a corrected program from a nominal one."""
    name = intake.label(machine.name).upper()
    return f"(GCOMP {__version__} {name} MAP {machine.digest.upper()} TOL {tolerance / UM:g} UM)"


@mutable
class Filter:
    """feed(text) -> text, finish() -> text. `name` is what errors call the program; `watchers` see
    every batch; heat: which temperature each block meets, of a machine that grows.

    On a fault everything before the faulty block has been handled: the ProgramError carries it as
    `delivered`.
    """

    machine: Machine
    dialect: Dialect
    setup: Setup
    options: Options = DEFAULTS
    name: str = "<stdin>"
    notices: list[Notice] = field(default_factory=list)
    summary: Summary = field(default_factory=Summary)
    watchers: list[Watcher] = field(default_factory=list)
    heat: Heat | None = None

    def __post_init__(self) -> None:
        self.interpreter = Interpreter(self.dialect, self.setup)
        written_out = self.dialect.holes_written_out
        options = replace(
            self.options,
            arc_mismatch=self.dialect.arc_tolerance_mm / 2,
            passes_unknown=self.dialect.homes,
            holes_written_out=written_out,
            heat_step=tuple(self.heat.step.tolist()) if self.heat else (),
        )
        self.compensator = Compensator(self.machine, options)
        marker = marker_of(self.machine, self.compensator.tolerance)
        if (
            not self.dialect.grammar.parentheses or self.dialect.carried
        ):  # ( ) is no comment there, or not on every firmware
            marker = "; " + marker
        self.emitter = Emitter(self.dialect, self.setup, marker)
        self.modal: ModalState = self.interpreter.initial()
        self.carry = self.compensator.initial(self.interpreter.stands()[0])
        self.written = Written()
        self.contours = Contours()
        self.warmth: HeatState | None = self.heat.initial() if self.heat else None
        self._rest = b""
        self._numbering = checksums.START
        self._percent_seen = False
        self._reported: dict[str, float] = {}
        self._counted: dict[str, Notice] = {}

    # -- the two verbs -----------------------------------------------------------------------------

    def feed(self, data: bytes) -> bytes:
        """Corrected text of all whole lines so far. Raises ProgramError."""
        end = data.rfind(b"\n") + 1
        if not end:
            self._rest += data
            if len(self._rest) > intake.LINE and not self.modal.ended:
                raise self._error(self._rest, *TOO_LONG)
            return b""
        text, self._rest = self._rest + data[:end], data[end:]
        if len(text) <= MOST_ARCS:  # one byte each at least
            return self._lines(text)
        return self._handled(partial(self._lines, part) for part in _portions(text))

    def finish(self) -> bytes:
        """Corrected text of what is left, at the end of the input."""
        text, self._rest = self._rest, b""
        out = self._lines(text) if text else b""
        unknown = self._counted.get("unknown")
        # no feed ever had a place
        if unknown is not None and unknown.refusal[0] and not self.summary.changed:
            error = ProgramError(*unknown.refusal, Place(self.name, unknown.line))
            error.delivered = out
            raise error
        return out

    # -- one batch ---------------------------------------------------------------------------------

    @staticmethod
    def _handled(steps: Iterable[Callable[[], bytes]]) -> bytes:
        """What all steps give, in turn; an error carries what was done before it."""
        out: list[bytes] = []
        for step in steps:
            try:
                out.append(step())
            except ProgramError as error:
                error.delivered = b"".join(out) + error.delivered
                raise
        return b"".join(out)

    def _lines(self, text: bytes) -> bytes:
        """Whole lines, "%" lines among them."""
        if self.modal.ended:
            if self.dialect.homes and (axis := faults.AXIS_WORD.search(text)):
                line = self.summary.lines + text.count(b"\n", 0, axis.end()) + 1
                self._tell(Notice("behind", faults.BEHIND_END, line))
            self.summary.lines += text.count(b"\n")
            return self._numbered(text)
        words = lex(text, self.dialect.grammar, self.setup.block_delete)
        if words.tape < 0:
            return self._batch(words)
        # A "%" line: what stands before it, then the line itself, then the rest.
        start = text.rfind(b"\n", 0, words.tape) + 1
        stop = text.find(b"\n", words.tape) + 1 or len(text)
        if start:
            return self._handled(
                [partial(self._lines, text[:start]), partial(self._lines, text[start:])]
            )
        return self._handled([partial(self._tape, text[:stop]), partial(self._lines, text[stop:])])

    def _tape(self, line: bytes) -> bytes:
        """The first "%" opens the program, one after blocks ends it: the control reads no
        further."""
        if line.strip()[:1] != b"%":
            raise self._error(
                line,
                "'%' stands inside a block",
                "'%' begins and ends a program, in a line of its own",
            )
        if self.dialect.homes and line.strip()[1:].lstrip()[:1].isalpha():
            raise self._error(
                line,
                "'%' begins a command of the sender",
                "what it does to the axes is not known here: take it out",
            )
        if self._percent_seen:
            self.modal = replace(self.modal, ended=True)
        self._percent_seen = True
        self.summary.lines += 1
        return line

    def _batch(self, words: Words) -> bytes:
        """Whole lines without "%". What no control must see is refused when all before it is
        handled."""
        text = words.text
        bad = _unwanted(text, self.dialect.grammar.checksums)
        if bad is None:
            try:
                return self._pass(words)
            except BlockFault as fault:
                raise self._deliver(words, fault) from None
        start, message, advice = bad
        before = self._lines(text[:start]) if start else b""
        if self.modal.ended:
            self.summary.lines += text.count(b"\n", start)
            return before + text[start:]
        error = self._error(text[start:], message, advice)
        error.delivered = before
        raise error

    def _pass(self, words: Words) -> bytes:
        """One batch: motions of its words, pieces of the motions, text of the pieces. What holds
        behind it is kept only when all three were accepted: a faulty block changes nothing."""
        motions, modal, notices = self.interpreter.run(words, self.modal)
        if words.fault and not modal.ended:
            raise words.fault
        warmth = None
        if self.heat and self.warmth:
            motions, warmth, said = self.heat.run(words, motions, self.warmth)
            notices = [*notices, *(self._of_heat(notice, words) for notice in said)]
        try:
            pieces, carry, more = self.compensator.run(motions, self.carry)
        except MotionFault as fault:
            raise BlockFault(
                int(motions.block[fault.motion]), fault.message, fault.advice
            ) from None
        contours = (
            self.contours if self.machine.is_zero else follow_both(self.contours, motions, pieces)
        )
        result, written, changed, added = self.emitter.run(words, motions, pieces, self.written)
        result = self._numbered(result)
        for watcher in self.watchers:
            watcher(words, motions, pieces, result, self.summary.lines)
        for notice in notices:
            self._tell(replace(notice, line=self.summary.lines + notice.line + 1))
        for notice in more:
            self._tell(
                replace(
                    notice,
                    line=self.summary.lines + int(words.line[motions.block[notice.line]]) + 1,
                )
            )
        self.modal = modal
        self.carry = carry
        self.written = written
        self.contours = contours
        self.warmth = warmth
        self._percent_seen |= bool(len(words.letter))
        self.summary.lines += words.text.count(b"\n")
        self.summary.blocks += words.blocks
        self.summary.motions += len(motions)
        self.summary.changed += changed
        self.summary.added += added
        self.summary.largest = carry.largest
        return result

    def _of_heat(self, notice: Notice, words: Words) -> Notice:
        """A notice of what heat does, at the line of its block, or of no line."""
        of_all = notice.code in ("heat", "heat stops", "heat dwells", "heat surface")
        return replace(
            notice, line=-self.summary.lines - 1 if of_all else int(words.line[notice.line])
        )

    def _numbered(self, text: bytes) -> bytes:
        """The text with line numbers and checksums as they must be after what was put in; where
        nothing ever is, as it is."""
        if not self.dialect.grammar.checksums or self.machine.is_zero:
            return text
        text, self._numbering = checksums.renumber(text, self._numbering)
        return text

    def _deliver(self, words: Words, fault: BlockFault) -> ProgramError:
        """Handle the blocks before the faulty one, and name the fault by its place."""
        known = fault.block < words.blocks
        start = int(words.block_start[fault.block]) if known else int(fault.start)
        line_start = words.text.rfind(b"\n", 0, start) + 1
        before = b""
        if line_start:
            try:
                before = self._pass(
                    lex(words.text[:line_start], self.dialect.grammar, self.setup.block_delete)
                )
            # a block before it that the physics refuses, which the text did not show: that one is
            # told
            except BlockFault as earlier:
                return self._deliver(
                    lex(words.text[:line_start], self.dialect.grammar, self.setup.block_delete),
                    earlier,
                )
        columns = (
            (fault.start - line_start + 1, fault.stop - line_start + 1) if fault.stop else (0, 0)
        )
        advice = fault.advice
        runs = self.dialect.language in ("fanuc", "linuxcnc", "siemens")
        if advice in (faults.ADVICE_EXPRESSION, faults.ADVICE_POLAR) and not runs:
            advice = faults.ADVICE_NO_LANGUAGE
        if advice == faults.ADVICE_CORNER and self.dialect.language != "fanuc":
            advice = faults.ADVICE_NO_CORNER
        if not self.dialect.carried and any(x.word == "G54" for x in self.dialect.codes):
            advice = limits.with_zeros(advice, self.setup.offsets, "".join(self.machine.letters))
        error = self._error(words.text[line_start:], fault.message, advice, *columns)
        error.delivered = before
        return error

    def _error(
        self, text: bytes, message: str, advice: str, start: int = 0, stop: int = 0
    ) -> ProgramError:
        """An error in the first line of `text`, where all lines before it are handled."""
        line = text.split(b"\n", 1)[0][:1000].decode("latin-1")
        if line.lstrip().startswith("/") and not self.setup.block_delete:
            advice += f"; {IF_LEFT_OUT}"
        return ProgramError(
            message, advice, Place(self.name, self.summary.lines + 1, line, start, stop)
        )

    def _tell(self, notice: Notice) -> None:
        if notice.counts:
            if (before := self._counted.get(notice.code)) is not None:
                sums = tuple(map(sum, zip(before.counts, notice.counts, strict=True)))
                first = before if before.refusal[0] or not notice.refusal[0] else notice
                notice = replace(first, counts=sums)
            self._counted[notice.code] = notice
            self.notices[:] = [n for n in self.notices if n.code != notice.code]
            self.notices.append(replace(notice, message=notice.counted()))
            return
        if self._reported.get(notice.code, -1.0) < notice.size:
            self._reported[notice.code] = notice.size
            self.notices[:] = [n for n in self.notices if n.code != notice.code]
            self.notices.append(notice)
