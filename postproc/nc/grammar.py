"""How a dialect's text is cut into words, and the letters under which other spellings of a word are
handed on: what the lexer, the spellings and the dialects agree on."""

from __future__ import annotations

from functools import cached_property

from postproc.records import record


@record
class Grammar:
    """What is a word in a dialect's text, and what is none. Regular expressions are searched
    without regard to case, line by line; what their group holds stays."""

    semicolon: str = "comment"  # or "end of block": a line then holds several blocks
    slash_within: bool = False  # whether block delete takes what stands behind a "/" in a block
    parentheses: bool = True  # whether ( ) are comments
    keywords: tuple[str, ...] = ()  # words that are codes by themselves: TRANS, DIAMON
    spellings: tuple[tuple[str, str], ...] = ()  # ("CR=", "R"); "" for what moves nothing
    assigns: bool = False  # whether X=1 is X1, and X=IC(1) a distance
    checksums: bool = False  # whether *85 may end a line
    ignores: tuple[str, ...] = ()  # expressions of text that moves nothing: MSG("...")
    bare_letters: bool = False  # whether a letter may lack its number where it moves nothing: M84 E
    block_end: str = ""  # a character that ends a block, besides the line's end
    # Expressions of lines that run what only the machine has; each with 0, or with the number, from
    # 1, of the sentence that says why they can not be followed.
    macros: tuple[tuple[str, int], ...] = ()
    # Expressions of words that another letter stands for, in their group, and what that letter is:
    # L of Okuma's G103 is R.
    letters: tuple[tuple[str, str], ...] = ()
    homing: str = ""  # an expression of what homes all axes
    machine_variables: bool = (
        False  # whether F and S may be variables whose value only the machine knows
    )
    klartext: bool = False  # whether its statements are those of Heidenhain's Klartext

    @cached_property
    def shapes(self) -> dict[object, object]:
        """What the lexer has found of lines, by their text but for its digits."""
        return {}

    @cached_property
    def is_respelled(self) -> bool:
        """Whether words may be written in other ways than as a letter and a number."""
        patterns = (self.keywords, self.spellings, self.ignores, self.macros, self.homing)
        return any(
            (
                *patterns,
                self.letters,
                self.assigns,
                self.checksums,
                self.bare_letters,
                self.klartext,
            )
        )


PLAIN = Grammar()
KLARTEXT = Grammar(parentheses=False, klartext=True)
# Letters, beyond those of a program, under which other spellings are handed on
# (postproc.nc.spellings). None has the case bit 0x20, which is taken off.
KEYWORD_LETTER = 0x80  # a code that is a word: TRANS
PARAMETER = 0x81  # a parameter that moves nothing
MACRO = 0x82  # a line that only the machine can follow; its number is the reason
UNKNOWN_FEED = 0x83  # an F whose value only the machine knows
HOMING = 0x84
# Of the axes and centres AXES, in their order from here on: X=IC(), X=AC(), X without a number.
RELATIVE, ABSOLUTE, BARE = 0x90, 0xC0, 0xD0
AXES = "XYZABCUVWEIJK"
NUMBERLESS = (MACRO, UNKNOWN_FEED, HOMING, *range(BARE, BARE + len(AXES)))
SPELLED = bytes(
    (
        KEYWORD_LETTER,
        PARAMETER,
        *range(RELATIVE, RELATIVE + len(AXES)),
        *range(ABSOLUTE, ABSOLUTE + len(AXES)),
        *NUMBERLESS,
    )
)
