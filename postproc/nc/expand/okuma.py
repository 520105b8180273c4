"""Okuma's user tasks, run: jumps, variables and subprograms become plain blocks.

Okuma OSP-P200L / P20L programming manual 5238-E, user task, as NC-PB/gEdit sums it up
(syntax-okuma.md), and MachinistFTW/OkumaMacros, which run on lathes and mills. GOTO N2 and IF [V1
EQ 3] N2 (GOTO N2) go to a block of the same program by its name, which is text (N2 is not N02); IF
PX N2 where the local variable PX has a value. CALL O1 Q3 PX=5 runs a subprogram three times up to
RTS, which takes its variables' values away; MODIN O1 runs it behind every block that moves an axis,
until MODOUT. X=V1+2 is a word whose number is worked out, in a shape (NLAP1 G81) where it
stands: at its call it must still be that one. Common variables (V1, VC1) hold unknown values
until the program sets them, as does what NOEX sets. What sets or asks the control's own stays, and
is refused where it is run.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

from postproc.errors import ProgramError
from postproc.nc.expand import Limits, Line, Program, Refusal
from postproc.nc.expand.klartext_formulas import FormulaError, Unset, Worked
from postproc.nc.expand.okuma_expressions import VARIABLE, Expression, is_own
from postproc.nc.expand.tracker import Tracker, number

COMMENT = re.compile(rb"\([^()\n]*\)?")
HEAD = re.compile(rb"[ \t]*(?:/[ \t]*)?(?:(N(?!OEX\b)[A-Z0-9]+)(?=[ \t/]|\Z)[ \t]*)?(?:/[ \t]*)?")
DELETED = re.compile(rb"[ \t]*(?:N[A-Z0-9]+[ \t]+)?/", re.IGNORECASE)
NAMED = re.compile(rb"(O[A-Z0-9]+)[ \t]*\Z")
TAPE = re.compile(rb"\$[-A-Z0-9._]*%|%\Z")  # before a program
GOES_ON = re.compile(rb"[ \t]*\$(?![-A-Z0-9._]*%)", re.IGNORECASE)
STATEMENT = re.compile(rb"(IF(?=[ \t\[])|GOTO|CALL|MODIN|MODOUT|RTS|NOEX)(?![A-Z0-9])[ \t]*")
TARGET = re.compile(r"[ \t]*(?:GOTO[ \t]*)?(N[A-Z0-9]+)[ \t]*\Z")
DEFINED = re.compile(rf"({VARIABLE})[ \t]+(?:GOTO[ \t]*)?(N[A-Z0-9]+)[ \t]*\Z")
CALLED = re.compile(r"(O[A-Z0-9]+)[ \t]*(?:Q[ \t]*=?[ \t]*([0-9]+)(?![0-9.])[ \t]*)?")
# words of two letters, which are no variables: SB=1200
TWO = r"[ADFIKLRSTUWXZ][AB]|B[CR]|QA|HP|C[LPQR]|S[XYZ]|T[LDS]"
SETS = re.compile(rf"(?!(?:{TWO})[ \t]*=)({VARIABLE})[ \t]*=[ \t]*")
OWN = re.compile(rb"V[A-Z]+[0-9]*(?<!VC)[ \t]*(?:\[|=)(?<!VC=)")
WORD = re.compile(rf"(?<![A-Z0-9])(?:([A-Z])|({TWO}))[ \t]*=[ \t]*")
PLAIN = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?=[ \t]*(?:[A-Z]|\Z))")
AXIS = re.compile(r"(?<![A-Z])[XYZABC][ \t]*=?[ \t]*[-+.0-9]")
# codes whose axis words move nothing: G10 G11, scaling, the setting of a zero
STILL = re.compile(rb"(?<![A-Z])G[ \t]*0*(?:4|10|11|5[01]|92)(?![0-9])")
ENDS = re.compile(rb"(?<![A-Z])M[ \t]*0*(?:2|30)(?![0-9])")
SHAPE = re.compile(rb"(?<![A-Z])G[ \t]*8[5-7][ \t]*(N[A-Z0-9]+)")  # called by its name
SHAPE_ENDS = re.compile(rb"(?<![A-Z])G[ \t]*80(?![0-9])")
GIVE = "give it a value in the program before this line, the one that it has on the control"


def lines(program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The blocks in the order in which the control executes them. Raises ProgramError."""
    yield from _Run(program, tracker, limits).main()


@dataclass
class _Part:
    """One program of a file: its lines from `first` to `last`, and the places of its blocks'
    names; `here`: the line that runs, `at`: the next one. `file`: "" for the main one."""

    file: str
    texts: list[bytes]
    codes: list[bytes]
    first: int
    last: int
    labels: dict[str, list[int]] = field(default_factory=dict)
    at: int = 0
    here: int = 0


def _parts(texts: list[bytes], file: str) -> dict[str, _Part]:
    """The programs of a file by name; the first one also as ""."""
    codes = [_code(text) for text in texts]
    begins = [(i, m[1].decode()) for i, code in enumerate(codes) if (m := NAMED.match(code))]
    if not begins or any(code and not TAPE.match(code) for code in codes[: begins[0][0]]):
        begins.insert(0, (0, ""))
    # what stands before the first name (%, comments) belongs to the first program
    begins[0] = (0, begins[0][1])
    found: dict[str, _Part] = {}
    for (first, name), (last, _) in zip(begins, [*begins[1:], (len(texts), "")], strict=True):
        part = _Part(file, texts, codes, first, last)
        for i in range(first, last):
            head = HEAD.match(_bare(texts[i]))
            if head and head[1]:
                part.labels.setdefault(head[1].decode(), []).append(i)
        found.setdefault(name, part)
    found.setdefault("", found[begins[0][1]])
    return found


class _Run:
    """`values`: of variables by name; NaN: unknown; none: a local variable is empty."""

    def __init__(self, program: Program, tracker: Tracker, limits: Limits):
        self.program, self.tracker, self.limits = program, tracker, limits
        self.files = {"": _parts(program.whole_lines(), "")}
        self.values: dict[str, float] = {}
        self.left = limits.steps
        self.ended = False
        # of MODIN the subprogram, how often, and where it stands
        self.behind: tuple[str, int, _Part, int] | None = None
        self.within = False  # a subprogram that MODIN runs
        self.block = b""  # the lines of a block under MODIN that goes on
        self.said: dict[tuple[str, int], bytes] = {}  # blocks whose numbers were worked out

    def main(self) -> Iterator[Line]:
        part = self.files[""][""]
        yield from self._run(part, 0)
        for i in range(part.at, part.last):  # behind the end only what is no block
            if not part.codes[i] or part.codes[i] == b"%":
                yield Line(part.texts[i], i + 1)

    # Whole: the one loop over statements, which jumps and calls lead.
    def _run(self, part: _Part, depth: int) -> Iterator[Line]:
        """One program, to RTS or its end."""
        part.at = part.first
        while part.at < part.last and not self.ended:
            here = part.here = part.at
            part.at += 1
            try:
                # of all statements of the run, those of called programs among them
                self.left -= 1
                if self.left < 0:
                    raise self.limits.endless()
                code = part.codes[here]
                if self.tracker.setup.block_delete and DELETED.match(part.texts[here]):
                    yield self._line(part, here)
                    continue
                found = STATEMENT.match(code)
                if found and found[1] == b"RTS":
                    return
                if depth and here == part.first and NAMED.match(code):
                    continue
                if found:
                    yield from self._statement(part, found, depth)
                elif SETS.match(code.decode("latin-1")) and not OWN.match(code):
                    self._assign(part, self._joined(part), plain=True)
                else:
                    if called := SHAPE.search(code):
                        self._as_passed(part, called[1].decode())
                    yield self._filled(part, here)
                    self.ended = bool(ENDS.search(code)) and not depth
                    if self.behind and not self.within and self._moves(part, code):
                        yield from self._behind(depth)
            except Refusal as e:
                raise self._error(part, here, e) from None
        if part.at == part.last < len(part.texts) and not self.ended:
            what = f"the program before it goes on into {part.codes[part.last].decode()}"
            raise self._error(part, part.last, Refusal(what, "write M02 or RTS at its end"))

    def _statement(self, part: _Part, found: re.Match[bytes], depth: int) -> Iterator[Line]:
        """GOTO, IF, CALL, MODIN, MODOUT and NOEX."""
        name = found[1]
        rest = self._joined(part)[found.end() :].decode("latin-1")
        if name == b"NOEX":
            for match in SETS.finditer(rest):
                self.values[match[1]] = math.nan
        elif name == b"MODOUT":
            self.behind = None
        elif name in (b"GOTO", b"IF"):
            self._jump(part, rest, name == b"IF")
        else:
            called = CALLED.match(rest)
            if called is None:
                raise self._strange(part)
            times = int(called[2] or 1)
            if name == b"CALL":
                yield from self._call(part, called[1], times, rest[called.end() :], depth)
            elif self.behind:
                raise Refusal("MODIN within MODIN", "end the first one before: MODOUT")
            else:
                self._assign(part, rest[called.end() :].encode("latin-1"))
                self.behind = called[1], times, part, part.here

    def _jump(self, part: _Part, rest: str, condition: bool) -> None:
        """GOTO N and IF [..] N: goes on behind the block of that name."""
        target = rest
        if condition and (defined := DEFINED.match(rest)):
            target = defined[2]
            if is_own(defined[1]) or math.isnan(self.values.get(defined[1], 0.0)):
                raise self._unset(defined[1])
            if defined[1] not in self.values:
                return
        elif condition:
            expression = Expression(rest, self.values)
            holds, stop = self._worked_out(expression.holds)
            target = rest.strip()[stop:]
            if not holds:
                if TARGET.match(target) is None:
                    raise self._strange(part)
                return
        to = TARGET.match(target)
        if to is None:
            raise self._strange(part)
        places = part.labels.get(to[1], [])
        # which of the two the control would take is in no text that was found
        if len(places) > 1:
            raise Refusal(f"two blocks are named {to[1]}", "give one another name")
        if not places:
            raise Refusal(
                f"there is no block {to[1]} in this program",
                "write its name before the block, with a blank behind it",
            )
        part.at = places[0]

    def _call(self, part: _Part, name: str, times: int, given: str, depth: int) -> Iterator[Line]:
        """A subprogram, so many times; behind it the variables of the call are empty."""
        called = self._find(part, name)
        if depth >= self.limits.depth:
            raise self.limits.too_deep()
        names = self._assign(part, given.encode("latin-1"))
        for _ in range(times):
            yield from self._run(replace(called), depth + 1)
        for own in names:
            # common variables keep what the call has given them
            if not own.startswith("V"):
                self.values.pop(own, None)

    def _moves(self, part: _Part, code: bytes) -> bool:
        """Whether a block that ends with this line moves an axis; $ goes on with one."""
        self.block += b" " + code
        if part.at < part.last and GOES_ON.match(part.texts[part.at]):
            return False
        block, self.block = self.block, b""
        return AXIS.search(block.decode("latin-1")) is not None and not STILL.search(block)

    def _behind(self, depth: int) -> Iterator[Line]:
        """What MODIN runs behind a motion."""
        assert self.behind is not None
        name, times, part, here = self.behind
        self.within = True
        try:
            yield from self._call(part, name, times, "", depth)
        except Refusal as e:
            raise self._error(part, here, e) from None
        self.within = False

    def _as_passed(self, part: _Part, name: str) -> None:
        """Refuses a shape with other numbers at its call than where it stands: which count?"""
        places = [(p, i) for p in self.files[part.file].values() for i in p.labels.get(name, ())]
        for other, first in places:
            for i in range(first, other.last):
                said = self.said.get((part.file, i))
                try:
                    # its blocks were written out where they stand, and the cycle of the call (G85)
                    # reads them there
                    same = said is None or self._filled(other, i).text == said
                except Refusal as e:
                    raise self._error(other, i, e) from None
                if not same:
                    raise Refusal(
                        f"line {i + 1} of the shape has other numbers here than where it stands",
                        "set its variables before the shape, and change them behind its calls",
                    )
                if SHAPE_ENDS.search(other.codes[i]):
                    break

    def _find(self, part: _Part, name: str) -> _Part:
        """A program by its name: in the files that are open, else in one of its own."""
        # where it stands itself, in the main program, in a file that bears its name
        for file in (part.file, "", name):
            if name in self.files.get(file, {}):
                return self.files[file][name]
        text = self.program.library(name)
        if text is None:
            raise Refusal(
                f"there is no program {name} in this file or beside it",
                "put its file there, or name its folder with --library",
            )
        parts = self.files[name] = _parts(Program(name, text).lines(), name)
        return parts.setdefault(name, parts[""])

    # -- numbers -----------------------------------------------------------------------------------

    def _assign(self, part: _Part, code: bytes, plain: bool = False) -> list[str]:
        """AB=5 AC=V1+2: the names. `plain`: what is not known is told where it is used."""
        text, at = code.decode("latin-1"), 0
        names: list[str] = []
        while at < len(text.rstrip()):
            match = SETS.match(text, at)
            if match is None:
                raise self._strange(part)
            rest = text[match.end() :]
            blank = len(rest) - len(rest.lstrip())
            try:
                value, stop = self._worked_out(Expression(rest, self.values).first)
            except Refusal:
                if not plain:
                    raise
                self.values[match[1]] = math.nan
                return names
            self.values[match[1]] = value
            names.append(match[1])
            at = match.end() + blank + stop
            at += len(text[at:]) - len(text[at:].lstrip())
        return names

    def _filled(self, part: _Part, here: int) -> Line:
        """A plain block with a number for each expression."""
        text = part.texts[here]
        bare = _bare(text).decode("latin-1")
        #   X=V1+2 Z=10   ->   X12 Z10     one letter loses its "="; words of two (SB=1200) keep it
        pieces, done = [], 0
        for match in WORD.finditer(bare):
            if match.start() < done:
                continue
            begin, letter = match.end(), match[1]
            if plain := PLAIN.match(bare, begin):
                if letter:
                    pieces.append(text[done : match.start()] + letter.encode())
                    done = plain.start()
                continue
            if GOES_ON.match(text):
                raise Refusal("an expression behind $", "write its block in one line")
            value, stop = self._worked_out(Expression(bare[begin:], self.values).first)
            written = self._written(letter or match[2], value)
            head = text[done : match.start()] + (
                letter.encode() if letter else text[match.start() : begin]
            )
            pieces.append(head + written)
            rest = bare[begin:]
            done = begin + len(rest) - len(rest.lstrip()) + stop
        line = self._line(part, here)
        if not pieces:
            return line
        self.said[part.file, here] = filled = b"".join(pieces) + text[done:]
        return line._replace(text=filled)

    def _written(self, letter: str, value: float) -> bytes:
        """The number of a word."""
        if letter == "T":
            return b"%0*d" % (4 if value < 1e4 else 6, round(value))
        text = number(value, self.tracker.decimals(letter)).rstrip(".")
        if self.tracker.counts and "." in text:
            raise Refusal(
                f"{letter}={text} while whole numbers count least increments",
                "write it as a whole number, or say --integers units",
            )
        return text.encode()

    def _worked_out(self, of: Callable[[], Worked]) -> Worked:
        try:
            return of()
        except Unset as error:
            raise self._unset(str(error)) from None
        except FormulaError as error:
            raise Refusal(
                f"an expression that gives no number: {error}",
                "write the number itself in its place",
            ) from None

    # -- lines -------------------------------------------------------------------------------------

    def _joined(self, part: _Part) -> bytes:
        """A statement with the lines that go on behind it; the next line is behind them."""
        code = part.codes[part.here]
        while part.at < part.last and GOES_ON.match(part.texts[part.at]):
            code += b" " + _bare(part.texts[part.at]).strip()[1:].strip()
            part.at += 1
        return code

    def _line(self, part: _Part, here: int) -> Line:
        return Line(part.texts[here], here + 1, part.file)

    def _strange(self, part: _Part) -> Refusal:
        code = part.codes[part.here].decode("latin-1")
        return Refusal(
            f"{code[:40]!r} is no statement that is known here", "write out the blocks that it runs"
        )

    def _unset(self, name: str) -> Refusal:
        if is_own(name):
            return Refusal(f"{name}: only the control knows its value", GIVE)
        return Refusal(f"{name} has no value in this program yet", GIVE)

    def _error(self, part: _Part, line: int, wrong: Refusal) -> ProgramError:
        """What a user meets at a line of a program."""
        return wrong.at(part.file or self.program.name, line + 1, part.texts[line])


def _bare(text: bytes) -> bytes:
    """A line in capitals with blanks for its comments, byte for byte as long."""
    return COMMENT.sub(lambda m: b" " * len(m[0]), text).upper()


def _code(text: bytes) -> bytes:
    """A block without its slash, its name and its comments, in capitals."""
    bare = _bare(text).rstrip()
    head = HEAD.match(bare)
    assert head is not None
    return bare[head.end() :].strip()
