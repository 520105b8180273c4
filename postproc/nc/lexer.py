"""Program text to words: every word with its letter, its exact decimal number and its place in the
text.

    line    = block { end-of-block block } newline
    block   = [ "/" ] { word } [ "/" word { word } ]    blanks and comments may stand anywhere
            between characters; a second "/" where the dialect knows it (Haas)
    word    = letter number
    number  = [ "+" | "-" ] digits [ "." [ digits ] ] | [ sign ] "." digits

The text is looked at as a column of bytes: one table lookup gives each its class, and everything
that is not a digit is a mark. A word is a letter's mark, perhaps a sign's, perhaps a point's, and
ends at the next mark. Numbers are read as whole mantissas, so nothing is rounded here. The lexer
does not know what a word means.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from postproc.errors import BlockFault
from postproc.flags import any_of
from postproc.nc.comments import without_comments
from postproc.nc.faults import ADVICE_NUMBER, advice_at, bare, what
from postproc.nc.grammar import NUMBERLESS, SPELLED, Grammar
from postproc.records import columns, record, replace

BLANK, DIGIT, SIGN, POINT, LETTER, SLASH, PERCENT, OTHER, END = range(9)
BLANKS = b" \t\r"
# Numbers of operators as arrays without axes: where a batch is one block an operator takes twice as
# long with a number.
DIGITS, SIGNS, POINTS, LETTERS, SLASHES, ENDS, MINUS, UPPER = (
    np.array(kind, np.uint8) for kind in (DIGIT, SIGN, POINT, LETTER, SLASH, END, ord("-"), 0xDF)
)
NEXT, ALL = np.array(1), np.array(8)
LONGEST_NUMBER = 18  # digits that fit an int64
WHOLE_DIGITS = 9  # before the point, where decimals beyond these 18 digits are dropped
LONGEST, EIGHT_BYTES = np.array(LONGEST_NUMBER), np.dtype("<u8")
THREE_ENDS, THREE = np.full(3, END, np.uint8), np.zeros(3, np.int64)
POWERS = 10 ** np.arange(LONGEST_NUMBER + 1)
# Eight digits in a word of eight bytes: pairs are joined, then fours, then all. Shift by their
# count.
# 2561 = 10 * 2**8 + 1: the byte above a digit gets ten times that digit and its own, and likewise
# 100 * 2**16 + 1 and 10000 * 2**32 + 1 for pairs and fours. The first digit lies lowest.
LOW_NIBBLES, PAIRS, FOURS = map(
    np.uint64, (0x0F0F0F0F0F0F0F0F, 0x00FF00FF00FF00FF, 0x0000FFFF0000FFFF)
)
TENS, HUNDREDS, MYRIADS = map(np.uint64, (2561, 6553601, 42949672960001))
EIGHT, SIXTEEN, THIRTY_TWO = map(np.uint64, (8, 16, 32))
SHIFT = (8 * (8 - np.arange(9)) % 64).astype(np.uint64)  # by 64 is not defined
BELOW = np.array([256**k - 1 for k in range(9)], np.uint64)  # the first characters of eight
NEEDS_NUMBER = np.ones(256, bool)
NEEDS_NUMBER[list(NUMBERLESS)] = False
# Texts of so many characters at most are remembered by their shape, and so many shapes at once.
SHORT, MOST_SHAPES = 256, 1024
NO_DIGITS = bytes.maketrans(b"0123456789", b"0" * 10)
OF_WORDS = ("letter", "mantissa", "decimals", "pointed", "start", "number", "stop")
OF_BLOCKS = ("block_start", "block_stop", "line", "skip")


@columns
class Words:
    """The words of a batch of whole lines. W words, B blocks; offsets count bytes of `text`.

    letter (W,) uint8 upper case; mantissa (W,) int64 and decimals (W,): the number is mantissa /
    10**decimals; pointed (W,) whether it has a decimal point; block (W,) ascending; start, number,
    stop (W,): the letter, the first character of the number, the end. block_start, block_stop, line
    (B,): the block without its end mark, and the line it stands in, from 0; skip (B,): begins with
    "/". tape: offset of the first "%", or -1; within: that of the first "/" within a block, or -1.
    fault: what is wrong with the block after the last one here, if anything is.
    """

    text: bytes
    letter: np.ndarray
    mantissa: np.ndarray
    decimals: np.ndarray
    pointed: np.ndarray
    block: np.ndarray
    start: np.ndarray
    number: np.ndarray
    stop: np.ndarray
    block_start: np.ndarray
    block_stop: np.ndarray
    line: np.ndarray
    skip: np.ndarray
    tape: int = -1
    within: int = -1
    fault: BlockFault | None = None

    @property
    def blocks(self) -> int:
        return len(self.block_start)

    @property
    def slashed(self) -> int:
        """The first block with a "/" before it or within, `blocks` where none has."""
        first = int(self.skip.argmax()) if any_of(self.skip) else self.blocks
        return first if self.within < 0 else min(first, _block_at(self, self.within))

    def part(self, first: int, stop: int, fault: BlockFault | None = None) -> Words:
        """Blocks first to stop - 1 alone; offsets still count bytes of the whole text."""
        low, high = (int(np.searchsorted(self.block, b)) for b in (first, stop))
        words = {name: getattr(self, name)[low:high] for name in OF_WORDS}
        blocks = {name: getattr(self, name)[first:stop] for name in OF_BLOCKS}
        return replace(self, **words, **blocks, block=self.block[low:high] - first, fault=fault)


@record
class Shape:
    """Texts that differ by their digits alone: the words of one of them, and of each number where
    it begins and ends, in a text without blanks, and its sign, -1 or 1."""

    words: Words
    numbers: list[tuple[int, int, int]]

    def of(self, text: bytes, code: bytes, within: int) -> Words:
        """The words of another one of these texts."""
        digits = code.translate(None, BLANKS)
        values = [
            sign * int(digits[begin:stop].replace(b".", b"") or 0)
            for begin, stop, sign in self.numbers
        ]
        # decimals may be written to (increments.py)
        changes = {"text": text, "mantissa": np.array(values, np.int64), "within": within}
        return replace(self.words, **changes, decimals=self.words.decimals.copy())


@lru_cache
def _classes(semicolon: str, spelled: bool, block_end: str) -> bytes:
    """The class of each of the 256 bytes, for bytes.translate."""
    table = bytearray([OTHER]) * 256
    classes = {
        BLANK: BLANKS,
        DIGIT: b"0123456789",
        SIGN: b"+-",
        POINT: b".",
        SLASH: b"/",
        PERCENT: b"%",
        END: b"\n",
    }
    classes[LETTER] = bytes(range(ord("A"), ord("Z") + 1)) + bytes(range(ord("a"), ord("z") + 1))
    if semicolon == "end of block":
        classes[END] += b";"
    classes[END] += block_end.encode()
    if spelled:
        classes[LETTER] += SPELLED
    for kind, characters in classes.items():
        for character in characters:
            table[character] = kind
    return bytes(table)


def lex(text: bytes, grammar: Grammar, drop: bool = False) -> Words:
    """Read a batch of whole lines; only its last line may lack the newline. `grammar` is the
    dialect's; `drop`: blocks that begin with "/" are not executed, so that it does not matter what
    stands in them.

    Never raises for bad text: the words before the first bad block come back with its `fault`.
    """
    code, spelled, within = without_comments(text, grammar, drop)
    if len(code) > SHORT:
        return _read(text, code, spelled, within, grammar)[0]
    # the length of the text: `code` has a newline at its end, whether the text has one or not
    shapes, key = grammar.shapes, (code.translate(NO_DIGITS), len(text), spelled)
    shape = shapes.pop(key, None)
    if isinstance(shape, Shape):
        shapes[key] = shape  # it is the last one that was asked for
        return shape.of(text, code, within)
    words, begin, whole, negative = _read(text, code, spelled, within, grammar)
    # words from the first fault or "%" on were cut off, but not from `begin` and `whole`
    if words.fault is None and words.tape < 0:
        while len(shapes) >= MOST_SHAPES:
            del shapes[next(iter(shapes))]
        stop, sign = begin + whole + words.pointed + words.decimals, np.where(negative, -1, 1)
        shapes[key] = Shape(
            replace(words, decimals=words.decimals.copy()),
            [*zip(begin.tolist(), stop.tolist(), sign.tolist(), strict=True)],
        )
    return words


def _read(
    text: bytes, code: bytes, spelled: bool, within: int, grammar: Grammar
) -> tuple[Words, np.ndarray, np.ndarray, np.ndarray]:
    """The words of a text, read from `code`, and of each number (W,) where it begins, as
    in Shape, how many digits it has before the point, and whether it is negative."""
    semicolon = grammar.semicolon
    byte = np.frombuffer(code, dtype=np.uint8)
    classes = _classes(semicolon, spelled, grammar.block_end)
    kind = np.frombuffer(code.translate(classes), dtype=np.uint8)
    offset = (kind != BLANK).nonzero()[0]  # of all that is not blank
    if len(offset) < len(kind):  # ten times as fast as taking them there
        kind = np.frombuffer(code.translate(classes, BLANKS), dtype=np.uint8)
        byte = np.frombuffer(code.translate(None, BLANKS), dtype=np.uint8)
    #   code    N 1 0 X - 4 . 5 Y 2 \n    The word X: its letter at 3, its number from 4, its digits
    #   offset  0 1 2 3 4 5 6 7 8 9 10    from 5 (begin), the point at 6, the next mark at 8 (stop):
    #   mark    ^     ^ ^   ^   ^   ^     whole 6 - 5, decimals 8 - 6 - 1, mantissa -45
    mark = (kind != DIGIT).nonzero()[0]
    # Three marks of padding, so that "the mark after the next" exists.
    mark_kind = np.concatenate([kind[mark], THREE_ENDS])
    mark = np.concatenate([mark, len(offset) + THREE])

    is_letter = mark_kind == LETTERS
    is_end = mark_kind == ENDS
    first = is_letter.nonzero()[0]
    here = mark[first]
    block_of_mark = np.add.accumulate(is_end, dtype=np.int64)
    block = block_of_mark[first]
    after, begin = first + NEXT, here + NEXT
    signed = (mark_kind[after] == SIGNS) & (mark[after] == begin)
    if any_of(signed):
        after, begin = after + signed, begin + signed
    pointed = mark_kind[after] == POINTS
    point = mark[after]
    after = after + pointed
    stop = mark[after]
    whole = point - begin  # without a point that is where the number stops
    decimals = stop - point - pointed
    digits = whole + decimals
    wrong = (digits < NEXT) | (digits > LONGEST)
    if any_of(wrong):
        decimals = _resolved(whole, decimals)
        digits = whole + decimals
        digits = np.where(NEEDS_NUMBER[byte[here]], digits, np.maximum(digits, 1))
        wrong = (digits < NEXT) | (digits > LONGEST)

    end = is_end[:-3].nonzero()[0]
    end_at = mark[end]
    block_first = np.zeros(len(end_at), np.int64)
    block_first[1:] = end_at[:-1] + 1
    first_kind = kind[block_first]
    skip = first_kind == SLASHES

    fault = None
    # Every letter, sign, point and slash that stands where it may is a mark of its own.
    right = len(first) + len(end) + np.count_nonzero(signed)
    right += np.count_nonzero(pointed) + np.count_nonzero(skip)
    if right < len(mark) - 3 or any_of(wrong) or any_of(first_kind == DIGITS):
        used = is_end | is_letter
        used[(first + NEXT)[signed]] = True
        used[(after - 1)[pointed]] = True
        used[np.searchsorted(mark, block_first[skip])] = True
        fault, tape = _first_fault(
            text, code, offset, kind, mark, mark_kind, used, block_of_mark, first, block, digits,
            block_first,
        )  # fmt: skip
    else:
        tape = -1

    end_offset, number = offset.take(end_at), here + NEXT
    block_start, line = np.zeros(len(end_at), np.int64), np.arange(len(end_at))
    block_start[1:] = end_offset[:-1] + 1
    if semicolon != "comment" or grammar.block_end:  # a line may hold several blocks
        (byte[end_at[:-1]] == ord("\n")).cumsum(out=line[1:])
    negative = byte[number] == MINUS
    words = Words(
        text=text,
        letter=byte[here] & UPPER,
        mantissa=_mantissa(byte, begin, whole, decimals, pointed, negative),
        decimals=decimals,
        pointed=pointed,
        block=block,
        start=offset.take(here),
        number=offset.take(number),
        stop=offset.take(stop - NEXT) + NEXT,
        block_start=block_start,
        block_stop=end_offset if code is text else np.minimum(end_offset, len(text)),
        line=line,
        skip=skip,
        tape=tape,
        within=within,
        fault=None,
    )
    if tape >= 0 and (fault is None or fault.block > _block_at(words, tape)):
        words = words.part(0, _block_at(words, tape))
    elif fault:
        words = words.part(0, fault.block, fault)
    return words, begin, whole, negative


def _block_at(words: Words, offset: int) -> int:
    return int(np.searchsorted(words.block_stop, offset, side="left"))


def _resolved(whole: np.ndarray, decimals: np.ndarray) -> np.ndarray:
    """(W,) the decimals that are read: none beyond 18 digits (0.053299492385786795).
    Controllers drop sooner: GRBL 1.1 keeps the first 8, read_float in nuts_bolts.c."""
    over = (whole + decimals > LONGEST) & (whole <= WHOLE_DIGITS)
    return np.where(over, LONGEST - whole, decimals) if np.count_nonzero(over) else decimals


def _mantissa(
    byte: np.ndarray,
    begin: np.ndarray,
    whole: np.ndarray,
    decimals: np.ndarray,
    pointed: np.ndarray,
    negative: np.ndarray,
) -> np.ndarray:
    """(W,) int64 the digits of each number as one integer, with its sign; the point is stepped
    over."""
    # Eight bytes from every place on, as one integer each: the first digit lies lowest.
    eight = np.ndarray(len(byte), EIGHT_BYTES, byte.tobytes() + bytes(8), strides=(1,))
    digits = whole + decimals
    # of 12.5X        text             1 2 . 5 X
    #                 text & before    1 2            before the point, and behind
    #                 text >> 8            5 X        it, one byte nearer: 125
    before = BELOW.take(whole, mode="clip")  # without a point these are all that count
    text = eight[begin]  # `take` would write them all out first
    value = _digits((text & before) | ((text >> EIGHT) & ~before), digits)
    long = (digits + pointed > ALL).nonzero()[0]
    if len(long):  # both sides of the point by themselves
        left, right = whole[long], decimals[long]
        behind = (begin + pointed)[long] + left
        value[long] = _digits(eight.take(begin[long]), left) * POWERS.take(right, mode="clip")
        value[long] += _digits(eight.take(behind, mode="clip"), right)
        for i in long[np.maximum(left, right) > 8]:
            number = byte[begin[i] : begin[i] + digits[i] + pointed[i]].tobytes().replace(b".", b"")
            value[i] = int(number) if len(number) <= LONGEST_NUMBER else 0
    return np.where(negative, -value, value) if any_of(negative) else value


def _digits(text: np.ndarray, count: np.ndarray) -> np.ndarray:
    """(W,) int64 of the first `count` digits, eight at most, of eight characters each: pairs, then
    fours, then eights are joined at once."""
    value = (text & LOW_NIBBLES) << SHIFT.take(count, mode="clip")
    value = (value * TENS) >> EIGHT
    value = ((value & PAIRS) * HUNDREDS) >> SIXTEEN
    value = ((value & FOURS) * MYRIADS) >> THIRTY_TWO
    if np.count_nonzero(count) < len(count):
        value[count == 0] = 0
    return value.view(np.int64)


def _first_fault(
    text: bytes,
    code: bytes,
    at: np.ndarray,
    kind: np.ndarray,
    mark: np.ndarray,
    mark_kind: np.ndarray,
    used: np.ndarray,
    block_of_mark: np.ndarray,
    first: np.ndarray,
    block: np.ndarray,
    digits: np.ndarray,
    block_first: np.ndarray,
) -> tuple[BlockFault | None, int]:
    """The earliest thing that is not a word, as a BlockFault, and the offset of the first "%" (-1:
    none)."""
    faults: list[tuple[int, int, str, str]] = []  # offset, block, message, advice
    tape = -1
    # the first that is no "%"; the limit is for files that hold nothing else
    for i in (~used[:-3]).nonzero()[0][:2000]:
        offset, number = int(at[mark[i]]), int(block_of_mark[i])
        if mark_kind[i] == PERCENT:
            if tape < 0:
                tape = offset
            continue
        faults.append(
            (
                offset,
                number,
                *what(text, code, offset, mark_kind[i] == SLASH, mark_kind[i] in (SIGN, POINT)),
            )
        )
        break
    for i in (digits < 1).nonzero()[0][:1]:
        offset = int(at[mark[first[i]]])
        faults.append((offset, int(block[i]), *bare(code, offset)))
    for i in (digits > LONGEST_NUMBER).nonzero()[0][:1]:
        offset = int(at[mark[first[i]]])
        faults.append(
            (
                offset,
                int(block[i]),
                f"the number has {int(digits[i])} digits (limit {LONGEST_NUMBER})",
                ADVICE_NUMBER,
            )
        )
    for i in (kind[block_first] == DIGIT).nonzero()[0][:1]:
        offset = int(at[block_first[i]])
        faults.append((offset, int(i), "a number without a letter", advice_at(code, offset)))
    if not faults:
        return None, tape
    offset, number, message, advice = min(faults)
    return BlockFault(number, message, advice, offset, offset + 1), tape
