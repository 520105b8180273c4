"""Heidenhain Klartext as letters and numbers: every statement is brought to words of the same
length.

L is G1, and G0 with FMAX, which holds in its own block alone. RL, RR and R0 are G41, G42 and G40;
M91 is G53; APPR and DEP are G1 that begin and end the side; M140 MB MAX and M92 are G30, to a place
that the machine knows; IX is an increment; TOOL CALL is T and S, its DL is Q; cycle 7 and TRANS
DATUM are G52, the preset of cycle 247 (Q339) is G247 P; FUNCTION TCPM .. PATHCTRL AXIS is M128.
What defines, names or remarks something without moving is blank; what moves otherwise is a MACRO
with the number of its reason (REASONS). Lines are looked at one by one, whatever stands around
them: any cut of the text reads alike.

HEIDENHAIN TNC 640 (81760x), TNC 620 (81760x), iTNC 530 user's manuals, Klartext programming:
"Structure of an NC program", "Programming tool movements", "Miscellaneous functions", cycles 7 to
11, 19, 26, 247, "Dwell time FUNCTION DWELL"; Data Interfaces for HEIDENHAIN controls (SHB),
"Decimal point or comma" (MP 92; MP 7280 of later ones): a point is written here, as posts write it
whatever the control is set to.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from postproc.nc import codes
from postproc.nc.grammar import AXES, BARE, MACRO, RELATIVE, UNKNOWN_FEED

EXPAND_PATH = "its motions are worked out by the control: --expand writes it out as straight lines"
DATUM = "it moves the datum by the tables of the control: program in one datum, with --offset G54="
VALUES = "its numbers are Q parameters: --expand writes them out"
PARAXIAL = "a block that begins with an axis moves it alone, its R is no side: write L before it"
SUM = "an increment counts from the shift before it: --expand writes their sum"
LONGER = "by how much DL makes the tool longer is not certain: write its number beside the tool's"
ALONG = "the tool does not lie along Z: program with the tool axis Z"
SIDELESS = (
    "it joins the contour without RL or RR, on ways that are the control's own: write it out as L"
    " and CR"
)
GOES_ON = "no statement begins so; where it goes on a comment (~), --expand joins them"
SETS = "it sets data of the control: set them before the program, and take the block out"
REASONS = (  # why a statement can not be followed; a MACRO says the number, from 1
    codes.CALL, EXPAND_PATH, codes.WRITE_OUT, codes.UNTURNED, codes.TILTED, codes.TOOL_POINT,
    codes.PROBE, DATUM, LONGER, ALONG, SETS, codes.TRANSFORM, codes.CURVE, SUM, VALUES, PARAXIAL,
    GOES_ON, SIDELESS, codes.FRAME,
)  # fmt: skip
REASON = {why: number for number, why in enumerate(REASONS, 1)}
COMMA = re.compile(rb"(?<=[0-9]),(?=[0-9])")
HEAD = re.compile(rb"[ \t]*(/[ \t]*)?(?:[0-9]+(?=[ \t\r*;]|\Z)[ \t]*)?")  # a number alone: 12 L
WORD = re.compile(rb"Q[LRS]?[0-9]+[ \t]*=|[A-Z]+|\*")
PRESET = re.compile(rb"Q339[ \t]*=[ \t]*[+]?[ \t]*[0-9]+[ \t\r]*\Z")
SIDE = re.compile(rb"[ \t]R(?:([0LR])(?![A-Z0-9.+-])|(?=[ \t\r]|\Z))")  # with a number: a radius
FAST = re.compile(rb"(?<![A-Z])F[ \t]*MAX\b")
FEED = re.compile(rb"(?<![A-Z])F[ \t]*(?:AUTO\b|[+-]?Q[LR]?[0-9]+)")
# A word whose question was passed over (TNC 151 to 355 print it so): R alone is in _side.
NO_VALUE = re.compile(rb"(?<![A-Z])[FM](?=[ \t]*(?:[A-Z]|\r?\Z))(?![A-Z])")
MACHINE = re.compile(rb"(?<![A-Z])M[ \t]*0*91(?![0-9])")
TO_LIMIT = re.compile(
    rb"(?<![A-Z])M[ \t]*0*140[ \t]+MB[ \t]*MAX\b(?:[ \t]*F[ \t]*(?:MAX|[0-9.]+))?"
)
# F of M103 is a share, of M128 a limit: of no path (TNC 640: L X+20 Y+20 RL F500 M103 F20).
OWN_FEED = r"(?<=M103|M128)[ \t]*F[ \t]*(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
NOT_OF_PATH = re.compile(OWN_FEED.encode())
BUILDER = re.compile(rb"(?<![A-Z])M[ \t]*0*92(?![0-9])")
TO_BUILDER = re.compile(rb"(?<![A-Z])([XYZABCUVW])[ \t]*[-+]?[ \t]*[0-9]*\.?[0-9]+")
USED = re.compile(rb"(?<![A-Z])(?:I?[XYZABCUVW]|R|T)[ \t]*[+-]?[ \t]*Q[LR]?[0-9]+")
SPEED = re.compile(rb"(?<![A-Z])S[ \t]*[+-]?Q[LR]?[0-9]+")
STEP = re.compile(rb"(?<![A-Z])I([XYZABCUVW])(?=[ \t]*[-+.0-9])")
COMMENT_ON = re.compile(rb"[A-Z]{2,}(?:[ \t.,]+[A-Z]+)*[ \t\r.]*")  # words alone
AXIS = re.compile(rb"(?<![A-Z])[XYZABCUVW](?=[ \t]*[-+.0-9Q])|[\x90-\x9f]")
TOOL = re.compile(
    rb"TOOL[ \t]+CALL(?:[ \t]+(?:([0-9]+)(\.[0-9]+)?|(\"[^\"]*\")))?(?:[ \t]+([XYZ])\b)?"
)
DELTA = re.compile(rb"\bD(L|R2?)[ \t]*([+-]?(?:[0-9.]+|Q[LR]?[0-9]+))?")
CYCLE = re.compile(rb"CYCL[ \t]+DEF[ \t]*([0-9]+)(?:[ \t]*\.([0-9]+))?")
CALLED = re.compile(rb"CYCL[ \t]+CALL(?![ \t]*(?:PAT|POS))")
VALUE = re.compile(rb"[-+]?[0-9]*\.?[0-9]+")
DWELL = re.compile(rb"[ \t]*(?:DWELL|V\.[ \t]*ZEIT)[ \t]*[+]?([0-9]*\.?[0-9]+)\.?[ \t\r]*\Z")
DWELLS = re.compile(
    rb"FUNCTION[ \t]+DWELL\b[ \t]*(?:TIME[ \t]*[+]?([0-9]*\.?[0-9]+)\.?[ \t\r]*\Z)?"
)
PATTERNS = (220, 221)
MOVES_AT_ONCE = (224, 238, 239)
# A mirror has letters of axes and no value: it ends where its line has none.
TURNS = {8: "", 10: "0", 11: "1", 19: "0", 26: "1"}  # a value that turns, scales, mirrors nothing
TURNED = {19: codes.TILTED}
CYLINDERS = (27, 28, 29, 39)
ACT_AT_ONCE = (7, 9, 13, 14, 20, 32, 247, *TURNS)  # and are no cycles that are called
STAY = (2, 17, 202, 204, 206, 207, 209, 241, *range(262, 266), 267)  # by the spindle
ZERO = b"G52X0Y0Z0"
PLANE = b"G268"
# TCPM with places of rotary axes, about the tip and with its feed: M128. Not PATHCTRL VECTOR, with
# which they may go to other ends than the programmed ones ("FUNCTION TCPM").
AS_M128 = re.compile(
    rb"FUNCTION[ \t]+TCPM[ \t]+F[ \t]*TCP[ \t]+AXIS[ \t]+POS"
    rb"[ \t]+PATHCTRL[ \t]+AXIS(?:[ \t]+REFPNT[ \t]+TIP-TIP)?"
    rb"(?:[ \t]+F[ \t]*[0-9.]+)?[ \t\r]*\Z"
)
ANGLES = re.compile(rb"(?:SP[ABC]|EUL(?:PR|NU|ROT))[ \t]*[-+]?Q")
JOIN = re.compile(rb"(APPR|DEP)[ \t]+(P?)(LT|LN|CT|LCT)(?![A-Z])")
JOIN_DATA = re.compile(
    rb"(?<![A-Z])(?:LEN|CCA|R)[ \t]*[-+]?(?:[0-9]*\.?[0-9]+|Q[LR]?[0-9]+)(?![0-9.])"
)
LEAVES = b"G40G30" + bytes(BARE + AXES.index(x) for x in "XY")  # beside PE by the tool's radius
LEAVES_Z = LEAVES + bytes([BARE + AXES.index("Z")])
PARAXIALS = (b"X", b"Y", b"Z", b"A", b"B", b"U", b"V", b"W")  # without C, which begins an arc
Z_ALONE = bytes([BARE + AXES.index("Z")])


def respelled(code: bytes) -> bytes:
    """A text without comments, byte for byte as long, as words that the lexer reads."""
    #   12 L X+10 IY-5 RL FMAX M3        The statement's own bytes are room for codes: what is read
    #      G0X+10 y -5G41      M3        anew is never longer than what stood there, for offsets
    #   y: RELATIVE of Y                 into it are offsets into the program.
    return b"\n".join([_line(line) for line in pointed(code).split(b"\n")])


def pointed(code: bytes) -> bytes:
    """The same with points for decimal commas, which a control that is set so writes."""
    return COMMA.sub(b".", code) if b"," in code else code


def _line(line: bytes) -> bytes:
    if not line or line.isspace():
        return line
    head = HEAD.match(line)
    assert head is not None
    begin = head.end()
    lead = (head[1] or b"").rjust(head.end(1) if head[1] else 0).ljust(begin)
    rest = line[begin:]
    if rest[:2] in (b"L ", b"L\t"):
        return lead + _straight(rest)
    upper = rest.upper()
    word = WORD.match(upper)
    if word is None:
        return lead + rest
    if word[0].endswith(b"="):
        return lead + _parameter(upper)
    of = STATEMENTS.get(word[0])
    if of is None and COMMENT_ON.fullmatch(upper):
        return lead + _macro(upper, GOES_ON)
    return lead + (rest if of is None else of(upper).ljust(len(rest)))


def _macro(text: bytes, why: str) -> bytes:
    """The whole line as one word; as it is, and so no word, where there is no room for one."""
    word = bytes([MACRO]) + b"%d" % REASON[why]
    return word.ljust(len(text)) if len(word) <= len(text) else text


def _blank(text: bytes) -> bytes:
    return b" " * len(text)


def _filled(new: bytes, match: re.Match[bytes]) -> bytes:
    return new.ljust(len(match[0]))


def _words(text: bytes) -> tuple[bytes, bool]:
    """The words of a line without its statement, and whether FMAX stood among them."""
    if b"M" in text:
        limit = b"G30" + Z_ALONE
        text = TO_LIMIT.sub(lambda m: _filled(limit, m), text)
        text = NOT_OF_PATH.sub(lambda m: _blank(m[0]), text)
        text = MACHINE.sub(lambda m: _filled(b"G53", m), text)
        if BUILDER.search(text):
            text = TO_BUILDER.sub(_bare, BUILDER.sub(lambda m: _filled(b"G30", m), text))
    if b"Q" in text:
        text = SPEED.sub(lambda m: _blank(m[0]), text)
    fast = FAST.search(text) is not None
    if fast:
        text = FAST.sub(lambda m: b" " * len(m[0]), text)
    elif b"F" in text:
        text = FEED.sub(lambda m: _filled(bytes([UNKNOWN_FEED]), m), text)
    text = NO_VALUE.sub(b" ", text)
    if b"I" in text:
        text = STEP.sub(lambda m: bytes([RELATIVE + AXES.index(m[1].decode()), 0x20]), text)
    return text, fast


def _straight(text: bytes) -> bytes:
    """L X+10 IY-5 R0 FMAX M3."""
    if b"Q" in text and USED.search(text):
        return _macro(text, VALUES)
    body, fast = _words(text[1:])
    if b"R" in body:
        body = SIDE.sub(_side, body)
    if AXIS.search(body) is None:
        return b" " + body
    # the blank before RL and its kin is the first byte of a code
    return (b"G0" if fast else b"G1") + body[1:]


def _join(text: bytes) -> bytes:
    """APPR X Y RL and DEP LCT X Y: an end of its own; other DEP end beside the contour's last point
    by the tool's radius. The ways between are the control's, and are not cut: they begin or end
    the radius compensation."""
    match = JOIN.match(text)
    if match is None:
        return _macro(text, codes.WRITE_OUT)
    if match[2]:
        return _macro(text, EXPAND_PATH)
    body = JOIN_DATA.sub(lambda m: _blank(m[0]), text[match.end() :])
    if USED.search(body):
        return _macro(text, VALUES)
    body, fast = _words(body)
    code = b"G0" if fast else b"G1"
    if match[1] == b"DEP" and match[3] != b"LCT":
        leaves = LEAVES_Z if b"Z" in body else LEAVES
        return leaves.ljust(len(text)) if len(leaves) <= len(text) else _macro(text, SIDELESS)
    body = SIDE.sub(_side, body)
    if match[1] == b"DEP":
        return (code + b"G40").ljust(match.end()) + body
    if b"G41" not in body and b"G42" not in body:
        return _macro(text, SIDELESS)
    return code.ljust(match.end()) + body


def _bare(match: re.Match[bytes]) -> bytes:
    """An axis that goes to a place that the machine knows alone."""
    return _filled(bytes([BARE + AXES.index(match[1].decode())]), match)


def _side(match: re.Match[bytes]) -> bytes:
    """R0 RL RR, with the blank before; R alone says that nothing changes."""
    code = {b"0": b"G40", b"L": b"G41", b"R": b"G42"}.get(match[1] or b"", b"")
    return _filled(code, match)


def _parameter(text: bytes) -> bytes:
    """Q1=+5: it moves nothing, and who uses it is asked there; Q339 of cycle 247 is the preset."""
    if PRESET.match(text):
        number: list[bytes] = VALUE.findall(text.partition(b"=")[2])
        return (b"G247P" + number[0].lstrip(b"+")).ljust(len(text))
    return _blank(text)


def _tool(text: bytes) -> bytes:
    match = TOOL.match(text)
    if match is None:
        return _blank(text)  # TOOL DEF
    rest = text[match.end() :]
    for delta in DELTA.finditer(rest):
        value = VALUE.fullmatch((delta[2] or b"0").rstrip(b"."))
        if value is None and delta[1] == b"L":
            return _macro(text, VALUES)
        if delta[1] == b"L" and value and match[1] is None and float(value[0]):
            return _macro(text, LONGER)
    if match[4] not in (None, b"Z"):
        return _macro(text, ALONG)
    rest, _ = _words(DELTA.sub(_longer, rest))
    head = b""
    if match[1] is not None:
        head = b"T".rjust(match.start(1)) + match[1]
    elif match[3] is not None:
        head = b"T9999".rjust(match.end(3))
    return head.ljust(match.end()) + rest


def _longer(match: re.Match[bytes]) -> bytes:
    """DL+0.1 is Q; DR and DR2 are of the radius."""
    if match[1] != b"L" or match[2] is None:
        return _blank(match[0])
    return b"Q".ljust(match.start(2) - match.start()) + match[2]


def _cycle(text: bytes) -> bytes:
    """A definition moves nothing by itself, but for a few."""
    match = CYCLE.match(text)
    if match is None:
        call = CALLED.match(text)
        if call is None:
            return _macro(text, EXPAND_PATH)
        # G79 is a code of the dialect's own for the call, as G200 and G207 are for definitions
        # what it does refusals.py asks; where it leaves the tool axis only the control knows
        return (b"G79G30" + Z_ALONE).ljust(call.end()) + _words(text[call.end() :])[0]
    number, part, rest = int(match[1]), match[2], text[match.end() :]
    if number == 247:
        return ZERO.ljust(len(text))
    if number == 7 and part not in (None, b"0"):
        return _shift(text, match.end())
    if number == 9 and part not in (None, b"0"):
        return _dwell(text, DWELL.match(text, match.end()))
    if why := _moves_otherwise(number):
        return _macro(text, why)
    if number in TURNS and part not in (None, b"0") and rest.strip():
        return _turned(text, number, rest)
    # part 0 (CYCL DEF 1.0 PECKING) names the cycle, further ones are its values
    if number in ACT_AT_ONCE or part not in (None, b"0"):
        return _blank(text)
    return (b"G207" if number in STAY else b"G200").ljust(len(text))


def _dwell(text: bytes, time: re.Match[bytes] | None) -> bytes:
    """A dwell; time: the match whose group 1 is how many seconds, if any."""
    if time is None or time[1] is None:
        return b"G4".ljust(len(text))
    return b"G4" + b"F".rjust(time.start(1) - 2) + time[1]


def _moves_otherwise(number: int) -> str:
    """Why the definition of a cycle can not be followed; "": it can."""
    if number == 12:
        return codes.CALL
    if number in PATTERNS:
        return EXPAND_PATH
    if number in MOVES_AT_ONCE or 400 <= number < 500:
        return codes.WRITE_OUT
    return codes.TRANSFORM if number in CYLINDERS else ""


def _turned(text: bytes, number: int, rest: bytes) -> bytes:
    """What brings a rotation, a scale, a mirror or a plane back to nothing passes."""
    values = [float(v) for v in VALUE.findall(rest)]
    nothing = TURNS[number]
    if nothing and values and all(v == float(nothing) for v in values):
        return _blank(text)
    return _macro(text, TURNED.get(number, codes.FRAME))


def _shift(text: bytes, begin: int) -> bytes:
    """The words behind cycle 7 or TRANS DATUM AXIS."""
    rest = text[begin:]
    if b"#" in rest:
        return _macro(text, DATUM)
    if USED.search(rest):
        return _macro(text, VALUES)
    if STEP.search(rest):
        return _macro(text, SUM)
    return b"G52".ljust(begin) + rest if AXIS.search(rest) else _blank(text)


def _datum(text: bytes) -> bytes:
    match = re.match(rb"TRANS[ \t]+DATUM[ \t]+(AXIS|RESET)\b", text)
    if match is None:
        return _macro(text, DATUM)
    return ZERO.ljust(len(text)) if match[1] == b"RESET" else _shift(text, match.end())


def _plane(text: bytes) -> bytes:
    """PLANE; its words spatial.py reads."""
    if ANGLES.search(text):
        return _macro(text, VALUES)
    return PLANE.ljust(len(text)) if len(PLANE) <= len(text) else _macro(text, codes.TILTED)


def _function(text: bytes) -> bytes:
    if re.match(rb"FUNCTION[ \t]+MODE[ \t]+MILL\b", text):
        return _blank(text)
    if re.match(rb"FUNCTION[ \t]+(?:RESET[ \t]+TCPM|TCPM[ \t]+RESET)\b", text):
        return b"M129"
    if AS_M128.match(text):
        return b"M128"
    if dwells := DWELLS.match(text):
        return _dwell(text, dwells)
    return _macro(text, codes.TOOL_POINT if b"TCPM" in text else SETS)


def _fn(text: bytes) -> bytes:
    """FN 0 to 8 calculate, 9 to 12 jump, 14 to 38 write, print and wait."""
    number = re.match(rb"FN[ \t]*([0-9]+)", text)
    if number is None:
        return text
    if 9 <= int(number[1]) <= 12:
        return _macro(text, codes.CALL)
    return _macro(text, SETS) if number[1] in (b"17", b"25") else _blank(text)


def _begin(text: bytes) -> bytes:
    return b"G20" if re.search(rb"[ \t]INCH[ \t\r]*\Z", text) else b"G21"


def _named(why: str) -> Callable[[bytes], bytes]:
    return lambda text: _macro(text, why)


def _stop(text: bytes) -> bytes:
    return b"M0  " + _words(text[4:])[0]


STATEMENTS: dict[bytes, Callable[[bytes], bytes]] = {
    **dict.fromkeys((b"END", b"BLK", b"*", b"LBL", b"CC", b"PATTERN", b"POS"), _blank),
    **dict.fromkeys(
        (b"C", b"CR", b"CT", b"CP", b"LP", b"CTP", b"RND", b"CHF"), _named(EXPAND_PATH)
    ),
    **dict.fromkeys((b"LN", b"LT", b"FL", b"FLT", b"FC", b"FCT", b"FPOL"), _named(codes.WRITE_OUT)),
    **dict.fromkeys((i + axis for i in (b"", b"I") for axis in PARAXIALS), _named(PARAXIAL)),
    b"APPR": _join,
    b"DEP": _join,
    b"SPL": _named(codes.CURVE),
    b"CALL": _named(codes.CALL),
    b"TCH": _named(codes.PROBE),
    b"BEGIN": _begin,
    b"TOOL": _tool,
    b"CYCL": _cycle,
    b"TRANS": _datum,
    b"PLANE": _plane,
    b"FUNCTION": _function,
    b"FN": _fn,
    b"STOP": _stop,
    b"M": lambda text: _words(text)[0],
}
