"""Words of a macro block: what their value is, and how it is written as a plain number.

A value behind an address is rounded to what the address resolves, whole numbers to the nearest
(B-64484EN, "Custom macro", "Referencing variables"). Lengths get a decimal point: from a macro X#1
means #1 millimetres or inches on every control.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from postproc.nc.expand import Refusal
from postproc.nc.expand.fanuc_expressions import Formula
from postproc.nc.expand.fanuc_functions import Value, nearest
from postproc.nc.expand.fanuc_variables import Variables
from postproc.nc.expand.tracker import number
from postproc.nc.lexer import LONGEST_NUMBER

COUNTED = "GMTNOHDLPS"  # addresses whose values are whole numbers
LARGEST = 1e9
CALLS = {"M": ("97", "98", "99", "198", "2", "30"), "G": ("65", "66", "66.1", "67")}


@dataclass(frozen=True)
class Word:
    """A word: offsets into the raw text of its begin, of its number and behind it; digits: as
    written, "" where it must be calculated; place: offsets into the code."""

    letter: str
    start: int
    number: int
    stop: int
    digits: str
    value: Formula | None
    negative: bool
    place: tuple[int, int]

    def worth(self, variables: Variables) -> Value:
        """Its value now."""
        if self.value is None:
            if len(self.digits) > LONGEST_NUMBER:
                raise Refusal(
                    f"{self.letter} has {len(self.digits)} digits",
                    "write fewer digits",
                    *self.place,
                )
            return float(self.digits)
        try:
            value = self.value(variables)
        except Refusal as wrong:
            raise wrong.placed(*self.place) from None
        return -value if value is not None and self.negative else value

    def count(self, variables: Variables) -> int:
        """Its value as a whole number."""
        value = self.worth(variables)
        if value is None or abs(value) >= LARGEST or abs(value - round(value)) > 1e-6:
            what = "vacant" if value is None else f"{value:g}"
            raise Refusal(
                f"{self.letter} is {what}, not a whole number", "write a whole number", *self.place
            )
        return round(value)


def written(letter: str, value: float, variables: Variables, pointed: bool) -> str:
    """A value as the number behind an address; pointed: P is a factor here. Raises Refusal for what
    no control would take."""
    tracker = variables.tracker
    if abs(value) >= LARGEST:
        raise Refusal(
            f"{letter} would be {value:g}, more than any control takes (limit {LARGEST:g})",
            "look at the variables",
        )
    if (
        letter not in COUNTED
        or letter in tracker.setup.axes
        or letter in tracker.dialect.increments
    ):
        return number(value, variables.decimals(letter))
    if letter == "G":
        near = nearest(value * 10) / 10
        if abs(near - value) > 1e-6:
            raise Refusal(f"G{value:g} is no G code", "a G number has one decimal at most")
        return number(near, 1).removesuffix(".")
    # G51 P1.5: a factor; elsewhere P counts
    if letter == "P" and pointed:
        return number(value, variables.decimals(letter))
    if letter == "P" and variables.haas and abs(value - round(value)) > 1e-6:
        return number(value, variables.decimals(letter))  # seconds of a dwell
    # M, T, N, H, D, L: an address that counts
    return str(int(nearest(value)))


def rendered(
    raw: bytes, words: list[Word], variables: Variables, first: int, leave: Sequence[Word] = ()
) -> tuple[bytes, list[Word]]:
    """The text of a block from offset `first` on, with numbers in the place of expressions, and the
    words that are left: one whose variable is vacant goes, and so do those of `leave`."""
    out, at, kept = [], first, []
    # P is a factor there
    scales = any(word.letter == "G" and word.digits in ("51", "051") for word in words)
    for word in words:
        if word in leave:
            text = None
        elif word.digits:
            kept.append(word)
            continue
        else:
            value = word.worth(variables)
            text = None if value is None else _checked(word, value, variables, scales)
        # a vacant variable takes its letter along: X#1 is as if it were not written
        out.append(raw[at : word.start if text is None else word.number])
        if text is not None:
            out.append(text.encode())
            kept.append(word)
        at = word.stop
    return b"".join([*out, raw[at:]]), kept


def _checked(word: Word, value: float, variables: Variables, pointed: bool) -> str:
    try:
        text = written(word.letter, value, variables, pointed)
    except Refusal as wrong:
        wrong.start, wrong.stop = word.place
        raise
    # M#1 that comes out as M98 would be a call that nothing has looked for
    if text in CALLS.get(word.letter, ()):
        raise Refusal(
            f"{word.letter}{text} as the value of an expression",
            "write the code itself",
            *word.place,
        )
    return text
