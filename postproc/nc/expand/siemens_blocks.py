"""Sinumerik lines: what one says, ready to be executed as often as control comes by.

    line = [ "/" digit ] [ "N" number ] [ label ":" ] { word | assignment | call | jump } [ ";"
    comment ]

A line is cut only where something must be calculated; all between stays as it is. Commands of the
language that are no subprograms (COMMANDS) pass as text: whether they can be followed is for the
dialect to say.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_expressions import FOREIGN, TOKEN, Parser
from postproc.nc.expand.siemens_statements import (
    Call,
    Entry,
    Jump,
    Right,
    Statement,
    Target,
    assign,
    filled,
)
from postproc.nc.expand.siemens_values import Axis, Node, Scope, undefined
from postproc.nc.expand.siemens_words import ADDRESSES, COMMANDS, WRAPPERS, argument, word

NAME = r"[A-Z_]{2}[A-Z0-9_]*"
HEAD = re.compile(
    rf"[ \t]*(?:/[0-9]?[ \t]*)?(?:(?:N[ \t]*|:)\d+[ \t]*)?(?:({NAME}[ \t]*:(?!=))[ \t]*)?",
    re.IGNORECASE | re.ASCII,
)
# "(?>" gives nothing back: a long number that turns out to be no word would else be tried again at
# each of its digits.
WORD = re.compile(
    r"[ \t]*([A-Z])[ \t]*([+-]?(?>\d+\.?\d*|\.\d+))(EX[+-]?\d+)?(?![ \t]*(?:=(?!=)|\[|\())",
    re.IGNORECASE | re.ASCII,
)
# L140(2): a subprogram with values
NUMBERED = re.compile(r"[ \t]*(L\d+)(?=[ \t]*\()", re.IGNORECASE | re.ASCII)
PLAIN_VALUE = re.compile(r'[+-]?[ \t]*(?:\d+\.?\d*|\.\d+)|"[^"]*"', re.ASCII)
DESTINATION = re.compile(
    r"[ \t]*:?([A-Z0-9_]+)(?![A-Z0-9_]|[ \t]*(?:<<|\[))", re.IGNORECASE | re.ASCII
)
PASSES = re.compile(r"[ \t]*P[ \t]*(?:=|(?=[0-9]))", re.IGNORECASE)
LIST = re.compile(r"[ \t]*\((?:[^(),]|\([^()]*\))*,")  # a comma that no inner parentheses hold
BLANK = re.compile(r"[ \t]*")
END_OF_PROGRAM = (2, 17, 30)
JUMPS = ("GOTOF", "GOTOB", "GOTO", "GOTOC", "GOTOS")


class Words(Parser):
    """Reads words, assignments and calls into a Statement."""

    def __init__(self, text: str, code: int, at: int = 0):
        super().__init__(text[:code], at)
        self.into = Statement(text, code)

    def done(self) -> bool:
        """Whether nothing but blanks is left."""
        blank = BLANK.match(self.text, self.at)
        return blank is not None and blank.end() == len(self.text)

    def end(self, after: str) -> None:
        """Nothing may follow."""
        if not self.done():
            raise self.wrong(
                f"this does not belong behind {after}", "put it into a line of its own"
            )

    def words(self) -> Statement:
        """All that is left of the line."""
        others = 0
        while not self.done():
            found, numbered = WORD.match(self.text, self.at), NUMBERED.match(self.text, self.at)
            if numbered:
                self.call(numbered[1].upper(), numbered.start(1), numbered.end(), others)
            elif found and found[1] in "Ll" and found[2].isdigit():
                self.call(found[1].upper() + found[2], found.start(1), found.end(), others)
            elif found:
                self.at = found.end()
                others += self.word(found)
            else:
                others += self.named_word(others)
        return self.into

    def word(self, found: re.Match[str]) -> int:
        """A letter with its number; 1 if it can not stand beside a call."""
        letter, digits = found[1].upper(), found[2]
        if letter == "M" and digits.isdigit() and len(digits) < 9 and int(digits) in END_OF_PROGRAM:
            self.into.ends = f"M{int(digits)}"
            if self.into.ends == "M17":
                shown = found[0].strip(" \t")
                # M17 of a subprogram is its way back and not written; that of the main program
                # stays
                self.piece(found.start(1), found.end(), lambda scope: "" if scope.inner else shown)
        if found[3]:
            self.at = found.start(2)
            node = self.operand()
            self.piece(
                found.start(1), self.at, lambda scope: found[1] + word(scope, letter, node(scope))
            )
        return int(letter != "N")

    def named_word(self, others: int) -> int:
        """What begins with a name: a jump, an assignment, a command, a call."""
        token = self.next()
        if token is None or not token["name"]:
            raise self.wrong(
                f"{self.text[self.at :].strip()[:1]!r} does not belong to a block here",
                "take it out",
            )
        start, name = token.start("name"), "".join(token["name"].upper().split())
        if name in JUMPS or name == "IF":
            condition = self.expression() if self.taken("IF") else None
            self.into.jumps.append(self.jump(condition))
            self.piece(start, self.at, lambda scope: "")
            return 1
        self.at = token.end()
        indices = self.index_entries(name == "PO")
        stop = self.at
        # X1=.. R1=.. NAME[..]=..; a command with its brackets; or, alone in its line, a call
        if self.taken("="):
            self.assignment(Target(name, indices, start, stop))
        elif name in COMMANDS:
            self.command(start, indices)
        elif indices or len(name) == 1 or name[1:].isdigit() or name[0] == "$":
            raise Refusal(f"{name} stands here without a value", 'write one, with "="', start, stop)
        else:
            self.call(name, start, stop, others)
        return 1

    def command(self, start: int, indices: list[Entry]) -> None:
        """A command of the language, with what stands in its brackets or parentheses."""
        text, entries = self.into.text, [*indices, *self.arguments()]
        stop = self.at
        if any(entry and not entry.plain for entry in entries):
            self.piece(
                start, stop, lambda scope: filled(text, start, stop, entries, argument, scope)
            )

    def next_is(self, mark: str) -> bool:
        token = self.next()
        return bool(token) and token["mark"] == mark  # type: ignore[index]

    def piece(self, start: int, stop: int, text: Callable[[Scope], str]) -> None:
        self.into.pieces.append((start, stop, text))

    def assignment(self, target: Target) -> None:
        """A word or a variable; which, is known only when the line is executed."""
        text, name, right = self.into.text, target.name, self.right()
        start, stop = target.start, self.at
        if name[0] == "$":
            raise Refusal(
                f"{name} changes what the control holds, which is not followed",
                FOREIGN,
                start,
                stop,
            )
        # what is left of "=": an R parameter or variable, which goes from the line, or an address,
        # which stays with its number
        parameter = name[0] == "R" and (name == "R" or name[1:].isdigit())
        letter = not parameter and (len(name) == 1 or name[1:].isdigit())

        def execute(scope: Scope) -> str:
            if parameter or name in scope.variables:
                assign(scope, target, right)
                return ""
            if name == "AX" and len(target.indices) == 1:
                axis = target.indices[0].node(scope)
                if not isinstance(axis, Axis):
                    raise Refusal(
                        "AX[ ] takes the name of an axis", "write one, or a variable of type AXIS"
                    )
                address, left = axis.name, axis.name
            elif letter or name in ADDRESSES or name in COMMANDS or scope.is_axis(name):
                address = name
                left = filled(text, start, target.stop, target.indices, argument, scope)
            else:
                raise undefined(name)
            return left + filled(
                text,
                target.stop,
                stop,
                right.entries,
                lambda value: word(scope, address, value),
                scope,
            )

        # X=5 passes as it stands; of a longer name only the run knows whether it is an address or a
        # variable
        if not letter or target.indices or any(e and not e.plain for e in right.entries):
            self.piece(start, stop, execute)

    def right(self) -> Right:
        """A value, or a list of values."""
        kind = self.taken("SET", "REP")
        if kind or LIST.match(self.text, self.at):
            self.need("(")
            entries = self.listed()
            return Right(entries, kind or ("SET" if len(entries) > 1 else ""))
        token = self.next()
        if token and (token["name"] or "").upper() in WRAPPERS:
            self.at = token.end()
            self.need("(")
            value = self.entry()
            self.need(")")
            return Right([replace(value, wrapped=True)])
        return Right([self.entry()])

    def entry(self) -> Entry:
        """One expression, and whether it is a number as it stands."""
        token = self.next()
        if token is None:
            raise self.wrong("a value is missing")
        start = self.at + len(token[0]) - len(token[0].lstrip(" \t"))
        node = self.expression()
        return Entry(start, self.at, node, bool(PLAIN_VALUE.fullmatch(self.text, start, self.at)))

    def listed(self) -> list[Entry | None]:
        """Values up to the closing parenthesis; some may be left out."""
        found: list[Entry | None] = []
        while True:
            found.append(None if self.next_is(",") or self.next_is(")") else self.entry())
            if self.need(",", ")") == ")":
                return found

    def index_entries(self, empty: bool = False) -> list[Entry]:
        """What stands between brackets, if brackets follow; `empty`: nothing may (PO[ ], the
        denominator)."""
        found: list[Entry] = []
        if self.taken("["):
            if empty and self.taken("]"):
                return found
            while True:
                found.append(self.free(self.entry()))
                if self.need(",", "]") == "]":
                    break
        return found

    def arguments(self) -> list[Entry | None]:
        """What stands between parentheses, if they follow."""
        return [e and self.free(e) for e in self.listed()] if self.taken("(") else []

    def free(self, entry: Entry) -> Entry:
        """The same, but a number, a string or a lone name that is no variable stays as it
        stands."""
        # CYCLE81(RTP, ..) or POS[X]: RTP may be a variable or not, X an axis: asked when it runs
        token = TOKEN.fullmatch(self.text, entry.start, entry.stop)
        name = (token["name"] or "").upper() if token else ""
        return (
            entry
            if name[:1] == "$" or (name[:1] == "R" and name[1:].isdigit())
            else replace(entry, name=name)
        )

    def jump(self, condition: Node | None) -> Jump:
        """GOTOF and its kin with their destination."""
        kind = self.need(*JUMPS)
        begin = self.at - len(kind)
        if kind == "GOTOS":
            return Jump(kind, "", None, condition, begin, self.at)
        found = DESTINATION.match(self.text, self.at)
        if found:
            self.at = found.end()
            return Jump(kind, found[1].upper(), None, condition, begin, self.at)
        return Jump(kind, "", self.expression(), condition, begin, self.at)

    def call(
        self, name: str, start: int, stop: int, others: int, computed: Node | None = None
    ) -> None:
        """A subprogram call with its values and passes; it stands alone in its line."""
        self.at = stop
        # X10 FOO: a word that is misspelt, more likely than a call
        if others:
            message = (
                f"{name} is no word that gcomp knows, and a subprogram call stands alone in its"
                " line"
            )
            raise Refusal(
                message, "correct the word, or put the call into a line of its own", start, stop
            )
        values = self.arguments()
        count = None
        if passes := PASSES.match(self.text, self.at):
            self.at = passes.end()
            count = self.expression()
        self.end(f"the call of {name or 'a subprogram'}")
        self.into.call = Call(name, computed, values, count, start, self.at)
