"""Expressions and conditions of Okuma's user tasks.

Okuma OSP-P200L / P20L programming manual 5238-E, user task, as NC-PB/gEdit sums it up
(syntax-okuma.md): + - * /, brackets [ ], SIN COS TAN ATAN (degrees), SQRT ABS MOD ROUND FIX FUP; EQ
NE GT GE LT LE, AND OR NOT; EMPTY is a local variable without a value (MachinistFTW/OkumaMacros
asks so). Refused: ATAN2, DROUND, DFIX, DFUP, BIN, BCD, EOR, and whole numbers of negative ones,
for no text was found that says what they give.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import ClassVar

from postproc.nc.expand import cut
from postproc.nc.expand.klartext_formulas import DEEPEST, Formula, FormulaError, Unset

# V1 and VC1 are common variables, two letters or more a local one, V and letters the control's own
VARIABLE = r"VC?[0-9]+|[A-Z]{2}[A-Z0-9]*"
COMMON = re.compile(r"VC?[0-9]+")
COMPARED: dict[str, Callable[[float, float], bool]] = {
    "EQ": lambda a, b: a == b,
    "NE": lambda a, b: a != b,
    "GT": lambda a, b: a > b,
    "GE": lambda a, b: a >= b,
    "LT": lambda a, b: a < b,
    "LE": lambda a, b: a <= b,
}


def _whole(of: Callable[[float], float]) -> Callable[[float], float]:
    def taken(value: float) -> float:
        if value < 0:
            raise ValueError
        return float(of(value))

    return taken


def is_own(name: str) -> bool:
    """Whether a variable is the control's own."""
    return name.startswith("V") and not COMMON.fullmatch(name)


class Expression(Formula):
    """One expression at the beginning of a text. `parameters`: the values of variables by name."""

    token = re.compile(
        r"[ \t]*(?:([0-9]+\.?[0-9]*|\.[0-9]+)"
        r"|(?!(?:MOD|SIN|COS|TAN|ATAN2?|SQRT|ABS|ROUND|FIX|FUP|D(?:ROUND|FIX|FUP)|BIN|BCD)\["
        r"|(?:[EN][QE]|[GL][TE]|AND|E?OR|NOT|EMPTY)(?![A-Z0-9]))"
        rf"({VARIABLE})|([A-Z]+2?)|(.))"
    )
    brackets = "[]"
    levels = (("+", "-"), ("*", "/"))
    functions: ClassVar[dict[str, Callable[[float], float]]] = {
        **{name: Formula.functions[name] for name in ("SIN", "COS", "TAN", "ATAN", "SQRT", "ABS")},
        "ROUND": _whole(lambda v: math.floor(v + 0.5)),
        "FIX": _whole(lambda v: math.floor(cut(v))),
        "FUP": _whole(lambda v: math.ceil(cut(v))),
    }

    def first(self) -> tuple[float, int]:
        """The value, and where in the stripped text it ends. Raises FormulaError."""
        return self._worked_out(self._joined), self.ends[self.at - 1]

    def holds(self) -> tuple[bool, int]:
        """The same of a condition in brackets."""
        return self._worked_out(self._bracketed), self.ends[self.at - 1]

    def _either(self) -> bool:
        value = self._both()
        while self._next("OR"):
            # both sides are read whatever the first one says, for the text must be gone through to
            # its end
            value = self._both() or value
        return value

    def _both(self) -> bool:
        value = self._one_condition()
        while self._next("AND"):
            value = self._one_condition() and value
        return value

    def _one_condition(self) -> bool:
        self.deep += 1
        if self.deep > DEEPEST:
            raise FormulaError(f"{self.text[:40]!r} nests more than {DEEPEST} deep")
        try:
            return not self._one_condition() if self._next("NOT") else self._compared()
        finally:
            self.deep -= 1

    def _compared(self) -> bool:
        if (empty := self._empty()) is not None:
            return empty
        # [ may open an expression ([V1+2] GT 3) or conditions ([V1 GT 3] OR ..): read as the first,
        # and where that fails as the second
        begin = self.at
        try:
            left = self._joined()
            if how := self._next(*COMPARED):
                return COMPARED[how](left, self._joined())
        except FormulaError:
            if not self._in_brackets(begin):
                raise
        self.at = begin
        return self._bracketed()

    def _in_brackets(self, begin: int) -> bool:
        """Whether what stands there may be conditions in brackets of their own."""
        return begin < len(self.tokens) and self.tokens[begin][3] == "["

    def _bracketed(self) -> bool:
        if not self._next("["):
            raise FormulaError(f"{self.text[:40]!r} is no formula that is known here")
        value = self._either()
        self._close()
        return value

    def _empty(self) -> bool | None:
        """`PX EQ EMPTY`: whether a local variable has no value; None: it is no such question."""
        names = [t[1] or t[2] for t in self.tokens[self.at : self.at + 3]]
        if len(names) < 3 or names[2] != "EMPTY" or names[1] not in ("EQ", "NE"):
            return None
        name = names[0] or ""
        # only a local variable can be empty; nan: NOEX has set it, and nobody here knows to what
        if COMMON.fullmatch(name) or is_own(name) or math.isnan(self.parameters.get(name, 0.0)):
            raise Unset(name)
        self.at += 3
        return (name not in self.parameters) == (names[1] == "EQ")

    def _power(self) -> float:
        return self._factor()

    def _one(self) -> float:
        if self._next("MOD"):
            return self._remainder()
        return super()._one()

    def _remainder(self) -> float:
        """MOD[17,5]: of two numbers that are not negative."""
        parts = []
        for mark in "[,":
            if not self._next(mark):
                raise FormulaError(f"{self.text[:40]!r} is no formula that is known here")
            parts.append(self._joined())
        self._close()
        if min(parts) < 0:
            raise ValueError
        return math.fmod(*parts)

    def _held(self, parameter: str) -> float:
        value = self.parameters.get(parameter, math.nan)
        if math.isnan(value):
            raise Unset(parameter)
        return value
