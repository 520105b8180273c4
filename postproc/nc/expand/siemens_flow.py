"""Sinumerik program flow: what control lines say, and where in a program control goes from a line.

Source: Siemens "SINUMERIK 840D sl / 828D Job Planning": program jumps, program section repetition,
control structures, subprogram technique.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from postproc.nc.expand import siemens_boring, siemens_drilling
from postproc.nc.expand.siemens_blocks import HEAD, JUMPS, NAME, PASSES, Words
from postproc.nc.expand.siemens_statements import Jump, Right, Statement, Target
from postproc.nc.expand.siemens_values import Node, Refusal
from postproc.nc.expand.siemens_words import end_of_code

NAMES = (*siemens_drilling.NAMES, *siemens_boring.NAMES)
TYPES = ("REAL", "INT", "BOOL", "CHAR", "STRING", "AXIS")
STRUCTURE = re.compile(
    HEAD.pattern
    + r"(IF|ELSE|ENDIF|LOOP|ENDLOOP|WHILE|ENDWHILE|FOR|ENDFOR|REPEAT|UNTIL)(?![A-Z0-9_])",
    re.IGNORECASE | re.ASCII,
)
MARK = re.compile(
    rf"[ \t]*(?:/[0-9]?[ \t]*)?(?:(?:N[ \t]*|:)(\d+)[ \t]*)?(?:({NAME})[ \t]*:(?!=))?",
    re.IGNORECASE | re.ASCII,
)
LABEL = re.compile(rf"[ \t]*({NAME}|N\d+)(?![A-Z0-9_])", re.IGNORECASE | re.ASCII)
ATTRIBUTE = re.compile(r"[ \t]*([A-Z]+)", re.IGNORECASE)
OPENS = {
    "ENDIF": "IF",
    "ELSE": "IF",
    "ENDLOOP": "LOOP",
    "ENDWHILE": "WHILE",
    "ENDFOR": "FOR",
    "UNTIL": "REPEAT",
}
CLOSES = {
    "IF": "ENDIF",
    "ELSE": "ENDIF",
    "LOOP": "ENDLOOP",
    "WHILE": "ENDWHILE",
    "FOR": "ENDFOR",
    "REPEAT": "UNTIL",
}
REASONS = {
    "DEFINE": "macros are not followed: write their text where they stand",
    "MCALL": f"of modal calls {', '.join(NAMES)} are: write the other calls out",
    **dict.fromkeys(
        ("WHEN", "WHENEVER", "EVERY", "FROM", "DO", "ID", "IDS"),
        "synchronized actions depend on what happens while the machine moves: take them out",
    ),
}


@dataclass(frozen=True)
class Declaration:
    """A variable in a DEF: its type, the lengths of its dimensions, its initial values if any; and
    where it stands."""

    kind: str
    name: str
    sizes: list[Node]
    right: Right | None
    start: int
    stop: int


@dataclass(frozen=True)
class Parameter:
    """A parameter of a PROC. reference: VAR, or an array; default: its value if it is left out."""

    kind: str
    name: str
    reference: bool
    default: Node | None


# -- control lines ---------------------------------------------------------------------------------


def read(text: str) -> Statement:
    """What a line says. Raises Refusal."""
    head = HEAD.match(text)
    begin = head.end() if head else 0
    words = Words(text, end_of_code(text), begin)
    if text.lstrip(" \t").startswith("%"):
        return words.into
    if head and head[1]:
        words.piece(head.start(1), begin, lambda scope: "")
    token = words.next()
    keyword = (token["name"] or "").upper() if token else ""
    if token and keyword in READERS:
        words.at = token.end()
        words.into.control = keyword
        READERS[keyword](words)
        words.end(keyword)
        return words.into
    if token and keyword == "MCALL":
        return _modal(words, token)
    if token and keyword in REASONS:
        raise Refusal(
            f"{keyword} can not be written out", REASONS[keyword], token.start("name"), token.end()
        )
    if keyword == "IF" and token:
        words.at = token.end()
        words.into.parts = (words.expression(),)
        if words.done():
            words.into.control = "IF"
            return words.into
        if not words.taken(*JUMPS):
            raise words.wrong("behind a condition stands GOTOF or one of its kin, or nothing")
        words.at = begin
    return words.words()


def _modal(words: Words, token: re.Match[str]) -> Statement:
    """MCALL with a call that is made behind every motion, or alone: that is over."""
    words.into.control, words.at = "MCALL", token.end()
    if words.done():
        return words.into
    name = words.next()
    if not name or (name["name"] or "").upper() not in NAMES:
        raise Refusal(
            "MCALL can not be written out", REASONS["MCALL"], token.start("name"), token.end()
        )
    words.call(name["name"].upper(), name.start("name"), name.end(), 0)
    return words.into


def _condition(words: Words) -> None:
    words.into.parts = (words.expression(),)


def _for(words: Words) -> None:
    token = words.next()
    if token is None or not token["name"]:
        raise words.wrong("FOR needs a variable")
    words.at = token.end()
    name = "".join(token["name"].upper().split())
    target = Target(name, words.index_entries(), token.start("name"), words.at)
    words.need("=")
    right = Right([words.entry()])
    words.need("TO")
    words.into.parts = (target, right, words.expression())


def _repeat(words: Words) -> None:
    if words.done() and words.into.control == "REPEAT":
        return
    labels: list[str] = []
    while (found := LABEL.match(words.text, words.at)) and len(labels) < 2:
        words.at = found.end()
        labels.append(found[1].upper())
    if not labels:
        raise words.wrong(f"a label is missing behind {words.into.control}")
    count = None
    if passes := PASSES.match(words.text, words.at):
        words.at = passes.end()
        count = words.expression()
    words.into.control += " SECTION" if words.into.control == "REPEAT" else ""
    words.into.parts = (labels[0], labels[-1] if len(labels) > 1 else "", count)


def _case(words: Words) -> None:
    tested, cases, default = words.expression(), [], None
    words.need("OF")
    while not words.done():
        if words.taken("DEFAULT"):
            default = words.jump(None)
            break
        value = words.expression()
        cases.append((value, words.jump(None)))
    words.into.parts = (tested, cases, default)


def _type(words: Words) -> str:
    found = ATTRIBUTE.match(words.text, words.at)
    kind = found[1].upper() if found else ""
    if kind not in TYPES or not found:
        reason = (
            "frames as variables are not followed"
            if kind == "FRAME"
            else "a type is missing: REAL, INT, BOOL ..."
        )
        raise words.wrong(
            reason, "program the shift with TRANS" if kind == "FRAME" else "see the manual for DEF"
        )
    words.at = found.end()
    if kind == "STRING":
        words.indices()
    return kind


def _name(words: Words, subprogram: bool = False) -> tuple[str, int]:
    """A name, and where it stands; of a subprogram it may be L140, too."""
    token = words.next()
    if token is None or not token["name"] or token["name"][0] == "$":
        raise words.wrong("a name is missing")
    name = "".join(token["name"].upper().split())
    lawful = name[0] == "R" or (subprogram and name[0] == "L" and len(name) > 1)
    if (len(name) == 1 or name[1:].isdigit()) and not lawful:
        raise words.wrong(
            f"{name} is an address", "the first two characters of a name are letters or underscores"
        )
    words.at = token.end()
    return name, token.start("name")


def _define(words: Words) -> None:
    kind, found = _type(words), []
    while True:
        name, start = _name(words)
        sizes, right = words.indices(), None
        if len(sizes) > 3:
            raise words.wrong("an array has 3 dimensions at most", "use several arrays")
        if words.taken("="):
            right = words.right()
        found.append(Declaration(kind, name, sizes, right, start, words.at))
        if not words.taken(","):
            break
    words.into.parts = tuple(found)


def _procedure(words: Words) -> None:
    name, _ = _name(words, subprogram=True)
    found: list[Parameter] = []
    if words.taken("(") and not words.taken(")"):
        while True:
            reference = bool(words.taken("VAR"))
            kind = _type(words)
            own, _ = _name(words)
            array = bool(words.taken("["))
            while array and not words.taken("]"):
                if not words.taken(","):
                    words.expression()
            default = words.expression() if words.taken("=") else None
            found.append(Parameter(kind, own, reference or array, default))
            if words.need(",", ")") == ")":
                break
    while attribute := ATTRIBUTE.match(words.text, words.at):
        if attribute[1].upper() == "SAVE":
            advice = "take SAVE out and write the codes behind each call"
            raise words.wrong(
                f"{name} gives back the modal codes of before (SAVE), which is not followed", advice
            )
        words.at = attribute.end()
    words.into.parts = tuple(found)


def _return(words: Words) -> None:
    words.into.ends, words.into.control = "RET", ""
    if not words.done():
        raise words.wrong("RET with a destination is not followed", "write RET alone")
    words.piece(words.at - 3, words.at, lambda scope: "")


def _call(words: Words) -> None:
    keyword, words.into.control = words.into.control, ""
    start = words.at - len(keyword)
    if keyword == "PCALL":
        found = re.compile(r"[ \t]*([A-Z0-9_/.]+)", re.IGNORECASE | re.ASCII).match(
            words.text, words.at
        )
        if not found:
            raise words.wrong("PCALL needs a name")
        words.call(found[1].upper(), start, found.end(), 0)
    else:
        computed = words.expression()
        words.call("", start, words.at, 0, computed)


READERS: dict[str, Callable[[Words], None]] = {
    **dict.fromkeys(("ELSE", "ENDIF", "LOOP", "ENDLOOP", "ENDWHILE", "ENDFOR"), lambda words: None),
    "WHILE": _condition,
    "UNTIL": _condition,
    "FOR": _for,
    "REPEAT": _repeat,
    "REPEATB": _repeat,
    "CASE": _case,
    "DEF": _define,
    "PROC": _procedure,
    "EXTERN": lambda words: setattr(words, "at", len(words.text)),
    "RET": _return,
    "CALL": _call,
    "PCALL": _call,
    "EXTCALL": _call,
}


# -- where control goes ----------------------------------------------------------------------------


class Source:
    """A program's lines (text), with what is found in them when it is first asked for. `skips`:
    blocks with "/" are left out."""

    def __init__(self, name: str, file: str, lines: list[bytes], skips: bool):
        self.name, self.file, self.lines, self.skips = name, file, lines, skips

    @cached_property
    def marks(self) -> dict[str, list[int]]:
        """The lines of every label, and of every block number as "N10"."""
        found: dict[str, list[int]] = {}
        for i, line in enumerate(self.lines):
            mark = MARK.match(line.decode("latin-1"))
            if mark and mark[1] and len(mark[1]) < 19:
                found.setdefault(f"N{int(mark[1])}", []).append(i)
            if mark and mark[2]:
                found.setdefault(mark[2].upper(), []).append(i)
        return found

    @cached_property
    def partners(self) -> dict[int, int | str]:
        """For each line of a control structure the line that it depends on: IF its ELSE or ENDIF,
        ELSE its ENDIF, a loop's begin its end and the other way round; or what is wrong with it."""
        found: dict[int, int | str] = {}
        opened: list[tuple[str, int]] = []
        for i, line in enumerate(self.lines):
            text = line.decode("latin-1")
            word = STRUCTURE.match(text)
            if not word or (self.skips and text.lstrip(" \t").startswith("/")):
                continue
            keyword, rest = word[2].upper(), text[word.end() : end_of_code(text)]
            if (keyword == "IF" and re.search(r"\bGOTO[FBCS]?\b", rest, re.IGNORECASE)) or (
                keyword == "REPEAT" and rest.strip(" \t")
            ):
                continue
            if keyword in OPENS:
                if not opened or (
                    opened[-1][0] != OPENS[keyword]
                    and (opened[-1][0], keyword) != ("ELSE", "ENDIF")
                ):
                    found[i] = f"{keyword} without {OPENS[keyword]}"
                    continue
                begin = opened.pop()[1]
                found[begin], found[i] = i, begin
            if keyword in CLOSES:
                opened.append((keyword, i))
        for keyword, i in opened:
            found[i] = f"{keyword} without {CLOSES[keyword]}"
        return found

    def partner(self, at: int) -> int:
        """The line that a line of a control structure depends on. Raises Refusal where the
        structure is broken."""
        found = self.partners.get(at, "this is no part of a control structure")
        if isinstance(found, str):
            raise Refusal(
                found, "complete the control structure; blocks with / may have been left out"
            )
        return found

    def destination(self, jump: Jump, target: str, at: int) -> int | None:
        """The line that a jump leads to. None: GOTOC finds none. Raises Refusal where there is
        none."""
        if jump.kind == "GOTOS":
            return 0
        name = target.lstrip(":").upper()
        number = name[1:] if name[:1] == "N" else name
        lines = self.marks.get(name) or []
        if not lines and number.isdigit() and number.isascii() and len(number) < 19:
            lines = self.marks.get(f"N{int(number)}") or []
        before, behind = [i for i in lines if i <= at], [i for i in lines if i > at]
        if jump.kind == "GOTOB":
            behind = []
        elif jump.kind == "GOTOF":
            before = []
        if behind or before:
            return behind[0] if behind else before[-1]
        if jump.kind == "GOTOC":
            return None
        where = {"GOTOB": "before this line", "GOTOF": "behind this line"}.get(
            jump.kind, "in this program"
        )
        raise Refusal(
            f"there is no {name} {where}",
            "correct the name of the label or block, or the direction",
            jump.start,
            jump.stop,
        )

    def section(self, first: str, last: str, at: int) -> tuple[int, int]:
        """First and last line of the part that a REPEAT at line `at` repeats. Raises Refusal."""
        starts = self.marks.get(first, [])
        start = max(
            (i for i in starts if i < at), default=min((i for i in starts if i > at), default=None)
        )
        if start is None:
            raise Refusal(f"there is no {first} in this program", "correct the name of the label")
        ends = [i for i in self.marks.get(last or "ENDLABEL", []) if i >= start]
        if ends and (last or start > at or ends[0] < at):
            return start, ends[0]
        if last or start > at:
            raise Refusal(
                f"there is no {last or 'ENDLABEL'} behind {first}",
                "write it at the end of what is repeated",
            )
        return start, at - 1
