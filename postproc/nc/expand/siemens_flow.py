"""Sinumerik program flow: what control lines say. Where control goes from them: siemens_source.py.

Source: Siemens "SINUMERIK 840D sl / 828D Job Planning": program jumps, program section repetition,
control structures, subprogram technique.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_blocks import HEAD, JUMPS, NAME, PASSES, Words
from postproc.nc.expand.siemens_boring import Boring
from postproc.nc.expand.siemens_drilling import Drilling
from postproc.nc.expand.siemens_kept import Tapping
from postproc.nc.expand.siemens_statements import Right, Statement, Target
from postproc.nc.expand.siemens_values import Node
from postproc.nc.expand.siemens_words import end_of_code

NAMES = (*Drilling.words, *Boring.words, *Tapping.words)
TYPES = ("REAL", "INT", "BOOL", "CHAR", "STRING", "AXIS")
LABEL = re.compile(rf"[ \t]*({NAME}|N\d+)(?![A-Z0-9_])", re.IGNORECASE | re.ASCII)
ATTRIBUTE = re.compile(r"[ \t]*([A-Z]+)", re.IGNORECASE)
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


# Whole: one branch to a kind of statement.
def read(text: str) -> Statement:
    """What a line says. Raises Refusal."""
    head = HEAD.match(text)
    begin = head.end() if head else 0
    words = Words(text, end_of_code(text), begin)
    if text.lstrip(" \t").startswith("%"):
        return words.into
    # a label goes, for nothing jumps in what is written out
    if head and head[1]:
        words.piece(head.start(1), begin, lambda scope: "")
    token = words.next()
    # Only the first word makes a control line; the same name further on is a variable, or wrong.
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
        # IF .. GOTOF: read once more from its begin, as a word of the line (Words.named_word)
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


# FOR R1=1 TO 10
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


PART = re.compile(
    r"[ \t]*BLOCK[ \t]+([A-Z_][A-Z0-9_]*)[ \t]+TO[ \t]+([A-Z_][A-Z0-9_]*)", re.IGNORECASE | re.ASCII
)


# REPEAT, which UNTIL closes; REPEAT ANF P=3; REPEAT ANF ENDE; REPEATB ANF
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


# CASE R1 OF 1 GOTOF AA 2 GOTOF BB DEFAULT GOTOF CC
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
    # DEF REAL R10=5 sets R10, which is there anyway (Run.declare); PROC L140 is a subprogram by
    # number
    lawful = name[0] == "R" or (subprogram and name[0] == "L" and len(name) > 1)
    if (len(name) == 1 or name[1:].isdigit()) and not lawful:
        raise words.wrong(
            f"{name} is an address", "the first two characters of a name are letters or underscores"
        )
    words.at = token.end()
    return name, token.start("name")


# DEF REAL AB=1, FELD[2,3]=SET(1,2)
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
    """PROC: name and parameters, VAR and arrays by reference."""
    name, _ = _name(words, subprogram=True)
    found: list[Parameter] = []
    if words.taken("(") and not words.taken(")"):
        while True:
            # PROC NAME(REAL AB, VAR INT BB, REAL FE[,2], INT DD=5)
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
    """CALL, also of a part of this program from one label to another, which runs once (CALL BLOCK
    .. TO ..; Programming Manual Job Planning, as Autodesk's posts write subprograms)."""
    keyword, words.into.control = words.into.control, ""
    start = words.at - len(keyword)
    part = PART.match(words.text, words.at) if keyword == "CALL" else None
    if part:
        words.at, words.into.control = part.end(), "REPEAT SECTION"
        words.into.parts = (part[1].upper(), part[2].upper(), None)
        return
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
