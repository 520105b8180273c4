"""Sinumerik expressions: text to a callable that gives a number, a truth value, a string or an
axis.

    expression = operand { operator operand }        evaluated by priority, equal ones from left to
                                                     right
    operand    = { "+" | "-" | NOT | B_NOT | "<<" } ( number | string | name | name "[" index "]" |
               name "(" values ")" |
                 "(" expression ")" )
    number     = 12 | 1.5 | .5 | 1.5EX-3 | 'H0F' | 'B101'

Names are the same in upper and lower case; R1 and R[1] are the same parameter. Source: as
siemens_values.
"""

from __future__ import annotations

import math
import re

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_values import (
    BINARY,
    FUNCTIONS,
    POSITIONS,
    UNARY,
    Axis,
    Node,
    Scope,
    Value,
    fitting,
    position,
    rounded,
)
from postproc.nc.expand.siemens_words import ADDRESSES

DEEPEST = 30  # parentheses and signs within each other
# A name has two letters at least, R5 and a letter with digits (X1, an axis) apart; bits are 'H0F'
# and 'B101'.
TOKEN = re.compile(
    r"""[ \t]*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:EX[+-]?\d+)?)
    |(?P<name>\$\$?[A-Z_][A-Z0-9_]*|[A-Z_]{2}[A-Z0-9_]*|R[ \t]*\d+|[A-Z]\d*)
    |(?P<string>"[^"]*")|'(?P<bits>H[0-9A-F]+|B[01]+)'
    |(?P<mark>==|<>|>=|<=|<<|[-+*/()\[\],<>=]))""",
    re.VERBOSE | re.IGNORECASE | re.ASCII,
)
ASSIGN_FIRST = "give it a value in the program before this line, the one that it has on the control"
FOREIGN = "write the value itself in its place: gcomp knows the program, not what the control holds"


class Parser:
    """Reads a line's code from `at` on; `at` stays behind the last thing read."""

    def __init__(self, text: str, at: int = 0):
        self.text, self.at, self.depth = text, at, 0

    def next(self) -> re.Match[str] | None:
        """The token that follows, which is not taken yet."""
        return TOKEN.match(self.text, self.at)

    def taken(self, *marks: str) -> str:
        """The mark or word that follows, if it is one of these; it is read then. "": it is not."""
        token = self.next()
        word = token[0].strip().upper() if token else ""
        if not token or word not in marks:
            return ""
        self.at = token.end()
        return word

    def need(self, *marks: str) -> str:
        """The same, but one of these must follow."""
        word = self.taken(*marks)
        if not word:
            raise self.wrong(" or ".join(repr(mark) for mark in marks) + " is missing")
        return word

    def wrong(self, message: str, advice: str = "see the manual for its syntax") -> Refusal:
        """A Refusal at the place where reading has come to."""
        blank = re.match(r"[ \t]*", self.text[self.at :])
        start = min(self.at + (blank.end() if blank else 0), max(len(self.text) - 1, 0))
        token = TOKEN.match(self.text, start)
        return Refusal(message, advice, start, token.end() if token else start + 1)

    def expression(self, least: int = 0) -> Node:
        """An expression with operators of at least this priority."""
        # operators of `least` and above are taken here, each with a right side of those above its
        # own: 2 - 3 - 4 is (2 - 3) - 4, and what binds less is left to who has called
        first, rest = self.operand(), []
        while (token := self.next()) and (
            found := BINARY.get((token["mark"] or token["name"] or "").upper())
        ):
            if found[0] < least:
                break
            self.at = token.end()
            rest.append((found[1], self.expression(found[0] + 1)))
        if not rest:
            return first

        def chain(scope: Scope) -> Value:
            value = first(scope)
            for operator, operand in rest:
                value = operator(value, operand(scope))
            return value

        return chain

    def operand(self) -> Node:
        """A value, with its signs."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.wrong(
                f"more than {DEEPEST} parentheses or signs within each other", "calculate in steps"
            )
        try:
            sign = self.taken(*UNARY)
            if sign:
                # signs and NOT bind most: NOT A == B is (NOT A) == B
                operator, value = UNARY[sign], self.operand()
                return lambda scope: operator(value(scope))
            if self.taken("("):
                value = self.expression()
                self.need(")")
                return value
            return self.value()
        finally:
            self.depth -= 1

    def value(self) -> Node:
        """A number, string, variable, function or system variable."""
        token = self.next()
        if token is None or token["mark"]:
            raise self.wrong("a value is missing, or is not one")
        start, self.at = token.start(), token.end()
        if token["name"]:
            return self.named("".join(token["name"].upper().split()), start)
        constant = _constant(token)
        return lambda scope: constant

    def named(self, name: str, start: int) -> Node:
        """What a name stands for; it has been read."""
        if name in ("TRUE", "FALSE", "$PI"):
            known: Value = math.pi if name == "$PI" else name == "TRUE"
            return lambda scope: known
        if name in BINARY or name in UNARY:
            raise Refusal(
                f"a value is missing before {name}", "see the manual for its syntax", start, self.at
            )
        if self.taken("("):
            return self.function(name, start)
        indices = self.indices()
        if name in POSITIONS and len(indices) == 1:
            return lambda scope: position(scope, name, indices[0](scope))
        if name[0] == "$":
            raise Refusal(
                f"the system variable {name} is known to the control only", FOREIGN, start, self.at
            )
        stop = self.at

        def read(scope: Scope) -> Value:
            # What a name is only the run knows: DEF may have made a variable of what is an address,
            # or an axis, elsewhere.
            if name not in scope.variables and name in ADDRESSES:
                message = f"{name} is an instruction: the value that it has can not be read"
                raise Refusal(message, "keep the value in a variable too", start, stop)
            if not indices and name not in scope.variables and scope.is_axis(name):
                return Axis(name)
            try:
                variable, place = scope.find(name, [rounded(index(scope)) for index in indices])
                value = variable.values[place]
                if value is None:
                    raise Refusal(f"{name} has no value in this program yet", ASSIGN_FIRST)
            except Refusal as e:
                raise e.placed(start, stop) from None
            return value

        return read

    def function(self, name: str, start: int) -> Node:
        """A function's value; its opening parenthesis has been read."""
        if name not in FUNCTIONS:
            raise Refusal(f"gcomp can not calculate the function {name}", FOREIGN, start, self.at)
        count, function = FUNCTIONS[name]
        values = [self.expression()]
        while self.taken(","):
            values.append(self.expression())
        self.need(")")
        if len(values) != count:
            raise Refusal(
                f"{name} takes {count} values, here are {len(values)}",
                "correct the call",
                start,
                self.at,
            )
        return lambda scope: function(*[value(scope) for value in values])

    def indices(self) -> list[Node]:
        """What stands between brackets, if brackets follow."""
        if not self.taken("["):
            return []
        found = [self.expression()]
        while self.taken(","):
            found.append(self.expression())
        self.need("]")
        return found


def _constant(token: re.Match[str]) -> Value:
    """A literal's value."""
    if token["string"]:
        return token["string"][1:-1]
    if token["bits"]:
        value = (
            int(token["bits"][1:], 16 if token["bits"][0] in "Hh" else 2)
            if len(token["bits"]) < 64
            else 2**64
        )
        return fitting(value)
    # without a point and short enough to be exact: INT, so that DIV and MOD count as whole numbers
    text = token["number"].upper()
    if text.isdigit() and len(text) < 16:
        return int(text)
    return fitting(float(text.replace("EX", "E")))
