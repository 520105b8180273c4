"""What is wrong with a text that is no plain block, and the way out: one sentence for each thing
that people write."""

from __future__ import annotations

import re

from postproc.expressions import expression

ADVICE_NUMBER = "no control resolves that: write fewer digits"
ADVICE_EXPRESSION = (
    "variables, expressions, O-words and macro statements run with --expand, which writes them out"
    " as plain blocks; or is it for another control? --dialect"
)
ADVICE_POLAR = (
    "LinuxCNC's polar words @ and ^ run with --expand, which writes X and Y; or is it for another"
    " control? --dialect"
)
ADVICE_CORNER = "--expand writes ,R and ,C between straight lines out; else write the corner out"
ADVICE_NO_CORNER = "corner rounding and chamfers (,R ,C ,A) are not followed: write the corner out"
ADVICE_NO_LANGUAGE = (
    "variables, expressions and statements of this control are not run: let the CAM program write"
    " plain blocks; or is it for another control? --dialect"
)
BEHIND_END = (
    "blocks behind the end of the program (M2, M30, '%') stay as they are, and a sender sends them"
    " on: put the end last"
)
AXIS_WORD = expression(rb"(?m)^[^(;\n]*?[A-CXYZ][ \t]*[-+]?[0-9.]", re.IGNORECASE)
STATEMENT = expression(
    rb"[#\[\]=$<>\"]|\b(?:IF|THEN|GOTO[FBCS]?|WHILE|DO|END[A-Z]*|SUB|CALL|REPEAT|UNTIL|LOOP|FOR|DEF|PROC|CASE|RETURN|ELSE|MCALL|"
    rb"CYCLE[0-9]+)(?![A-Z])|\bO<",
    re.IGNORECASE,
)
ARGUMENTS = expression(rb"\([^()\n]*\)(?![0-9.])")  # of a call, behind its name: L140(2)
CALL = expression(rb"([A-Z_]{2}[A-Z_0-9]*)[ \t]*\(", re.IGNORECASE)  # of a subprogram by name
STATEMENT_WORD = expression(
    rb"(?:IF|THEN|GOTO[FBCS]?|WHILE|DO|END[A-Z]*|SUB|CALL|REPEATB?|UNTIL|LOOP|FOR|DEF|PROC|EXTERN|CASE|RETURN|RET|ELSE|ELSEIF|MCALL|"
    rb"CYCLE[0-9]+|BREAK|CONTINUE)(?![A-Za-z])|O[ \t]*<[^>\n]*>",
    re.IGNORECASE,
)
SIEMENS_WORDS = (  # plain to read, and not followed: message and advice
    (
        expression(rb"(FB)[ \t]*=", re.IGNORECASE),
        "is a feed for one block",
        "--expand writes F in its place, and the F that held before it behind it",
    ),
    (
        expression(rb"(POS[AP]?)[ \t]*\[", re.IGNORECASE),
        "moves an axis by itself, beside the path",
        "write a G0 or G1 of that axis in its place",
    ),
    (
        expression(rb"(LEAD|TILT)[ \t]*=", re.IGNORECASE),
        "leans the tool from the surface's normal",
        "let the CAM program write A3 B3 C3, or the rotary axes",
    ),
)
ORIENTATION = expression(rb"(?:.*[^A-Z0-9_$])?[ABC]([2-5])[ \t]*", re.IGNORECASE)
LETTER_O = expression(
    rb"[0-9.][ \t]*[Oo](?=[0-9.\s]|\Z)|[A-NP-Za-np-z][ \t]*-?[ \t]*[Oo](?=[0-9.\s]|\Z)"
)
POLAR = expression(rb"[@^][ \t]*[-+.0-9]")
CORNER = expression(rb",[ \t]*([RCrc]|[Aa])")
COMMA = expression(rb"[A-Z=][ \t]*[-+]?[0-9]+,[0-9]", re.IGNORECASE)  # X5,5, and no list: (5,5)
TWO_POINTS = expression(rb"[0-9]*\.[0-9]*\.")
ANGLES = (
    "the tool's direction by angles (A2 B2 C2) or by the surface's normal is not followed",
    "let the CAM program write A3 B3 C3, or the rotary axes",
)
ORIENTATIONS = {
    b"3": (
        "A3 B3 C3 are the tool's direction, not places of axes",
        "--expand writes the rotary axes in their place",
    )
}
LONE_RETURN = expression(rb"\r(?![\r\n]|\Z)")
LONE = 0x1D  # stands for a lone carriage return in what the lexer looks at


def line_at(text: bytes, offset: int) -> bytes:
    """The line that an offset lies in."""
    start = text.rfind(b"\n", 0, offset) + 1
    stop = text.find(b"\n", offset)
    return text[start : stop if stop >= 0 else len(text)]


def line_until(text: bytes, offset: int) -> bytes:
    """The line that an offset lies in, up to there."""
    return text[text.rfind(b"\n", 0, offset) + 1 : offset]


def advice_at(code: bytes, offset: int) -> str:
    """The way out for a word or character that could not be read."""
    line = line_at(code, offset)
    here = offset - (code.rfind(b"\n", 0, offset) + 1)
    around = line[max(0, here - 12) : here + 13]
    # from what is surely meant to what is only likely: a comma before R is a corner whatever else
    # stands in the line, and an O for a zero is thought of last
    corner = CORNER.match(line, here)
    if corner:
        return ADVICE_CORNER if corner[1] in b"RCrc" else ADVICE_NO_CORNER
    if COMMA.search(around):
        return "a number takes a decimal point, not a comma: 20.5"
    if TWO_POINTS.search(around):
        return "a number has one decimal point: take the other one out"
    if STATEMENT.search(line):
        return ADVICE_EXPRESSION
    if POLAR.match(line, here):
        return ADVICE_POLAR
    if LETTER_O.search(line) and line.strip()[:1] not in b"Oo":
        return "is that the letter O in the place of a zero?"
    return "give the letter its number, or take it out"


def bare(code: bytes, offset: int) -> tuple[str, str]:
    """A letter without a number."""
    word = STATEMENT_WORD.match(code, offset)
    if word:
        return (
            f"{word[0].decode('ascii').strip()!r} is a statement, not a plain block",
            ADVICE_EXPRESSION,
        )
    word = CALL.match(code, offset)
    if word:
        return f"{word[1].decode('ascii')!r} is a call, not a plain block", ADVICE_EXPRESSION
    for pattern, does, advice in SIEMENS_WORDS:
        word = pattern.match(code, offset)
        if word:
            return f"{word[1].decode('ascii')} {does}", advice
    return f"the letter {chr(code[offset])} has no number", advice_at(code, offset)


def _slash(code: bytes, offset: int) -> tuple[str, str]:
    """A slash that is no block delete."""
    if code[offset : offset + 2] == b"//":
        return (
            "'//' begins no remark on this control: it would read on behind it",
            "begin the remark with ';', or take it out",
        )
    statement = STATEMENT.search(line_at(code, offset))
    return (
        "'/' is block delete only as the first character of a block, without a number",
        ADVICE_EXPRESSION if statement else "put it first, or take it out",
    )


def _stored_as(text: bytes, offset: int) -> tuple[str, str] | None:
    """Another way in which the file is stored; None: no sign of one here."""
    if text[:3] == b"\xef\xbb\xbf" and offset < 3:
        return (
            "the program begins with a byte order mark (UTF-8)",
            "save it as plain ASCII, or UTF-8 without the mark",
        )
    # UTF-16 of plain ASCII: every second byte is 0, and a mark of two bytes may stand before
    marked = text[:2] in (b"\xff\xfe", b"\xfe\xff") and offset < 4
    if marked or (b"\0" in text[offset : offset + 2] and text[1::2][:8].count(0) > 6):
        return "the program is stored as UTF-16, two bytes a character", "save it as plain ASCII"
    return None


def what(text: bytes, code: bytes, offset: int, slash: bool, in_number: bool) -> tuple[str, str]:
    """A character that belongs to no word: message and advice. `code` is `text` without its
    comments."""
    byte, character = code[offset], chr(code[offset])
    # looked for in `text`: what the lexer sees of it is LONE
    if text[offset] == ord("\r"):
        return (
            (
                "a carriage return without a line feed ends no line here: two blocks would be read"
                " as one"
            ),
            "save the program with LF or CR LF line ends",
        )
    if slash:
        return _slash(code, offset)
    if in_number:
        return f"{character!r} does not belong to a number here", advice_at(code, offset)
    if character == "=" and (named := ORIENTATION.fullmatch(line_until(code, offset))):
        return ORIENTATIONS.get(named[1], ANGLES)
    # comments are blanked by now: a bracket that is left belongs to a call, or was never closed
    if character == "(" and code[offset - 1 : offset].isalnum() and ARGUMENTS.match(code, offset):
        return f"{character!r} is not part of a plain NC block", ADVICE_EXPRESSION
    if character == "(":
        return (
            (
                "a comment is opened and not closed in its line, opened twice, or breaks a number"
                " in two"
            ),
            "close it with ')' and put it between words",
        )
    if character == ")":
        return "')' closes a comment that was not opened", "open it with '(' or take it out"
    if stored := _stored_as(text, offset):
        return stored
    if byte < 32:
        return (
            f"byte {byte} is not text: this looks like a binary file",
            "give the NC program itself",
        )
    if byte > 126:
        return (
            f"byte {text[offset]} is not ASCII",
            "outside comments a program is plain ASCII; save it as such",
        )
    return f"{character!r} is not part of a plain NC block", advice_at(code, offset)
