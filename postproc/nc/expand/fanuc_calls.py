"""Calls of Fanuc's subprograms and macros: what they say, what they hand over, and what runs then.

Sources: B-64304EN and B-64484EN, "Custom macro", "Simple call (G65)", "Modal call (G66)";
"Subprogram (M98, M99)"; Haas 96-8000, "Macros", "M97".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from postproc.nc.expand import Program, Refusal
from postproc.nc.expand.fanuc_blocks import Kind
from postproc.nc.expand.fanuc_functions import Unknown, Value
from postproc.nc.expand.fanuc_programs import Section, Source
from postproc.nc.expand.fanuc_variables import Variables
from postproc.nc.expand.fanuc_words import Word

# Argument assignment I: letter to local variable. Of I, J, K further sets follow: assignment II.
#   I    A #1  B #2  C #3  I #4  J #5  K #6  D #7  E #8  F #9  H #11  M #13  Q #17 .. Z #26
#   II   A #1  B #2  C #3  I #4  J #5  K #6  I #7  J #8  K #9  I #10 ..              K #33
ARGUMENTS = {
    **dict(zip("ABC", (1, 2, 3), strict=True)),
    **dict(zip("DEF", (7, 8, 9), strict=True)),
    **dict(zip("HM", (11, 13), strict=True)),
    **dict(zip("QRSTUVWXYZ", range(17, 27), strict=True)),
}
COUNTS = "DEFHMST"  # arguments that are no lengths: without a decimal point they count units


@dataclass
class Frame:
    """A program that runs. at: the entry next in turn; start: where each run of it begins; left:
    further runs; local: its variables #1 to #33; modal: the modal calls to go back to behind it,
    None: those in force then."""

    source: Source
    section: Section
    at: int
    start: int
    left: int
    local: dict[int, Value | Unknown]
    modal: list[Modal] | None = None


@dataclass(frozen=True)
class Modal:
    """A macro that is called behind every motion. Its arguments are set once, by G66."""

    source: Source
    section: Section
    times: int
    local: dict[int, Value | Unknown]


class Library:
    """Finds programs by their O number: in the texts at hand, then where the caller's library finds
    them."""

    def __init__(self, program: Program, semicolon: str, haas: bool):
        self.program, self.semicolon, self.haas = program, semicolon, haas
        self.found: dict[int, tuple[Source, Section] | None] = {}

    def find(self, number: int, *sources: Source) -> tuple[Source, Section] | None:
        """The program in one of the texts, or in the library; None: nowhere."""
        for source in sources:
            section = source.section(number)
            if section:
                return source, section
        if number not in self.found:
            self.found[number] = self._fetch(number)
        return self.found[number]

    def sources(self) -> list[Source]:
        """The texts found so far."""
        return [found[0] for found in self.found.values() if found]

    def _fetch(self, number: int) -> tuple[Source, Section] | None:
        text = self.program.library(str(number))
        if text is None:
            return None
        file = Program(f"O{number}", text)
        source = Source(file, self.semicolon, self.haas, file.name)
        section = source.section(number)
        if section is None and source.sections[0].number < 0:
            section = source.sections[0]
            section.number = number
        return (source, section) if section else None


def arguments(words: list[Word], variables: Variables) -> dict[int, Value | Unknown]:
    """Local variables that the words behind G65 or G66 set: assignment I, and II where I, J, K come
    again.

    A vacant argument leaves its variable vacant. Without a decimal point a length counts least
    increments where the control reads coordinates so (B-63684EN, "Position of the decimal
    point")."""
    local: dict[int, Value | Unknown] = {}
    sets, last = 0, "K"
    for word in words:
        if word.letter in "IJK":
            # a set ends where the letter is not behind the one before: J5 K6 are of one set, J5 I6
            # of two
            sets, last = sets + (word.letter <= last), word.letter
            if sets > 10:
                raise Refusal(
                    f"{sets} sets of I, J, K", "a call takes 10 of them (#4 to #33)", *word.place
                )
            variable = 3 * sets + "IJK".index(word.letter) + 1
        elif word.letter in ARGUMENTS:
            variable = ARGUMENTS[word.letter]
        else:
            raise Refusal(
                f"{word.letter} can not hand over a value",
                "G, L, N, O and P are no arguments",
                *word.place,
            )
        value = word.worth(variables)
        # X1000 hands over 1.0 where whole numbers count 0.001 mm, X1000. hands over 1000; of F or S
        # a number is what it says
        pointed = not word.digits or "." in word.digits or word.letter in COUNTS
        if value is not None and not pointed and variables.tracker.counts:
            value = float(f"{value:.0f}e-{variables.places(word.letter)}")
        local[variable] = value
    return local


def word_of(words: list[Word], letter: str) -> Word | None:
    """The first word with this letter."""
    return next((word for word in words if word.letter == letter), None)


def times(words: list[Word], variables: Variables) -> int:
    """How often a call runs its program: L, or once."""
    word = word_of(words, "L")
    if word is None or word.worth(variables) is None:
        return 1
    count = word.count(variables)
    if count < 1:
        raise Refusal(
            f"the call is repeated {count} times",
            "L1 calls once; leave the block out to call never",
            *word.place,
        )
    return count


def called(
    words: list[Word], letter: str, variables: Variables, what: str, place: tuple[int, int]
) -> int:
    """The whole number behind a letter of a call. Raises Refusal where it is missing."""
    word = word_of(words, letter)
    if word is None or word.worth(variables) is None:
        raise Refusal(f"{what} without {letter}", f"{letter} says what is called", *place)
    return word.count(variables)


def subprogram(
    words: list[Word],
    variables: Variables,
    what: str,
    place: tuple[int, int],
    exists: Callable[[int], bool],
) -> tuple[int, int]:
    """Number of the program that M98 calls, and how often: L, or on a Fanuc the digits before the
    last four of P."""
    number, count = called(words, "P", variables, what, place), times(words, variables)
    # P51002 runs O1002 five times, unless there is an O51002
    if number > 9999 and not variables.haas and word_of(words, "L") is None and not exists(number):
        count, number = divmod(number, 10000)
    return number, count


def label_of(value: Value) -> int:
    """The N number that GOTO names. Raises Refusal for what is none."""
    number = round(value or 0.0)
    if value is None or abs(value - number) > 1e-6 or not 0 <= number < 10**9:
        raise Refusal(
            f"GOTO {'a vacant variable' if value is None else f'{value:g}'}", "N numbers are whole"
        )
    return number


def text_of(number: int, frame: Frame, library: Library, main: Source) -> list[bytes] | None:
    """What a cycle reads as its shape: the blocks from an N number of the program that runs, or of
    another program, up to M99; None: nowhere."""
    source, section = frame.source, frame.section
    start = source.find(section, number, frame.at)
    if start < 0:
        found = library.find(number, source, main)
        if found is None:
            return None
        source, section = found
        start = section.start
    texts: list[bytes] = []
    for at in range(start, section.stop):
        if source.special[at] and source.block(at).kind is Kind.RETURN:
            break
        texts.append(source.texts[at])
    return texts
