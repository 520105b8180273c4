"""Sinumerik 840D programs written out: R parameters, variables, control structures, jumps,
subprograms.

Lines come in the order in which the control executes them, with a number in the place of every
expression; definitions, assignments, labels and control lines vanish. What only the control knows
(system variables, variables of its memory, R parameters that the program has not set, subprograms
that are not beside it) is refused by name and never guessed.

Source: Siemens "SINUMERIK 840D sl / 828D", programming manuals "Fundamentals" and "Job Planning".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from postproc.errors import BlockFault
from postproc.nc.expand import Limits, Line, Program, Refusal
from postproc.nc.expand.siemens_contour import contour_of
from postproc.nc.expand.siemens_flow import Declaration, Parameter, read
from postproc.nc.expand.siemens_frames import Frame, Repeat
from postproc.nc.expand.siemens_holes import HOLES, NAMES, Holes
from postproc.nc.expand.siemens_source import Source, missing
from postproc.nc.expand.siemens_statements import Call, Jump, Statement, Target, assign
from postproc.nc.expand.siemens_values import (
    EMPTY,
    LARGEST_ARRAY,
    Scope,
    Value,
    Variable,
    converted,
    equal,
    less,
    numeric,
    rounded,
    truth,
)
from postproc.nc.expand.tracker import Tracker

# Words with a number, and a comment: nothing to execute. R and L are variables and calls, M2 M17
# M30 end the program, and codes for inch and millimetre change how numbers are written.
PLAIN = re.compile(
    rb"""[ \t]*+(?:(?:[A-FH-KNOPQS-Z](?:\d{0,2}+[ \t]*+=(?!=))?[ \t]*+[+-]?(?>\d++\.?\d*+|\.\d++)
    |G(?!0*(?:20|21|70|71|700|710)(?!\d))\d++(?:\.\d++)?|M(?!0*(?:2|17|30)(?!\d))\d++|CR[ \t]*+=[ \t]*+[+-]?(?>\d++\.?\d*+|\.\d++)
    )[ \t]*+)*+(?:;.*+)?""",  # noqa: E501
    re.VERBOSE | re.IGNORECASE,
)
UNITS = re.compile(r"(?<![A-Z_])G[ \t]*(?:=|0*(?:20|21|70|71|700|710)(?!\d))", re.IGNORECASE)
FILE_NAME = re.compile(r"(?:.*/)?(?:_N_)?(.*?)(?:[_.](?:SPF|MPF|CYC))?", re.IGNORECASE | re.DOTALL)
MOST_KEPT = 5_000  # lines of a program that are kept as they were understood
MOST_PASSES = 9999


def lines(program: Program, tracker: Tracker, limits: Limits) -> Iterator[Line]:
    """The plain lines of a program. Raises ProgramError where it can not be run, or runs beyond the
    limits."""
    return Run(program, tracker, limits).lines()


def _before(error: Refusal | BlockFault) -> Refusal:
    """What is wrong; the tracker has followed the lines up to here only when it was asked."""
    if isinstance(error, Refusal):
        return error
    return Refusal(f"a line before this one can not be followed: {error.message}", error.advice)


class Run:
    """One execution of a program."""

    def __init__(self, program: Program, tracker: Tracker, limits: Limits):
        self.program, self.tracker, self.limits = program, tracker, limits
        self.sources: dict[str, Source | None] = {}
        self.kept: dict[tuple[str, int], Statement] = {}
        self.skips = bool(tracker.setup.block_delete)
        self.scope = Scope(tracker, {}, {})
        main = Source(program.name, "", program.whole_lines(), self.skips)
        self.frames = [Frame(main, self.scope)]
        self.holes = Holes(tracker)

    def lines(self) -> Iterator[Line]:
        """The plain lines."""
        steps, limit, plain = 0, self.limits.steps, PLAIN.fullmatch
        while self.frames:
            frame = self.frames[-1]
            source, at = frame.source, frame.at
            steps += 1
            if at >= len(source.lines):
                self.leave()
                continue
            raw = source.lines[at]
            if steps > limit:
                raise self.limits.endless().at(source.name, at + 1, raw)
            # nothing to execute in it: it leaves as it stands, which nearly all lines do
            if plain(raw):
                yield from self.drilled(frame, Line(raw, at + 1, source.file))
                if frame.repeats:
                    frame.step()
                else:
                    frame.at = at + 1
                continue
            try:
                text = self.execute(frame, raw)
            except (Refusal, BlockFault) as e:
                raise _before(e).at(source.name, at + 1, raw) from None
            if text is not None or self.holes.called:
                yield from self.drilled(
                    frame, Line(text or b"", at + 1, source.file), text is not None
                )

    def drilled(self, frame: Frame, line: Line, own: bool = True) -> Iterator[Line]:
        """A line, and the hole that is drilled behind it. own: whether the line itself is to be
        written."""
        if own:
            yield line
        try:
            for text in self.holes.behind(frame, line.text, own):
                yield Line(text, line.source, line.file)
        except (Refusal, BlockFault) as e:
            source, at = frame.source, line.source
            raise _before(e).at(source.name, at, source.lines[at - 1]) from None

    def execute(self, frame: Frame, raw: bytes) -> bytes | None:
        """Execute the line at which the frame stands: its plain text, if any, and where control
        goes."""
        at, scope = frame.at, frame.scope
        if self.skips and raw.lstrip(b" \t").startswith(b"/"):
            frame.step()
            return raw
        key = (frame.source.file, at)
        # read once, executed as often as control comes by: loops of many passes are quick by it
        statement = self.kept.get(key)
        if statement is None:
            if len(self.kept) >= MOST_KEPT:
                self.kept.clear()
            statement = self.kept[key] = read(raw.decode("latin-1"))
        if statement.control:
            CONTROL[statement.control](self, frame, statement)
            return None
        text = statement.written(scope)
        if UNITS.search(statement.text, 0, statement.code):
            scope.decimals.clear()
        if statement.call:
            self.call(frame, statement.call)
        elif statement.ends:
            if scope.inner and statement.ends not in ("M17", "RET"):
                message = f"{statement.ends} stands in a subprogram"
                raise Refusal(
                    message,
                    "end a subprogram with M17 or RET: what a control does here depends on it",
                )
            if scope.inner:
                self.leave()
            else:
                self.frames.clear()
        else:
            self.jump(frame, statement.jumps)
        return None if text is None else raw if text == statement.text else text.encode("latin-1")

    # -- where control goes ------------------------------------------------------------------------

    def jump(self, frame: Frame, jumps: list[Jump]) -> None:
        """Go where the first jump leads whose condition is true; else to the next line."""
        at, scope = frame.at, frame.scope
        for jump in jumps:
            if jump.condition and not truth(jump.condition(scope)):
                continue
            target = jump.target
            # GOTOF ZIEL goes to the label ZIEL, or to the one that a string of that name holds
            if jump.computed or (
                target in scope.variables and scope.variables[target].kind == "STRING"
            ):
                found = jump.computed(scope) if jump.computed else scope.variables[target].values[0]
                if not isinstance(found, str):
                    raise Refusal(
                        "the destination of a jump is a name or a string",
                        "correct it",
                        jump.start,
                        jump.stop,
                    )
                target = found
            to = frame.source.destination(jump, target, at)
            if to is not None:
                frame.go(at, to)
                return
        frame.step()

    def leave(self) -> None:
        """A program is at its end: again, or back behind the line that called it."""
        # P3: two more passes, each as a frame of its own, before the caller goes on
        frame = self.frames.pop()
        if frame.passes > 1 and frame.new_scope:
            # the next pass has variables of its own, as if it were called again
            self.frames.append(
                Frame(
                    frame.source,
                    frame.new_scope(),
                    passes=frame.passes - 1,
                    new_scope=frame.new_scope,
                )
            )
        elif self.frames:
            self.frames[-1].step()

    def nested(self, frame: Frame) -> None:
        """Raises Refusal where calls and repeated sections are nested too deep."""
        if max(len(self.frames), len(frame.repeats)) > self.limits.depth:
            raise self.limits.too_deep()

    def call(self, frame: Frame, call: Call) -> None:
        """A subprogram from the same folder."""
        name = call.name
        if call.computed:
            value = call.computed(frame.scope)
            if not isinstance(value, str):
                raise Refusal(
                    "CALL takes the name of a program as a string",
                    "correct it",
                    call.start,
                    call.stop,
                )
            name = value
        found = FILE_NAME.fullmatch(name)
        name = found[1] if found else name
        # a program of this name beside the main one goes before the control's own cycle
        if name.upper() in NAMES and self.library(name) is None:
            contour = contour_of(frame, self.library, call)
            around = frame.source.around(frame.at)
            self.holes.call(name.upper(), self.values(frame, call), contour, around)
            frame.step()
            return
        passes = 1 if call.count is None else rounded(call.count(frame.scope))
        if not 0 <= passes <= MOST_PASSES:
            raise Refusal(
                f"P {passes} is not a number of passes",
                f"0 to {MOST_PASSES}",
                call.start,
                call.stop,
            )
        source = self.library(name)
        if source is None:
            raise missing(name, call.start, call.stop)
        self.nested(frame)
        if passes == 0:
            frame.step()
            return
        parameters = self.parameters(source)
        if len(call.values) > len(parameters) and any(call.values):
            message = f"{name} takes {len(parameters)} values, here are {len(call.values)}"
            raise Refusal(
                message, f"correct the call, or the PROC line of {name}", call.start, call.stop
            )
        # left-out values are those of PROC's "=", or empty
        given = call.values + [None] * len(parameters)
        shared, outer = self.scope, frame.scope

        def scope() -> Scope:
            inner = Scope(self.tracker, shared.parameters, shared.decimals, inner=True)
            for parameter, entry in zip(parameters, given, strict=False):
                node = entry.node if entry else parameter.default
                if parameter.reference and entry:
                    # VAR: both names are one variable, so that what the subprogram sets the caller
                    # sees
                    alias = outer.variables.get(entry.name)
                    if alias is None or alias.kind != parameter.kind:
                        message = (
                            f"{parameter.name} of {name} takes a variable of type {parameter.kind}"
                            " by its name"
                        )
                        raise Refusal(
                            message, "define one and give its name", entry.start, entry.stop
                        )
                    inner.variables[parameter.name] = alias
                else:
                    value = (
                        EMPTY[parameter.kind]
                        if node is None
                        else converted(parameter.kind, node(outer))
                    )
                    inner.variables[parameter.name] = Variable(parameter.kind, (), [value])
            return inner

        self.frames.append(Frame(source, scope(), passes=passes, new_scope=scope))

    def values(self, frame: Frame, call: Call) -> list[Value | None]:
        """What a call hands over, None: left out."""
        return [entry.node(frame.scope) if entry else None for entry in call.values]

    def modal_call(self, frame: Frame, statement: Statement) -> None:
        """MCALL."""
        call = statement.call
        name = call.name.upper() if call else ""
        self.holes.modal = (frame, HOLES[name].of(name, self.values(frame, call))) if call else None
        frame.step()

    def library(self, name: str) -> Source | None:
        """A subprogram's text, read once."""
        key = name.upper()
        if key not in self.sources:
            text = self.program.library(name) if name else None
            lines = Program(name, text).whole_lines() if text is not None else None
            self.sources[key] = None if lines is None else Source(name, name, lines, self.skips)
        return self.sources[key]

    def parameters(self, source: Source) -> tuple[Parameter, ...]:
        """What the PROC line of a subprogram says, if it has one."""
        for i, raw in enumerate(source.lines):
            if re.match(rb"[ \t]*(?:N\d+[ \t]*)?PROC[ \t]", raw, re.IGNORECASE):
                try:
                    return read(raw.decode("latin-1")).parts
                except Refusal as e:
                    raise e.at(source.name, i + 1, raw) from None
        return ()

    # -- control lines -----------------------------------------------------------------------------

    def nothing(self, frame: Frame, statement: Statement) -> None:
        """Lines that only mark a place."""
        if statement.control not in ("PROC", "EXTERN"):
            frame.source.partner(frame.at)
        frame.step()

    def define(self, frame: Frame, statement: Statement) -> None:
        """DEF."""
        declaration: Declaration
        for declaration in statement.parts:
            try:
                self.declare(frame.scope, declaration)
            except Refusal as e:
                raise e.placed(declaration.start, declaration.stop) from None
        frame.step()

    def declare(self, scope: Scope, declaration: Declaration) -> None:
        """One variable, with its first value."""
        kind, name, right = declaration.kind, declaration.name, declaration.right
        # () of a plain variable; sizes may be expressions, which the DEF works out when it is met
        shape = tuple(rounded(size(scope)) for size in declaration.sizes)
        count = 1
        for length in shape:
            count *= length
            if not 1 <= length <= LARGEST_ARRAY or count > LARGEST_ARRAY:
                raise Refusal(f"an array of {count} elements", f"1 to {LARGEST_ARRAY} are possible")
        if name[0] != "R" or not name[1:].isdigit():
            scope.variables[name] = Variable(kind, shape, [EMPTY[kind]] * count)
        if right:
            assign(scope, Target(name, [], declaration.start, declaration.stop), right)

    def test(self, frame: Frame, statement: Statement) -> None:
        """IF, WHILE: into it, or behind its end or its ELSE."""
        partner = frame.source.partner(frame.at)  # of IF its ELSE or ENDIF
        frame.go(frame.at, frame.at + 1 if truth(statement.parts[0](frame.scope)) else partner + 1)

    def to_partner(self, frame: Frame, statement: Statement) -> None:
        """ELSE, ENDLOOP, ENDWHILE: to the other end."""
        frame.go(frame.at, frame.source.partner(frame.at) + (statement.control == "ELSE"))

    def until(self, frame: Frame, statement: Statement) -> None:
        """UNTIL: on, or back to the line behind REPEAT."""
        begin = frame.source.partner(frame.at)
        frame.go(frame.at, frame.at + 1 if truth(statement.parts[0](frame.scope)) else begin + 1)

    def count(self, frame: Frame, statement: Statement) -> None:
        """FOR: the first pass."""
        target, first, last = statement.parts
        frame.source.partner(frame.at)
        assign(frame.scope, target, first)
        frame.ends[frame.at] = numeric(last(frame.scope))
        self.pass_on(frame, frame.at, target)

    def count_on(self, frame: Frame, statement: Statement) -> None:
        """ENDFOR: the counter goes up by one, and the next pass begins while it is not above the
        end."""
        begin = frame.source.partner(frame.at)
        target, _, last = self.counting(frame, begin).parts
        # refused where it matters whether the end value is worked out once or in every pass
        end = frame.ends.get(begin)
        if end is None or not equal(end, numeric(last(frame.scope))):
            message = (
                "a jump leads into the loop"
                if end is None
                else "the end value of FOR changes within the loop"
            )
            raise Refusal(message, "write the loop with WHILE")
        variable, place = frame.scope.find(target.name, target.places(frame.scope))
        variable.values[place] = converted(variable.kind, numeric(variable.values[place] or 0) + 1)
        self.pass_on(frame, begin, target)

    def counting(self, frame: Frame, begin: int) -> Statement:
        """The FOR line of a loop."""
        return self.kept.get((frame.source.file, begin)) or read(
            frame.source.lines[begin].decode("latin-1")
        )

    def pass_on(self, frame: Frame, begin: int, target: Target) -> None:
        variable, place = frame.scope.find(target.name, target.places(frame.scope))
        behind = frame.source.partner(begin) + 1
        frame.go(
            frame.at,
            behind if less(frame.ends[begin], numeric(variable.values[place] or 0)) else begin + 1,
        )

    def case(self, frame: Frame, statement: Statement) -> None:
        """CASE OF DEFAULT: the jump of the first constant that is equal."""
        tested, cases, default = statement.parts
        value = tested(frame.scope)
        chosen = next(
            (jump for constant, jump in cases if equal(value, constant(frame.scope))), default
        )
        self.jump(frame, [chosen] if chosen else [])

    def repeat(self, frame: Frame, statement: Statement) -> None:
        """REPEAT with labels, REPEATB: a part of the program again."""
        first, last, count = statement.parts
        start, stop = frame.source.section(first, last, frame.at)
        if statement.control == "REPEATB":
            stop = start
        passes = 1 if count is None else rounded(count(frame.scope))
        if passes < 1:
            frame.step()
            return
        frame.repeats.append(Repeat(start, stop, passes, frame.at))
        self.nested(frame)
        frame.at = start


CONTROL: dict[str, Callable[[Run, Frame, Statement], None]] = {
    **dict.fromkeys(("PROC", "EXTERN", "ENDIF", "LOOP"), Run.nothing),
    "REPEAT": Run.nothing,
    "DEF": Run.define,
    "IF": Run.test,
    "WHILE": Run.test,
    "ELSE": Run.to_partner,
    "ENDLOOP": Run.to_partner,
    "ENDWHILE": Run.to_partner,
    "UNTIL": Run.until,
    "FOR": Run.count,
    "ENDFOR": Run.count_on,
    "CASE": Run.case,
    "REPEAT SECTION": Run.repeat,
    "REPEATB": Run.repeat,
    "MCALL": Run.modal_call,
}
