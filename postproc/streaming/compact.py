"""The same words in fewer bytes: no blanks, no N, no zeros that say nothing, no word that is in
force already.

A word is left out only where RS274/NGC keeps it (NIST RS274/NGC 3, 3.4: modal groups; F and S hold)
and this line's own codes leave it in force. An axis word is left out where the axis stands at that
very number already, in absolute distance, and another axis word remains. Anything this module does
not know goes as it is, and all memory with it. Only for controllers of that language: Marlin wants
its G1 in every line and M109 its S, and X10. of a Fanuc without its point is 10 increments.
"""

from __future__ import annotations

import re

WORD = re.compile(rb"([A-Z])([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))")
LINE = re.compile(rb"(?:[A-Z][-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))*")
BLANK = re.compile(rb"[ \t\r]+")
AXES = b"XYZABCUVW"
STRAIGHT = (b"0", b"1")
MOTIONS = (b"0", b"1", b"2", b"3")
HARMLESS = {b"17", b"18", b"19", b"40", b"61", b"61.1", b"64", b"80", b"90", b"91", b"91.1", b"94"}
# M words behind which the axes stand where they stood, and modes hold: spindle and coolant. A
# change of tools (M6), a pause, a call or a macro may move them.
QUIET = {b"3", b"4", b"5", b"7", b"8", b"9"}
Word = tuple[bytes, bytes]  # letter, value

#   N10 G1 X+010.500 Y2.0 F600.   G1X10.5Y2F600
#   N20 G1 X10.5 Y3.0 F600.       Y3              the motion, F and X are in force
#   N30 G1 X10.5 Y3.0             X10.5           one axis stays: without any it is no motion
#   N40 G91 G1 X10.5 Y3.0         G91G1X10.5Y3    now each number is a distance: none is left out


class Compact:
    """One program's lines in order. absolute, per_minute: whether G90 and G94 are known to be in
    force at the start."""

    def __init__(self, absolute: bool = False, per_minute: bool = True):
        self.absolute, self.per_minute = absolute, per_minute
        self._forget()

    def _forget(self) -> None:
        self.motion = b""
        self.feed = self.speed = b""
        self.at: dict[bytes, bytes] = {}

    def line(self, text: bytes) -> bytes:
        """A line without comments, shorter."""
        bare = BLANK.sub(b"", text).upper()
        if not LINE.fullmatch(bare):
            self._forget()
            self.absolute = False
            return text if text.startswith(b"$") else bare
        words, named, others = _words(bare)
        plain = others <= HARMLESS and len(named) <= 1
        self._modes(others)
        motion = (named or [self.motion])[0] if plain and b"80" not in others else b""
        kept = self._kept(words, motion) if plain and not others else words
        self._remember(words, motion, plain)
        return b"".join(letter + value for letter, value in kept)

    def _modes(self, others: set[bytes]) -> None:
        """G90, G91 and G93 to G95."""
        self.per_minute = not others & {b"93", b"95"} and (self.per_minute or b"94" in others)
        self.absolute = b"90" in others or (self.absolute and b"91" not in others)

    def _kept(self, words: list[Word], motion: bytes) -> list[Word]:
        """Words that must be written, of a line whose codes are motions alone."""
        moves = [(x, v) for x, v in words if x in AXES]
        still = self._still(moves) if motion in STRAIGHT and self.absolute else set()
        said = {(b"F", self.feed), (b"S", self.speed), (b"G", self.motion if moves else b"")}
        return [word for word in words if word not in said and word[0] not in still] or words

    def _still(self, moves: list[Word]) -> set[bytes]:
        """Axes that are where the line sends them; one is always named."""
        still = {x for x, v in moves if self.at.get(x) == v}
        if len(still) == len(moves):
            still.discard(moves[0][0] if moves else b"")
        return still

    def _remember(self, words: list[Word], motion: bytes, plain: bool) -> None:
        if not plain:
            self._forget()
            return
        self.motion = motion
        for letter, value in words:
            if letter == b"F":
                self.feed = value if self.per_minute else b""
            elif letter == b"S":
                self.speed = value
            elif letter == b"M":
                self.speed = b""
            elif letter in AXES and motion:
                self.at[letter] = value
        if any(letter == b"M" and value not in QUIET for letter, value in words):
            self._forget()
            self.absolute = False
        if not self.absolute:
            self.at.clear()


def _words(bare: bytes) -> tuple[list[tuple[bytes, bytes]], list[bytes], set[bytes]]:
    """Letter and value of all words but N, the G codes of motions, and the other ones."""
    words = [(letter, number(value)) for letter, value in WORD.findall(bare) if letter != b"N"]
    codes = [value for letter, value in words if letter == b"G"]
    return words, [c for c in codes if c in MOTIONS], set(codes) - set(MOTIONS)


def number(text: bytes) -> bytes:
    """A decimal number without sign +, without zeros before or behind that say nothing."""
    sign, digits = (b"-", text[1:]) if text.startswith(b"-") else (b"", text.lstrip(b"+"))
    whole, _, part = digits.partition(b".")
    whole, part = whole.lstrip(b"0"), part.rstrip(b"0")
    if not whole and not part:
        return b"0"
    return sign + whole + (b"." + part if part else b"")
