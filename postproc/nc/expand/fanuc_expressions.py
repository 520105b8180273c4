"""Expressions of Fanuc's custom macro B: read once, worked out as often as their block runs.

    expression = sum [ comparison sum ]                       EQ NE GT GE LT LE
    sum        = product { ("+" | "-" | "OR" | "XOR") product }
    product    = factor { ("*" | "/" | "AND" | "MOD") factor }
    factor     = { "+" | "-" } operand
    operand    = number | variable | "[" expression "]" | function
    function   = name "[" expression { "," expression } "]" | "ATAN" "[" expression "]" "/" "["
               expression "]"
    variable   = "#" ( digits | variable | "[" expression "]" )

None is the vacant variable: 0 in arithmetic and in GT GE LT LE, equal to nothing but itself in EQ
and NE. A comparison gives 1 or 0, so that AND and OR join conditions. Sources: B-64304EN and
B-64484EN, "Custom macro"; Haas 96-8000, "Macros": ROUND in a word rounds to what the address
resolves.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Protocol

from postproc.nc.expand import Refusal
from postproc.nc.expand.fanuc_functions import (
    ARITHMETIC,
    FUNCTIONS,
    SHORT,
    Value,
    computed,
    index,
    to_places,
    turn,
)

DEEPEST = 40  # brackets in each other; the control itself allows 5
# the longer name first: the first that fits is taken
OPERATOR = re.compile(r"\*|/|\+|-|AND|AN|MOD|XOR|XO|OR|EQ|NE|GT|GE|LT|LE")
NUMBER = re.compile(r"\d+\.?\d*|\.\d+", re.ASCII)
NAME = re.compile(r"[A-Z]+2?", re.ASCII)
PRODUCT = ("*", "/", "AND", "MOD")
SUM = ("+", "-", "OR", "XOR")
COMPARE = ("EQ", "NE", "GT", "GE", "LT", "LE")


class Memory(Protocol):
    """What an expression asks for while it is worked out."""

    def read(self, number: int) -> Value: ...

    def places(self, letter: str) -> int: ...


Formula = Callable[[Memory], Value]


class Reader:
    """Reads expressions out of a block's code (upper case, without blanks and comments), from `at`
    on.

    letter: the address whose value is read, "" in a macro statement: ROUND differs. haas: Haas' own
    readings."""

    def __init__(self, code: str, at: int = 0, letter: str = "", haas: bool = False):
        self.code, self.at, self.letter, self.haas, self.depth = code, at, letter, haas, 0

    @property
    def next(self) -> str:
        """The character that follows, "": none."""
        return self.code[self.at : self.at + 1]

    def fault(self, message: str, advice: str = "", start: int = -1) -> Refusal:
        start = self.at if start < 0 else start
        return Refusal(message, advice, start, max(start + 1, min(self.at, len(self.code))))

    def value(self) -> Formula:
        """What may stand behind an address: a variable, or an expression in brackets."""
        return self.variable() if self.next == "#" else self.bracketed()

    def bracketed(self) -> Formula:
        """An expression with its brackets."""
        self._expect("[", "expressions stand in [ ]")
        inside = self._inside()
        self._expect("]", "a [ is not closed")
        return inside

    def variable(self) -> Formula:
        """#5, ##5, #[...]"""
        start, number = self.at, self.number_of_variable()
        place = (start, self.at)

        def work(m: Memory) -> Value:
            try:
                return m.read(index(number(m)))
            except Refusal as wrong:
                raise wrong.placed(*place) from None

        return work

    def number_of_variable(self) -> Formula:
        """Which variable is meant."""
        start = self.at
        self._expect("#", "a variable begins with #")
        digits = NUMBER.match(self.code, self.at)
        if digits and digits[0].isdigit() and len(digits[0]) < 10:
            self.at = digits.end()
            number = float(digits[0])
            return lambda m: number
        if self.next == "[":
            return self.bracketed()
        if self.next == "#":
            self._deeper()
            inner = self.variable()
            self.depth -= 1
            return inner
        raise self.fault(
            "# without the number of a variable",
            "names of variables are not read: #100, #[#1+2]",
            start,
        )

    def expression(self) -> Formula:
        """A sum, or two of them compared."""
        left = self._sum()
        start, name = self.at, self._operator(COMPARE)
        if not name:
            return left
        right = self._sum()
        if self._operator(COMPARE):
            raise self.fault(
                "two comparisons in one pair of brackets",
                "[[#1 GT 0] AND [#2 GT 0]] joins them",
                start,
            )
        if name in ("EQ", "NE"):
            wanted = name == "EQ"
            # the vacant one equals itself alone
            return lambda m: float((left(m) == right(m)) is wanted)
        # GT and its kin take a vacant variable as 0, unlike EQ and NE
        return applied(name, ARITHMETIC[name], [left, right], (start, self.at))

    def _inside(self) -> Formula:
        self._deeper()
        inside = self.expression()
        self.depth -= 1
        return inside

    def _deeper(self) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.fault(
                f"brackets nested deeper than {DEEPEST}",
                "the control reads 5 levels: use variables between",
            )

    def _sum(self) -> Formula:
        return self._chain(SUM, self._product)

    def _product(self) -> Formula:
        return self._chain(PRODUCT, self._factor)

    def _chain(self, operators: tuple[str, ...], operand: Callable[[], Formula]) -> Formula:
        """Operands joined from left to right; a loop, so that a long line needs no deep stack."""
        first, rest = operand(), []
        start = self.at
        while name := self._operator(operators):
            # with its place, so that a division by zero is shown where it stands
            rest.append((name, operand(), (start, self.at)))
            start = self.at
        if not rest:
            return first

        def work(m: Memory) -> Value:
            # None, the vacant variable, is 0 in arithmetic
            value = first(m) or 0.0
            for name, right, place in rest:
                value = computed(name, ARITHMETIC[name], (value, right(m) or 0.0), place)
            return value

        return work

    def _factor(self) -> Formula:
        negative = False
        while self.next in ("+", "-"):
            negative ^= self.next == "-"
            self.at += 1
        operand = self._operand()
        # from 0, so that a 0 does not become the -0.0 that a minus alone would give
        return (lambda m: 0.0 - (operand(m) or 0.0)) if negative else operand

    def _operand(self) -> Formula:
        if self.next in ("#", "["):
            return self.value()
        found = NUMBER.match(self.code, self.at)
        if found:
            self.at = found.end()
            number = float(found[0])
            if not math.isfinite(number):
                raise self.fault(
                    "a number too large for any control", "write fewer digits", found.start()
                )
            return lambda m: number
        return self._function()

    def _second_side(self, name: str, start: int) -> Formula:
        """Behind ATAN[ ]: /[ ]."""
        if name == "ATAN" and self.haas:
            raise self.fault(
                "ATAN[ ]/[ ] may be a quotient on a Haas; on a Fanuc the two are sides",
                "write ATAN2[ ]/[ ] for sides, [ATAN[ ]]/[ ] for a quotient",
                start,
            )
        self.at += 1
        return self.bracketed()

    # Whole: the grammar of a call, and its four exceptions.
    def _function(self) -> Formula:
        start, found = self.at, NAME.match(self.code, self.at)
        name = SHORT.get(found[0], found[0]) if found else ""
        if not found or name not in FUNCTIONS:
            what = f"{found[0]!r} is no function" if found else "a value is missing"
            raise self.fault(what, "functions: " + ", ".join(FUNCTIONS), start)
        self.at = found.end()
        self._expect("[", f"{name} takes its argument in [ ]")
        arguments = [self._inside()]
        while self.next == ",":
            self.at += 1
            arguments.append(self._inside())
        self._expect("]", "a [ is not closed")
        if name in ("ATAN", "ATAN2") and self.code[self.at : self.at + 2] == "/[":
            arguments.append(self._second_side(name, start))
        # ATAN[1]/[2] and ATAN[1,2] are of two sides, ATAN[1] is the angle of a tangent
        wanted = 2 if name in ("POW", "ATAN2") or (len(arguments) == 2 and name == "ATAN") else 1
        if len(arguments) != wanted:
            raise self.fault(
                f"{name} takes {wanted} values, not {len(arguments)}",
                "as in SIN[30], POW[2,3], ATAN[1]/[2]",
                start,
            )
        function = turn if wanted == 2 and name == "ATAN" else FUNCTIONS[name]
        if name == "ASIN" and self.haas:
            function = lambda x: math.degrees(math.asin(x))  # noqa: E731
        if name == "ROUND" and self.letter:
            # X[ROUND[#1]] rounds to the least increment of X, #2=ROUND[#1] to whole numbers
            letter, one = self.letter, arguments[0]
            return lambda m: to_places(one(m) or 0.0, m.places(letter))
        return applied(name, function, arguments, (start, self.at))

    def _operator(self, wanted: tuple[str, ...]) -> str:
        found = OPERATOR.match(self.code, self.at)
        name = {"AN": "AND", "XO": "XOR"}.get(found[0], found[0]) if found else ""
        if not found or name not in wanted:
            return ""
        self.at = found.end()
        return name

    def _expect(self, character: str, otherwise: str) -> None:
        if self.next != character:
            raise self.fault(otherwise, f"{character!r} is expected here")
        self.at += 1


def applied(
    name: str, function: Callable[..., float], arguments: list[Formula], place: tuple[int, int]
) -> Formula:
    """A function or an operator on formulas."""
    return lambda m: computed(name, function, [argument(m) or 0.0 for argument in arguments], place)
