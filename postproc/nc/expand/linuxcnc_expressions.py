"""RS274/NGC expressions: a line's code to callables that give numbers.

    value      = number | { "+" | "-" } value | "[" expression "]" | "#" parameter | function "["
               expression "]" |
                 "ATAN" "[" expression "]" "/" "[" expression "]" | "EXISTS" "[" "#" parameter "]"
    expression = value { operator value }          ** before * / MOD before + - before EQ NE GT GE
                                                   LT LE before AND OR XOR
    parameter  = value | "<" name ">"              a value here must be a whole number

Equal operators are taken from left to right, also ** (2**3**2 is 64). A sign belongs to the value
behind it (-2**2 is 4). Blanks and capital letters mean nothing. Angles are degrees; sines and the
like are worked out in long double, as LinuxCNC does, so that FIX[SIN[30]*2] is 1.

Sources: LinuxCNC documentation, "G-code overview", sections "Expressions", "Binary operators",
"Functions"; tolerances and everything at the edges as measured on LinuxCNC 2.9
(tests/expand/test_linuxcnc.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from postproc.nc.expand import Refusal

DEEPEST = 40  # brackets, signs and # within each other
EQUAL = 1e-4  # values less than this apart are equal for EQ and NE
WHOLE = 1e-4  # so near to a whole number a value must be where one is needed
LARGEST_ROUND = 2.0**31 - 1
PI = np.longdouble("3.14159265358979323846264338327950288")
PIECE = re.compile(rb"[ \t\r]+|\([^()]*\)|;.*|.", re.DOTALL)
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?![\d.])", re.ASCII)
OPERATOR = re.compile(r"\*\*|[-+*/]|mod|and|xor|or|eq|ne|gt|ge|lt|le")
FUNCTION = re.compile(r"exists|acos|asin|atan|abs|cos|exp|fix|fup|ln|round|sin|sqrt|tan")
CORRECT = "correct the expression or the values in it"
SYNTAX = 'LinuxCNC\'s manual, "G-code overview", says how expressions are written'


class Scope(Protocol):
    """What an expression reads."""

    def number(self, index: int) -> float:
        """The value of #index."""

    def named(self, name: str) -> float:
        """The value of #<name>."""

    def exists(self, parameter: int | str) -> bool:
        """What EXISTS tells."""


Node = Callable[[Scope], float]


@dataclass(frozen=True)
class Code:
    """A line as LinuxCNC reads it: lower case, no blanks, "(" for each comment. Character i of
    `text` is bytes starts[i] to stops[i] of the line; comments: where each one, and one behind ";",
    begins and ends."""

    text: str
    starts: list[int]
    stops: list[int]
    comments: list[tuple[int, int]]

    def span(self, first: int, stop: int) -> tuple[int, int]:
        """Offsets into the line of characters first to stop - 1, or of the last one."""
        if not self.starts:
            return 0, 0
        first = min(first, len(self.starts) - 1)
        return self.starts[first], self.stops[max(first, min(stop, len(self.stops)) - 1)]


def compact(line: bytes) -> Code:
    """Take a line's blanks and comments away. Raises Refusal for a comment that is not closed."""
    text: list[str] = []
    starts: list[int] = []
    stops: list[int] = []
    comments: list[tuple[int, int]] = []
    for piece in PIECE.finditer(line.lower()):
        first = piece[0][:1]
        if first in b" \t\r":
            continue
        if first in b"(;" and (first == b";" or piece.end() - piece.start() > 1):
            comments.append(piece.span())
            if first == b";":
                break
        elif first == b"(":
            raise Refusal(
                "a comment is opened and not closed in its line, or opened twice",
                "close it with ')'",
                *piece.span(),
            )
        # one character of the code for each byte that counts, so that `starts` leads back into the
        # line
        text.append(first.decode("latin-1"))
        starts.append(piece.start())
        stops.append(piece.end())
    return Code("".join(text), starts, stops, comments)


def whole(value: float, what: str) -> int:
    """The whole number that a value is. Raises Refusal where it is more than 0.0001 above one, as
    LinuxCNC does."""
    # up to 1e-4 below a whole number it is that one, and up to 1e-4 above
    low = math.floor(value)
    if value - low > 1 - WHOLE:
        return low + 1
    if value - low > WHOLE:
        raise Refusal(f"{what} is {value:.10g}, which is no whole number", CORRECT)
    return low


# -- operators and functions -----------------------------------------------------------------------


def _divide(a: float, b: float) -> float:
    if b == 0:
        raise Refusal(f"division of {a:.10g} by zero", "correct the divisor, or test it before")
    return a / b


def _modulo(a: float, b: float) -> float:
    if b == 0 or not math.isfinite(a):
        raise Refusal(f"{a:.10g} MOD {b:.10g} does not exist", CORRECT)
    # never below 0: -7 MOD 3 is 2
    rest = math.fmod(a, b)
    return rest + abs(b) if rest < 0 else rest


def _power(a: float, b: float) -> float:
    try:
        return math.pow(a, b)
    except (ValueError, OverflowError):
        raise Refusal(
            f"{a:.10g} ** {b:.10g} is no number, or none that a control holds", CORRECT
        ) from None


def _within(
    name: str, function: Callable[[float], float], low: float, high: float
) -> Callable[[float], float]:
    def checked(value: float) -> float:
        if not low <= value <= high:
            raise Refusal(f"{name} of {value:.10g} does not exist", CORRECT)
        return function(value)

    return checked


# 64 bits of mantissa: in doubles sin(30 deg) * 2 is 0.9999999999999999, and FIX of it 0
def _of_degrees(function: Callable[[Any], Any]) -> Callable[[float], float]:
    return lambda value: float(function(np.longdouble(value) * PI / 180))


def _degrees(radians: float) -> float:
    return float(np.longdouble(radians * 180.0) / PI)


BINARY: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "**": (5, _power),
    "*": (4, lambda a, b: a * b),
    "/": (4, _divide),
    "mod": (4, _modulo),
    "+": (3, lambda a, b: a + b),
    "-": (3, lambda a, b: a - b),
    "eq": (2, lambda a, b: float(abs(a - b) < EQUAL)),
    "ne": (2, lambda a, b: float(abs(a - b) >= EQUAL)),
    "gt": (2, lambda a, b: float(a > b)),
    "ge": (2, lambda a, b: float(a >= b)),
    "lt": (2, lambda a, b: float(a < b)),
    "le": (2, lambda a, b: float(a <= b)),
    "and": (1, lambda a, b: float(a != 0 and b != 0)),
    "or": (1, lambda a, b: float(a != 0 or b != 0)),
    "xor": (1, lambda a, b: float((a != 0) != (b != 0))),
}
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "abs": abs,
    "acos": _within("ACOS", lambda a: _degrees(math.acos(a)), -1, 1),
    "asin": _within("ASIN", lambda a: _degrees(math.asin(a)), -1, 1),
    "cos": _of_degrees(np.cos),
    "exp": _within("EXP", math.exp, -math.inf, 709.7),
    "fix": lambda a: float(math.floor(a)),
    "fup": lambda a: float(math.ceil(a)),
    "ln": _within("LN", math.log, 5e-324, math.inf),
    "round": _within(
        "ROUND",
        lambda a: float(math.trunc(a + math.copysign(0.5, a))),
        -LARGEST_ROUND,
        LARGEST_ROUND,
    ),
    "sin": _of_degrees(np.sin),
    "sqrt": _within("SQRT", math.sqrt, 0, math.inf),
    "tan": _of_degrees(np.tan),
}


# -- reading ---------------------------------------------------------------------------------------


class Reader:
    """Reads a line's code from `at` on; `at` stays behind the last thing read."""

    def __init__(self, code: Code, at: int = 0):
        self.code, self.text, self.at, self.depth = code, code.text, at, 0

    @property
    def next(self) -> str:
        """The character that follows, "": none."""
        return self.text[self.at : self.at + 1]

    def taken(self, mark: str) -> bool:
        """Whether this text follows; it is read then."""
        if not self.text.startswith(mark, self.at):
            return False
        self.at += len(mark)
        return True

    def need(self, mark: str, behind: str) -> None:
        """The same, but it must follow."""
        if not self.taken(mark):
            raise self.wrong(f"{mark!r} is missing {behind}")

    def wrong(self, message: str, advice: str = SYNTAX) -> Refusal:
        """A Refusal at the place where reading has come to."""
        if self.next == "(":
            message, advice = (
                message + ": a comment stands there",
                "put comments between words, not into them",
            )
        return Refusal(message, advice, *self.code.span(self.at, self.at + 1))

    def value(self) -> Node:
        """A number, an expression in brackets, a parameter or a function."""
        start = self.at
        found = NUMBER.match(self.text, start)
        if found:
            self.at = found.end()
            constant = float(found[0])
            if not math.isfinite(constant):
                raise Refusal(
                    f"a number of {len(found[0])} digits", CORRECT, *self.code.span(start, self.at)
                )
            return lambda scope: constant
        # the depth of Python's own stack, which a line of a thousand brackets would break
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.wrong(
                f"more than {DEEPEST} brackets, signs or # within each other", "calculate in steps"
            )
        try:
            if self.next in ("+", "-"):
                minus, value = self.next == "-", (self.taken(self.next), self.value())[1]
                return (lambda scope: -value(scope)) if minus else value
            if self.next == "[":
                return self.expression()
            if self.next == "#":
                return self.parameter()
            return self.function()
        finally:
            self.depth -= 1

    def expression(self) -> Node:
        """An expression and the brackets around it."""
        start = self.at
        self.need("[", "before the expression")
        value = self.chain(1)
        self.need("]", "behind the expression")
        span = self.code.span(start, self.at)

        def evaluate(scope: Scope) -> float:
            result = value(scope)
            if not math.isfinite(result):
                raise Refusal("the result is beyond what a control holds (1.8e308)", CORRECT, *span)
            return result

        return evaluate

    def chain(self, least: int) -> Node:
        """Values and operators of at least this rank between them."""
        start = self.at
        # Operators of rank `least` and above are taken here, each with what binds more than itself
        # at its right: 10 - 2 - 3 is 5, and 2 ** 3 ** 2 is 64.
        first, rest = self.value(), []
        while (found := OPERATOR.match(self.text, self.at)) and BINARY[found[0]][0] >= least:
            self.at = found.end()
            rank, operator = BINARY[found[0]]
            rest.append((operator, self.chain(rank + 1)))
        if not rest:
            return first
        span = self.code.span(start, self.at)

        def evaluate(scope: Scope) -> float:
            value = first(scope)
            for operator, operand in rest:
                right = operand(scope)
                try:
                    value = operator(value, right)
                except Refusal as e:
                    raise Refusal(e.message, e.advice, *span) from None
            return value

        return evaluate

    def function(self) -> Node:
        """A function of what its brackets hold."""
        start, found = self.at, FUNCTION.match(self.text, self.at)
        if not found:
            raise self.wrong("a value is missing, or is none")
        self.at, name = found.end(), found[0]
        if name == "exists":
            return self.existence()
        if self.next != "[":
            self.need("[", f"behind {name.upper()}")
        value = self.expression()
        if name == "atan":
            self.need("/", "behind ATAN[..]: it takes two values, ATAN[y]/[x]")
            # ATAN[y]/[x]: the slash is part of the function, no division
            below = self.expression()
            return lambda scope: _degrees(math.atan2(value(scope), below(scope)))
        function, span = FUNCTIONS[name], self.code.span(start, self.at)

        def evaluate(scope: Scope) -> float:
            argument = value(scope)
            try:
                return function(argument)
            except Refusal as e:
                raise Refusal(e.message, e.advice, *span) from None

        return evaluate

    def existence(self) -> Node:
        """EXISTS[#<name>] or EXISTS[#number]; the word has been read."""
        self.need("[#", "behind EXISTS: it asks for a parameter, EXISTS[#<name>]")
        if self.next == "<":
            name = self.name()
            self.need("]", "behind the parameter")
            return lambda scope: float(scope.exists(name))
        index = self.value()
        self.need("]", "behind the parameter")
        return lambda scope: float(scope.exists(whole(index(scope), "the number of a parameter")))

    def parameter(self) -> Node:
        """The value of a parameter."""
        start = self.at
        self.need("#", "before the parameter")
        name = self.name() if self.next == "<" else None
        literal = NUMBER.match(self.text, self.at) if name is None else None
        index = self.value() if name is None else None
        # #100, by far the most frequent: no value to work out
        fixed = (
            int(literal[0]) if literal and len(literal[0]) < 10 and literal[0].isdigit() else None
        )
        span = self.code.span(start, self.at)

        def evaluate(scope: Scope) -> float:
            try:
                if fixed is not None:
                    return scope.number(fixed)
                if name is not None:
                    return scope.named(name)
                assert index
                return scope.number(whole(index(scope), "the number of a parameter"))
            except Refusal as e:
                raise e.placed(*span) from None

        return evaluate

    def name(self) -> str:
        """What stands between < and >."""
        end = self.text.find(">", self.at)
        if end < 0 or "(" in self.text[self.at : end]:
            raise self.wrong("the name is not closed by '>'")
        name, self.at = self.text[self.at + 1 : end], end + 1
        return name
