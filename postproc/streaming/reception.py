"""A program that a control sends (its PUNCH or SEND key): what is the program, when it has ended,
and whether a byte was damaged.

Rules: Haas, mill operator's manual (June 1999), RS-232: two `%` stand about what is sent, with DC
CODES a DC2 comes first and a DC4 last; lines end with CR LF or LF. Fanuc's punch interface is alike
(general knowledge, unverified on hardware). With 7 bits and a parity the line is read as 8 bits, so
that each byte's parity is looked at here: a serial port that checks it may drop the byte, or pass
it.

    DC2  NUL NUL ..  %  CR LF  O1234 CR LF  N10 G0 X1. CR LF  ..  %  NUL NUL ..  DC4
         leader      |<----------------- the program ----------->|   trailer
"""

from __future__ import annotations

from postproc import intake

DC1, DC2, DC3, DC4 = 0x11, 0x12, 0x13, 0x14
SKIPPED = {0x00, 0x7F, DC1, DC2, DC3}  # leader and trailer of tapes, and what steers a reader
ODD = bytes(bin(value).count("1") & 1 for value in range(256))


class Reception:
    """receive() what comes. seven: bytes have 7 bits; parity: "E", "O", or "N": none is looked at.

    begun: the program has; done: it is whole; fault: what is wrong with it, in words, ""; size,
    lines: bytes and lines of it so far."""

    def __init__(self, seven: bool = True, parity: str = "N"):
        self.seven, self.parity = seven, parity
        self.started = self.done = False
        self.fault = ""
        self._text = bytearray()

    @property
    def size(self) -> int:
        return len(self._text)

    @property
    def lines(self) -> int:
        return self._text.count(b"\n")

    @property
    def text(self) -> bytes:
        """The program, lines ended by LF."""
        return bytes(self._text)

    def receive(self, data: bytes) -> None:
        """Bytes as they came; they may be cut anywhere."""
        for value in data:
            if self.done or self.fault:
                return
            self._take(value)

    def _is_nothing(self, letter: int, wrong: bool) -> bool:
        """What a plug makes, and a tape's leader. wrong: its parity is."""
        if letter in SKIPPED or letter in (0x0D, DC4):
            return True
        # Before the first letter anything goes: a plug that is put in makes bytes of its own.
        return not self.started and (wrong or not 0x20 < letter < 0x7F)

    def _take(self, value: int) -> None:
        here = f"line {self.lines + 1} of what came in"
        # ones in all 8 bits, parity bit included: an odd number of them is right for O, an even one
        # for E
        wrong = self.parity != "N" and ODD[value] != (self.parity == "O")
        letter = value & 0x7F if self.seven else value
        if wrong and self.started:
            self.fault = (
                f"{here}: a byte with a wrong parity ({value:#04x}): it was damaged on the way, or"
                " the frame is another"
            )
        elif letter == DC4 and self.started:
            self._closed("DC4")
        elif self._is_nothing(letter, wrong):
            return
        elif letter not in b"\n\t" and not 0x20 <= letter < 0x7F:
            self.fault = (
                f"{here}: byte {value:#04x} is no letter of a program: it was damaged on the way,"
                " or frame or speed are others"
            )
        else:
            self._add(letter)

    def _add(self, value: int) -> None:
        self.started = True
        self._text.append(value)
        if len(self._text) > intake.RECEIVED:
            self.fault = (
                f"more than {intake.RECEIVED:,} bytes came in: no program is as long as that"
            )
        # a % that begins a line, and is not the first one: only that one ends the program
        if value == ord("%") and self.lines and self._text.endswith(b"\n%"):
            self._text += b"\n"
            self._closed("%")

    def _closed(self, how: str) -> None:
        """% or DC4, where the program can have ended with it."""
        opened = self._text.startswith(b"%")
        if how == "%" and not opened:
            self.fault = "it ends with %, and the % before it is missing: its beginning may be, too"
        elif how == "DC4" and self._text.startswith(b"%\n"):
            self.fault = (
                f"the control has stopped (DC4) after {self.lines} lines, and the % that ends the"
                " program is missing"
            )
        else:
            self._whole()

    def _whole(self) -> None:
        self.done = True
        if not self._text.endswith(b"\n"):
            self._text += b"\n"

    def silent(self, anyhow: bool) -> None:
        """Nothing came for a while. anyhow: that is how this control ends."""
        if not self.started or self.done or self.fault:
            return
        if anyhow:
            self._whole()
        else:
            self.fault = (
                f"it fell silent after {self.lines} lines, and no % or DC4 has ended the program:"
                " the rest of it may be missing"
            )
