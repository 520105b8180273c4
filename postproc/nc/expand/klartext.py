"""Heidenhain Klartext, run: labels, repeated parts, jumps, Q parameters and called programs become
plain statements, without block numbers (the control numbers blocks by itself).

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, Klartext programming, "Subprograms and program
section repeats" and "Q parameters". CALL LBL 1 runs to LBL 0; CALL LBL 1 REP 3 runs the section
from LBL 1 to here three times more. Statements that calculate stay where they are; of a place, a
feed or a cycle's datum the number is written for its Q. What the control alone knows (FN 18, what
no statement has set) is refused where it is used.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from postproc.nc.comments import code_alone, uncommented
from postproc.nc.expand import Limits, Line, Program, Refusal
from postproc.nc.expand.klartext_formulas import Formula, FormulaError, Unset
from postproc.nc.expand.tracker import Tracker, number
from postproc.nc.grammar import KLARTEXT
from postproc.nc.klartext import HEAD, pointed

LABEL = re.compile(rb"LBL[ \t]+(?:([0-9]+)|\"([^\"]+)\")")
CALL = re.compile(rb"CALL[ \t]+LBL[ \t]+(?:([0-9]+)|\"([^\"]+)\")[ \t]*(?:REP[ \t]*([0-9]+))?")
PROGRAM = re.compile(rb"CALL[ \t]+PGM[ \t]+(\S[^;\r\n]*)")
JUMP = re.compile(
    rb"FN[ \t]*(?:9|10|11|12)[ \t]*:[ \t]*IF(.+?)(EQU|NE|GT|LT)(.+?)GOTO[ \t]+LBL[ \t]*"
    rb"(?:([0-9]+)|\"([^\"]+)\")"
)
ASSIGN = re.compile(rb"(?:FN[ \t]*([0-9]+)[ \t]*:[ \t]*)?Q([LR]?[0-9]+)[ \t]*=[ \t]*(.+)")
READ = re.compile(rb"FN[ \t]*(?:1[89]|2[0-9]|3[0-9])[ \t]*:[^Q\r\n]*Q([LR]?[0-9]+)")
USED = re.compile(rb'"[^"\n]*"|(?<=[A-Z =])([+-]?)[ \t]*Q([LR]?[0-9]+)(?![0-9]*[ \t]*=)')
PLAIN = re.compile(rb"(?:L|APPR|DEP|C|CC|CR|CP|LP|LN|TOOL|CYCL|TRANS|PLANE|M)(?![A-Z])")
STRAIGHT = re.compile(rb"L(?![A-Z])")
CORNER = re.compile(rb"(?:RND|CHF)(?![A-Z])")
ENDS = re.compile(rb"(?<![A-Z])M[ \t]*0*(?:2|30)(?![0-9])")
NUMBERS = re.compile(rb"[ \t]*[-+]?[0-9]*\.?[0-9]+[ \t\r]*")
GIVE = "give it a value in the program before this line, the one that it has on the control"


def lines(program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The statements in the order in which the control executes them. Raises ProgramError."""
    yield from _Run(program, tracker, limits).run(program.whole_lines(), "", 0)


@dataclass
class _File:
    """One file, where its run stands (`at`: the next line, `here`: this one), and where LBL 0 goes
    back to; `cycle`: a cycle's definition goes on in the next line."""

    texts: list[bytes]
    name: str
    codes: list[bytes]
    depth: int
    at: int = 0
    here: int = 0
    cycle: bool = False
    remark: bool = False  # a comment goes on in the next line
    labels: dict[str, int] = field(default_factory=dict)
    back: list[int] = field(default_factory=list)
    repeated: dict[int, int] = field(default_factory=dict)

    @property
    def text(self) -> bytes:
        return self.texts[self.here]

    @property
    def code(self) -> bytes:
        return self.codes[self.here]


@dataclass
class _Run:
    """One execution. q: the values of Q parameters by name; steps: statements so far; ended: behind
    M2, M30 or END PGM of the main program."""

    program: Program
    tracker: Tracker
    limits: Limits
    q: dict[str, float] = field(default_factory=dict)
    steps: int = 0
    ended: bool = False

    def run(self, texts: list[bytes], file: str, depth: int) -> Iterator[Line]:
        """One file."""
        texts = [_pointed(text) for text in texts]
        part = _File(texts, file, [_code(text) for text in texts], depth)
        try:
            self._find_labels(part)
            while part.at < len(texts) and not self.ended:
                part.here = part.at
                part.at += 1
                self.steps += 1
                if self.steps > self.limits.steps:
                    raise self.limits.endless()
                # without block delete the statement runs as any other
                if part.text.lstrip().startswith(b"/") and self.tracker.setup.block_delete:
                    continue
                yield from self._statement(part)
        except Refusal as e:
            name = part.name or self.program.name
            raise e.at(name, part.here + 1, part.text) from None
        if not depth and self.ended:
            yield from self._end(part)

    # Whole: one branch to a statement of the language.
    def _statement(self, part: _File) -> Iterator[Line]:
        """One line: what it stands for, and which line is next."""
        code, text = part.code, part.text
        if part.remark or text.lstrip(b" \t0123456789*").startswith(b";"):
            yield Line((b"; " if part.remark else b"") + _bare(text), part.here + 1, part.name)
            part.remark = _goes_on(text)
            return
        if CORNER.match(code):
            corner = code[:3].decode()
            raise Refusal(f"{corner} stands behind no straight line", "write it behind L")
        if part.cycle or PLAIN.match(code):
            filled = self._filled(text if part.cycle else _bare(text))
            part.cycle = _goes_on(text) and (part.cycle or code.startswith(b"CYCL"))
            ends = ENDS.search(code_alone(code, KLARTEXT))
            self.ended = ends is not None and not code.startswith((b"Q", b"CYCL"))
            yield from self._corner(part)
            yield Line(filled, part.here + 1, part.name)
        elif label := LABEL.match(code):
            if label[1] is not None and not int(label[1]) and part.back:
                # CALL LBL 1 goes on behind LBL 1; `back` has the line behind each call, the last
                # one on top
                part.at = part.back.pop()
        elif call := CALL.match(code):
            self._call(part, call)
        elif other := PROGRAM.match(code):
            yield from self._called(part, other[1])
        elif jump := JUMP.match(code):
            if self._holds(jump):
                part.at = self._to(part, _name(jump[4], jump[5]))
        else:
            self._assign(code)
            yield Line(_bare(text), part.here + 1, part.name)

    def _corner(self, part: _File) -> Iterator[Line]:
        """RND or CHF behind a line, which comes in front of it: who writes it out knows then that
        the line's end is a corner."""
        if part.cycle or not STRAIGHT.match(part.code):
            return
        line, at = part.here, part.at
        while at < len(part.texts) and not part.codes[at]:
            at += 1
        if at < len(part.texts) and CORNER.match(part.codes[at]):
            part.here, part.at = at, at + 1
            yield Line(self._filled(_bare(part.text)), at + 1, part.name)
            part.here = line

    def _end(self, part: _File) -> Iterator[Line]:
        """END PGM, which stands behind the labels that M30 keeps from running."""
        for at, code in enumerate(part.codes):
            if code.startswith(b"END PGM"):
                yield Line(_bare(part.texts[at]), at + 1, part.name)

    def _to(self, part: _File, name: str) -> int:
        if name not in part.labels:
            raise Refusal(f"there is no LBL {name}", "write it, or correct its name")
        return part.labels[name]

    def _call(self, part: _File, call: re.Match[bytes]) -> None:
        """CALL LBL, with REP or without."""
        to, here = self._to(part, _name(call[1], call[2])), part.here
        if call[3] is None:
            if len(part.back) >= self.limits.depth:
                raise self.limits.too_deep()
            part.back.append(part.at)
            part.at = to
        elif part.repeated.get(here, 0) < int(call[3]):
            # counted by the line of the call: REP 2 goes back twice, so that the section runs three
            # times, and begins to count anew when an outer one brings it by again
            part.repeated[here] = part.repeated.get(here, 0) + 1
            part.at = to
        else:
            part.repeated[here] = 0

    def _find_labels(self, part: _File) -> None:
        for at, code in enumerate(part.codes):
            label = LABEL.match(code)
            if not label or (label[1] is not None and not int(label[1])):
                continue
            name = _name(label[1], label[2])
            if name in part.labels:
                part.at = at + 1
                part.here = at
                raise Refusal(f"LBL {name} stands twice", "give one another number")
            part.labels[name] = at + 1

    def _called(self, part: _File, name: bytes) -> Iterator[Line]:
        """Another program's statements, from its BEGIN to its end."""
        plain = name.decode("latin-1").strip().strip('"').replace("\\", "/").split("/")[-1]
        # TNC:\DIR\NAME.H: the folder is the control's own, the file lies beside the program
        stems = [plain] if "." in plain else [plain + ".h", plain + ".H", plain]
        found = next((t for s in stems if (t := self.program.library(s)) is not None), None)
        if found is None:
            raise Refusal(
                f"there is no program {plain} beside this one",
                "put its file there, or name its folder with --library",
            )
        if part.depth >= self.limits.depth:
            raise self.limits.too_deep()
        inner = Program(plain, found).lines()
        # one program comes out: what frames the called one goes, line for line
        kept = [b"" if re.match(rb"BEGIN|END PGM|BLK", _code(t)) else t for t in inner]
        yield from self.run(kept, plain, part.depth + 1)
        self.ended = False  # M30 of a called program comes back to the calling one

    def _holds(self, jump: re.Match[bytes]) -> bool:
        left, right = (self._value(side) for side in (jump[1], jump[3]))
        return {
            b"EQU": left == right,
            b"NE": left != right,
            b"GT": left > right,
            b"LT": left < right,
        }[jump[2]]

    def _assign(self, code: bytes) -> None:
        """What a statement sets; where that is not known, who uses it is told."""
        found = ASSIGN.match(code)
        read = READ.match(code) if found is None else None
        if found and (found[1] is None or int(found[1]) <= 8):
            try:
                self.q[found[2].decode()] = self._value(found[3])
                return
            except Refusal:
                pass
        name = found[2] if found else read[1] if read else b""
        # from here on it is as if it had never been set: whoever uses it is refused
        self.q.pop(name.decode(), None)

    def _value(self, formula: bytes) -> float:
        try:
            return Formula(formula.decode("latin-1"), self.q).value()
        except Unset as error:
            raise Refusal(f"{error} has no value in this program yet", GIVE) from None
        except FormulaError as error:
            raise Refusal(str(error), error.advice) from None

    def _filled(self, bare: bytes) -> bytes:
        """The statement with a number for each Q; a cycle's datum sets its Q too."""
        body, comment = _apart(bare)

        def put(match: re.Match[bytes]) -> bytes:
            if match[2] is None:  # a name
                return match[0]
            name = match[2].decode()
            if name not in self.q:
                raise Refusal(f"Q{name} has no value in this program yet", GIVE)
            value = self.q[name] * (-1 if match[1] == b"-" else 1)
            written = number(value, 6).rstrip(".").encode()
            return written if written.startswith(b"-") or not match[1] else b"+" + written

        body = USED.sub(put, body)
        datum = ASSIGN.match(_code(body))
        if datum and NUMBERS.fullmatch(datum[3]):
            self.q[datum[2].decode()] = float(datum[3])
        return body + comment


def _apart(text: bytes) -> tuple[bytes, bytes]:
    """A line up to its comment, and that."""
    end = len(uncommented(text, KLARTEXT).rstrip(b" "))
    return text[:end], text[end:]


def _code(text: bytes) -> bytes:
    """A statement without its number, its slash and its comment, in capitals."""
    head = HEAD.match(text)
    assert head is not None
    return _apart(text)[0][head.end() :].rstrip(b" \t\r~").upper()


def _pointed(text: bytes) -> bytes:
    """A line with points for decimal commas; names and comments keep theirs."""
    code, comment = _apart(text)
    return text if b'"' in code else pointed(code) + comment


def _bare(text: bytes) -> bytes:
    """A line without its block number."""
    head = HEAD.match(text)
    assert head is not None
    return b"/ " + text[head.end() :] if head[1] else text[head.end() :] or text


def _goes_on(text: bytes) -> bool:
    return text.rstrip(b" \t\r").endswith(b"~")


def _name(number: bytes | None, text: bytes | None) -> str:
    return str(int(number)) if number is not None else (text or b"").decode("latin-1")
