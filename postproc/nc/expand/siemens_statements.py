"""What a Sinumerik line says, ready to be executed as often as control comes by: values within it,
assignments, jumps, calls, and the line with its values written as numbers. siemens_blocks.py reads
them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_values import Node, Scope, Value, converted, rounded

EMPTY_CODE = re.compile(
    r"[ \t]*(?:/[0-9]?[ \t]*)?(?:(?:N[ \t]*|:)\d+[ \t]*)?", re.IGNORECASE | re.ASCII
)


@dataclass(frozen=True)
class Entry:
    """A value within a line: its place, and how to calculate it. plain: it is a number or string
    and stays as it stands.
    name: it is one name only, which is calculated if it is a variable. wrapped: it stands in IC( ),
    AC( ) ..."""

    start: int
    stop: int
    node: Node
    plain: bool
    name: str = ""
    wrapped: bool = False


@dataclass(frozen=True)
class Target:
    """What stands left of "=": a name in upper case, its indices, its place with them."""

    name: str
    indices: list[Entry]
    start: int
    stop: int

    def places(self, scope: Scope) -> list[int]:
        """The indices as numbers."""
        return [rounded(index.node(scope)) for index in self.indices]


@dataclass(frozen=True)
class Right:
    """What stands right of "=": one value, or a list for an array; kind: "", "SET" or "REP"; None:
    a gap in the list."""

    entries: list[Entry | None]
    kind: str = ""


@dataclass(frozen=True)
class Jump:
    """GOTOF and its kin: where to (a label or block number, or an expression that gives one), and
    on which condition."""

    kind: str
    target: str
    computed: Node | None
    condition: Node | None
    start: int
    stop: int


@dataclass(frozen=True)
class Call:
    """A subprogram, by its name or by a string; its values; how often."""

    name: str
    computed: Node | None
    values: list[Entry | None]
    count: Node | None
    start: int
    stop: int


@dataclass
class Statement:
    """A line. `pieces`: what is executed in this order, and the text that stands in its place then
    ("": none). `ends`: M2, M17, M30. `control`: the keyword of a control line, and `parts` what
    belongs to it."""

    text: str
    code: int  # offset where the code ends and the comment begins
    pieces: list[tuple[int, int, Callable[[Scope], str]]] = field(default_factory=list)
    jumps: list[Jump] = field(default_factory=list)
    call: Call | None = None
    ends: str = ""
    control: str = ""
    parts: tuple[Any, ...] = ()

    def written(self, scope: Scope) -> str | None:
        """The line with numbers in it; None where nothing is left to write. Executes its
        assignments."""
        if self.call or not self.pieces:
            return None if self.call else self.text
        out, at, removed = [], 0, False
        # pieces come from left to right: an assignment in a line holds for what stands behind it
        for start, stop, piece in self.pieces:
            try:
                text = piece(scope)
            except Refusal as e:
                raise e.placed(start, stop) from None
            out.append(self.text[at:start] + text)
            at = stop
            if not text:
                removed = True
                # the blanks behind what goes go along
                while at < self.code and self.text[at] in " \t":
                    at += 1
        out.append(self.text[at : self.code])
        code = "".join(out)
        # nothing went away: blanks at the end stay as they are
        if not removed:
            return code + self.text[self.code :]
        # nothing but a block number is left: the line goes, and with it its comment
        if EMPTY_CODE.fullmatch(code):
            return None
        return code + self.text[self.code :] if self.code < len(self.text) else code.rstrip(" \t")


def filled(
    text: str,
    start: int,
    stop: int,
    entries: Sequence[Entry | None],
    say: Callable[[Value], str],
    scope: Scope,
) -> str:
    """A part of a line with numbers in the place of the entries."""
    out, at = [], start
    for entry in entries:
        if entry and not entry.plain and (not entry.name or entry.name in scope.variables):
            out += [text[at : entry.start], say(entry.node(scope))]
            at = entry.stop
    return "".join(out) + text[at:stop]


# Whole: one branch to a kind of right side, with its refusals.
def assign(scope: Scope, target: Target, right: Right) -> None:
    """A variable or array takes what stands right of "="."""
    index = target.places(scope)
    # FELD=SET(..) begins at the first element
    if right.kind and not index and target.name in scope.variables:
        index = [0] * len(scope.variables[target.name].shape)
    variable, place = scope.find(target.name, index)
    if not right.kind:
        entry = right.entries[0]
        if entry is None or entry.wrapped:
            raise Refusal(
                f"{target.name} is a variable and takes one value",
                "write a number or an expression",
            )
        variable.values[place] = converted(variable.kind, entry.node(scope))
        return
    if not variable.shape:
        raise Refusal(
            f"{target.name} is no array and takes one value", "assign the values one by one"
        )
    values = [None if e is None else e.node(scope) for e in right.entries]
    room = len(variable.values) - place
    # REP(1.5) fills all from here on, REP(1.5, 4) four elements; SET(..) a list, with gaps that
    # stay
    if right.kind == "REP":
        count = room if len(values) < 2 or values[1] is None else rounded(values[1])
        values = values[:1] * max(0, min(count, room + 1))
    if len(values) > room:
        raise Refusal(
            f"the list is longer than the {room} elements from here to the end",
            "correct the list or the DEF",
        )
    for i, value in enumerate(values):
        if value is not None:
            variable.values[place + i] = converted(variable.kind, value)
