"""Formulas of Heidenhain's Q parameters.

TNC 640 user's manual, Klartext programming, "Entering formulas directly" and "Describing contours
with mathematical functions" (FN 0 to FN 8): + - * / ^, DIV, LEN, SQ, SQRT, SIN, COS, TAN, ASIN,
ACOS, ATAN, ABS, INT, FRAC, NEG, SGN, LN, EXP, PI; angles in degrees.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from typing import ClassVar, TypeVar

from postproc.nc.expand import Refusal, cut

TOKEN = re.compile(r"\s*(?:([0-9]*\.?[0-9]+)|Q([LR]?[0-9]+)|([A-Z]+)|(.))")
DEEPEST = 50
Worked = TypeVar("Worked")  # a number, or whether a condition holds


class FormulaError(Exception):
    """What can not be calculated."""

    advice = "write the number itself in its place"


class Unset(FormulaError):
    """A parameter that has no value."""


FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda v: math.sin(math.radians(v)),
    "COS": lambda v: math.cos(math.radians(v)),
    "TAN": lambda v: math.tan(math.radians(v)),
    "ASIN": lambda v: math.degrees(math.asin(v)),
    "ACOS": lambda v: math.degrees(math.acos(v)),
    "ATAN": lambda v: math.degrees(math.atan(v)),
    "SQ": lambda v: v * v,
    "SQRT": math.sqrt,
    "ABS": abs,
    "INT": lambda v: float(math.trunc(cut(v))),
    "FRAC": lambda v: v - math.trunc(cut(v)),
    "NEG": lambda v: -v,
    "SGN": lambda v: math.copysign(1.0, v) if v else 0.0,
    "LN": math.log,
    "EXP": math.exp,
}

OPERATORS: dict[str, Callable[[float, float], float]] = {
    "LEN": math.hypot,
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "DIV": operator.truediv,
}


class Formula:
    """One formula over parameters by name ("1", "L2"). `token`: its pieces: digits, a parameter, a
    name, a mark; `brackets`: what holds a part of it together; `levels`: its operators, those that
    bind least first."""

    token: ClassVar[re.Pattern[str]] = TOKEN
    brackets: ClassVar[str] = "()"
    levels: ClassVar[tuple[tuple[str, ...], ...]] = (("LEN",), ("+", "-"), ("*", "/", "DIV"))
    functions: ClassVar[dict[str, Callable[[float], float]]] = FUNCTIONS

    def __init__(self, text: str, parameters: dict[str, float]):
        self.parameters, self.at, self.deep = parameters, 0, 0
        # of each piece one of four is set: digits, parameter, name, mark
        found = list(self.token.finditer(text.strip().upper()))
        self.tokens = [m.groups() for m in found]
        self.ends = [m.end() for m in found]
        self.text = text.strip()

    def value(self) -> float:
        """Raises FormulaError."""
        result = self._worked_out(self._joined)
        if self.at < len(self.tokens):
            raise FormulaError(f"{self.text[:40]!r} is no formula that is known here")
        return result

    def _worked_out(self, of: Callable[[], Worked]) -> Worked:
        """What a part of it gives. Raises FormulaError where that is no number."""
        try:
            return of()
        except Refusal as wrong:
            error = FormulaError(wrong.message)
            error.advice = wrong.advice
            raise error from None
        except (ArithmeticError, ValueError):
            raise FormulaError(f"{self.text[:40]!r} has no value") from None

    def _next(self, *operators: str) -> str:
        """The next token if it is one of these operators, taken; else ""."""
        if self.at < len(self.tokens):
            _, _, name, mark = self.tokens[self.at]
            if (name or mark) in operators:
                self.at += 1
                return name or mark or ""
        return ""

    def _joined(self, level: int = 0) -> float:
        """Values with operators of this level or a higher one between, from left to right."""
        # behind the last level: powers, then signs, brackets, values
        if level == len(self.levels):
            return self._power()
        # operators of the levels above bind more and are taken first
        left = self._joined(level + 1)
        while mark := self._next(*self.levels[level]):
            left = OPERATORS[mark](left, self._joined(level + 1))
        return left

    def _power(self) -> float:
        # a sign and a function belong to what stands behind them, powers are taken from right to
        # left: -2^2 is 4, SQ 2^3 is 64, 2^3^2 is 512 (TNC7 81762x, "Rules for formulas")
        left = self._factor()
        return math.pow(left, self._power()) if self._next("^") else left

    def _factor(self) -> float:
        self.deep += 1
        if self.deep > DEEPEST:
            raise FormulaError(f"{self.text[:40]!r} nests more than {DEEPEST} deep")
        try:
            return self._one()
        finally:
            self.deep -= 1

    def _one(self) -> float:
        if sign := self._next("+", "-"):
            value = self._factor()
            return -value if sign == "-" else value
        if self._next(self.brackets[0]):
            value = self._joined()
            self._close()
            return value
        if self.at >= len(self.tokens):
            raise FormulaError(f"{self.text[:40]!r} ends too early")
        digits, parameter, name, _ = self.tokens[self.at]
        self.at += 1
        if digits:
            return float(digits)
        if parameter:
            return self._held(parameter)
        if name == "PI":
            return math.pi
        if name in self.functions:
            # of the next value alone, with brackets or without: SIN 30 * 2 is twice the sine of 30
            return self.functions[name](self._factor())
        raise FormulaError(f"{self.text[:40]!r} is no formula that is known here")

    def _close(self) -> None:
        """Raises FormulaError where no bracket is closed here."""
        if not self._next(self.brackets[1]):
            raise FormulaError(f"{self.text[:40]!r}: a parenthesis is not closed")

    def _held(self, parameter: str) -> float:
        """Its value. Raises Unset."""
        if parameter not in self.parameters:
            raise Unset(f"Q{parameter}")
        return self.parameters[parameter]
