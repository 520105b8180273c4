"""Where in a Sinumerik program control goes from a line: labels, block numbers, partners of control
structures, the parts that are repeated.

Source: Siemens "SINUMERIK 840D sl / 828D Job Planning": program jumps, program section repetition,
control structures.
"""

from __future__ import annotations

import re
from functools import cached_property

from postproc.nc.codes import WRITE_OUT
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_blocks import HEAD, NAME
from postproc.nc.expand.siemens_statements import Jump
from postproc.nc.expand.siemens_words import end_of_code

STRUCTURE = re.compile(
    HEAD.pattern
    + r"(IF|ELSE|ENDIF|LOOP|ENDLOOP|WHILE|ENDWHILE|FOR|ENDFOR|REPEAT|UNTIL)(?![A-Z0-9_])",
    re.IGNORECASE | re.ASCII,
)
MARK = re.compile(
    rf"[ \t]*(?:/[0-9]?[ \t]*)?(?:(?:N[ \t]*|:)(\d+)[ \t]*)?(?:({NAME})[ \t]*:(?!=))?",
    re.IGNORECASE | re.ASCII,
)
CLOSES = {
    "IF": "ENDIF", "ELSE": "ENDIF", "LOOP": "ENDLOOP", "WHILE": "ENDWHILE", "FOR": "ENDFOR",
    "REPEAT": "UNTIL",
}  # fmt: skip
OPENS = {end: begin for begin, end in CLOSES.items() if begin != "ELSE"} | {"ELSE": "IF"}

OWN_CYCLES = re.compile(r"CYCLE\d+|HOLES\d|POCKET\d|SLOT\d|LONGHOLE")
NOT_HERE = (
    "put its text beside the program (NAME.SPF or NAME.MPF), or write its motions out: it could"
    " move an axis"
)


class Source:
    """A program's lines (text), with what is found in them when it is first asked for. `skips`:
    blocks with "/" are left out."""

    def __init__(self, name: str, file: str, lines: list[bytes], skips: bool):
        self.name, self.file, self.lines, self.skips = name, file, lines, skips

    def around(self, at: int) -> tuple[bytes, bytes]:
        """The text of the lines before and behind a line; empty where there is none."""
        before = self.lines[at - 1] if at else b""
        behind = self.lines[at + 1] if at + 1 < len(self.lines) else b""
        return before.strip(), behind.strip()

    @cached_property
    def marks(self) -> dict[str, list[int]]:
        """The lines of every label, and of every block number as "N10"."""
        found: dict[str, list[int]] = {}
        for i, line in enumerate(self.lines):
            mark = MARK.match(line.decode("latin-1"))
            # N010 and N10 are the same block
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
            # IF .. GOTOF is a jump and REPEAT ANF a repetition: neither opens anything
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
                # IF leads to its ELSE and ELSE to its ENDIF, loops from either end to the other
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

    # Whole: one branch to a kind of jump.
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
        # GOTO looks ahead first, then back; of several ones with a name the nearest is meant
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

    # Whole: the cases of a start and an end that stand before or behind.
    def section(self, first: str, last: str, at: int) -> tuple[int, int]:
        """First and last line of the part that a REPEAT at line `at` repeats. Raises Refusal."""
        starts = self.marks.get(first, [])
        start = max(
            (i for i in starts if i < at), default=min((i for i in starts if i > at), default=None)
        )
        if start is None:
            raise Refusal(f"there is no {first} in this program", "correct the name of the label")
        ends = [i for i in self.marks.get(last or "ENDLABEL", []) if i >= start]
        #   REPEAT ANF ENDE     from ANF to ENDE, wherever they stand
        #   REPEAT ANF          from ANF to ENDLABEL; without one before the REPEAT up to the REPEAT
        if ends and (last or start > at or ends[0] < at):
            return start, ends[0]
        if last or start > at:
            raise Refusal(
                f"there is no {last or 'ENDLABEL'} behind {first}",
                "write it at the end of what is repeated",
            )
        return start, at - 1


def missing(name: str, start: int, stop: int) -> Refusal:
    """Of a call of what is not here: a cycle of the control, or a subprogram."""
    if OWN_CYCLES.fullmatch(name.upper()):
        message = f"{name} is a cycle of the control that is not written out"
        return Refusal(message, WRITE_OUT, start, stop)
    message = f"{name} is neither a command that gcomp knows nor a subprogram that it has"
    return Refusal(message, NOT_HERE.replace("NAME", name), start, stop)
