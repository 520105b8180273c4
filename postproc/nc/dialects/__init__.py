"""A dialect is data: what a control's words mean. One file each, found by its name."""

from __future__ import annotations

import importlib
import re
from dataclasses import field
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from postproc.errors import UsageError
from postproc.motions import CLOCKWISE, COUNTER, FEED, FOREIGN, HOLE, RAPID, SPLINE, THREAD
from postproc.nc.codes import (
    CALL,
    CYCLE_KEYS,
    END_OF_PROGRAM,
    FRAME_KEYS,
    KEYWORD,
    STAY_KEYS,
    Code,
    code_number,
)
from postproc.nc.grammar import PLAIN, Grammar
from postproc.records import record, replace

NO_GROUP, UNKNOWN = -1, -2
# of CYCLE_KEYS; all but the first go with the spindle
HOLES = ("drill", "tap", "there and back", "tap Z", "tap X", "engrave")
NONE = -1
LARGEST_G = KEYWORD + 400  # ten times the largest G number + 1, and keywords
NOTHING = LARGEST_G - 1  # no code has this number


@record
class Dialect:
    """How one family of controls reads a program.

    `codes`: the G codes it has. `m_codes`: M number to meaning; `m_refuses`: M number to the reason
    why not. `plane`: ten times the G code in force at the start. `increments`: letter of an
    incremental word to its axis. `dwell`: letters of the dwell time in a G4 block. `turns`: whether
    P counts full turns of an arc.
    `arc_tolerance_mm` and `arc_tolerance_relative`: start and end radius of an arc may differ
    by the former, and by more only within the latter, never by more than `arc_tolerance_most_mm`;
    `arc_tolerance_inch`: how many times as much, both, in blocks under G20; a smaller radius than
    `radius_tolerance_mm` is none, and R may be that much too short. `tool_offsets`: whether a T
    word selects an offset. `integer_notice`: what to tell who writes coordinates without a decimal
    point. `one_code_per_group`: whether two codes of a modal group in one block are an error (else
    the last one holds). `grammar`: how its text is cut into words. `language`: the module of
    postproc.nc.expand that runs its variables and loops ("": it has none). `expand_decimals`:
    decimals beyond the least increment that a written-out number may have. `integers`: a coordinate
    without a decimal point counts "units" or "least increments". `carried`: axes that are no slides
    (E of a printer), carried along. `signs`: regular expressions (upper case, ASCII) that tell its
    programs from others. `local_is_preset`: G52 is kept where G92 is. `extended_by_p`: G10 L20 P
    and G54.1 P name additional work offsets (Fanuc), and G10 P0 the external one. `extended_name`:
    of the work offsets that a code chooses by a number, its letter last (G15 H of Okuma).
    `last_holds`: letters that may stand in a block more than once, where the last one holds.
    `repeats`: letters that say how often a canned cycle is run. `letters`: further letters that are
    parameters of codes. `motion`: ten times the motion code that holds before a program names one.
    `increments_travel_shifts`: the first increment after TRANS goes along with the shift (SD42440
    of Siemens). `exact_stops`: ten times the codes that stop at the end of a motion (G61 G9 of
    Fanuc, G61.1 of LinuxCNC); G64 takes a modal one back.

    `threads_chained`: ten times the thread codes that go on in step with the spindle where one
    stands behind another, so that a thread may be cut into blocks; `threads_under`: ten times the
    codes of the group "path" under which they do, NONE for a program that names none.
    `thread_words`: letters of a thread's lead.

    `remarks`: like `signs`, but looked for in comments (a CAM program's or slicer's name); signs
    are looked for outside of them. `excludes`: like `signs`: what its programs never have.
    `holes_written_out`: whether `--expand` writes its canned cycles out (postproc.nc.cycles).
    `ends`: M codes after which nothing is read; `restarts`: likewise, unless P or `/` stands there,
    as the program begins again. `modal_motion`: whether a block may leave its motion code out; if
    not, every block and every added one must name it. `one_command`: a line is one command, its
    first G or M or T word, and all other words are its parameters. `m_takes`: what stands behind an
    M word in its line is that code's own affair (M92 X80, M204 P500), be it words, bare letters,
    lists or text; `m_text`: M numbers behind which even a G or M begins no other command (M117 G1
    is done). `bare_letters`: letters without a number are legal (G28 X Y). `first_turn`: P of an
    arc that has no further turns. `arc_centre`: how I J K are meant without G90.1 or G91.1:
    "incremental"; "pole": absolute, and kept from block to block. `length_letter`: whose number
    names the tool's length offset: "H" of G43; "D", at once (Siemens); "T", at once (Heidenhain,
    printers). `length_at_once`: that letter needs no G43 before it. `offset_letter`: whose number
    chooses the work offset by that name (E1 of Fadal), 0 for none. `carried_codes`: M codes that
    make the carried axes absolute and incremental; `carried_by_distance`: whether G90 and G91 do so
    too, the last one counts. `block_end`: a character that ends a block besides the line's end (*
    of DIN/ISO). `tip_frame`: where the tables stand while the axes of the tool point's frame are
    the machine's: "zero", "call" (as they stand when it is called), "" (not said: asked for where
    it matters); `plane_frame`: the same of tilted planes; `tip_codes`: M codes that switch the tool
    point on (True) and off.

    `homes`: printers and routers: where homing left the slides is where they stand when a program
    begins, and feeds before the axes have places pass as they are, counted. `home_named`: G28 and
    G30 take the axes that they name; without any, nobody says where the axes stand then.
    `home_z_over`: axes that homing Z may take to a place of its own (above the bed's middle).
    `g_takes`: like `m_takes`, for these G numbers. `skips_centre`: whether a centre word outside of
    the plane is passed over. `relative_with_distance`: G91 makes carried axes incremental whatever
    their own code says. `macro_refuses`: why macros can not be followed, as Grammar.macros numbers
    them. `tools_move`: T runs macros that may move the tool. `change_takes`: axes that M6 (and a T
    whose length holds at once) takes to a place of its own; `change_returns`: axes that it brings
    back as delivered, and not on every machine: read there, but no rapid gets a word of them before
    the program names them or feeds. `length_left_open`: where an axis stands whose tool length
    changes is not said until the program names its place (postproc/nc/lengths.py). `length_lapses`:
    ten times the codes that take the length back where they send its axis away (G28 G30 G53), until
    H names one again. `length_modal`: H by itself names another length while G43 or G44 is in
    force. `digits`: how many a number may have, 0: any. `counts`: mm and degrees of one least
    increment of a number without a point, inches of a tenth of it; 0: the machine's own.
    `other_codes_are_macros`: a G code that it has not, first in its line, is a file or macro of the
    machine, or nothing. `hole_from_start`: a hole without R is drilled from the level where the
    axis stands (the initial one). `returns_no_lower`: G98 goes back to R where that is above the
    initial level. `level_from_start`: R of a lathe's holes is a distance from there, a radius
    (Fanuc; Haas' is a place).
    `conditions`: lines behind if and while that are indented further run when the control says so.
    `drawn`: letters of a straight block that say a corner or the angle of the line, where the
    machine has no axis of that letter. `nose_in_tool`: a T word of six digits begins with the
    number of the nose radius (Okuma). `polar`: the letter of the second coordinate of polar
    interpolation, C or Y (face.py); `polar_group`: the modal group of the codes that begin and end
    it; `contour`: by how much the codes that move there are above G1 G2 G3 (Okuma's G101: 100), 0:
    they are these. `feed_along_first`: F is along X Y Z where any of them moves, else along U V W,
    else in degrees (feeds.py). `length_in_machine`: whether G53 leaves the length is a setting.
    """

    name: str
    title: str
    codes: tuple[Code, ...]
    m_codes: dict[int, str]
    m_refuses: dict[int, str] = field(default_factory=dict)
    plane: int = 170
    increments: dict[str, str] = field(default_factory=dict)
    dwell: str = "P"
    turns: bool = False
    arc_tolerance_mm: float = 0.01
    arc_tolerance_relative: float = 0.0
    arc_tolerance_most_mm: float = 0.01
    arc_tolerance_inch: float = 1.0
    radius_tolerance_mm: float = 0.001
    tool_offsets: bool = False
    integer_notice: str = ""
    one_code_per_group: bool = True
    grammar: Grammar = PLAIN
    language: str = ""
    expand_decimals: int = 0
    integers: str = "units"
    carried: tuple[str, ...] = ()
    signs: tuple[str, ...] = ()
    local_is_preset: bool = False
    extended_by_p: bool = False
    extended_name: str = "G54.1 P"
    last_holds: str = ""
    repeats: str = "L"
    letters: str = ""
    motion: int = NONE
    increments_travel_shifts: bool = False
    exact_stops: tuple[int, ...] = ()
    threads_chained: tuple[int, ...] = ()
    threads_under: tuple[int, ...] = (NONE, 640)
    thread_words: str = ""
    remarks: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    holes_written_out: bool = True
    ends: tuple[int, ...] = END_OF_PROGRAM
    restarts: tuple[int, ...] = ()
    modal_motion: bool = True
    one_command: bool = False
    m_takes: bool = False
    m_text: tuple[int, ...] = ()
    bare_letters: bool = False
    first_turn: int = 1
    # ten times G98 or G99 that holds in cycles before either is named; -1: G98, and not said
    returns: int = -1
    arc_centre: str = "incremental"
    length_letter: str = "H"
    length_at_once: bool = False
    offset_letter: str = ""
    carried_codes: tuple[int, ...] = ()
    carried_by_distance: bool = False
    block_end: str = ""
    tip_frame: str = "zero"
    plane_frame: str = ""
    tip_codes: dict[int, bool] = field(default_factory=dict)
    homes: bool = False
    home_named: bool = False
    home_z_over: str = ""
    g_takes: tuple[int, ...] = ()
    skips_centre: bool = False
    relative_with_distance: bool = False
    macro_refuses: tuple[str, ...] = ()
    tools_move: bool = False
    change_takes: str = ""
    change_returns: str = ""
    length_left_open: bool = False
    length_lapses: tuple[int, ...] = ()
    length_modal: bool = False
    digits: int = 0
    counts: float = 0.0
    other_codes_are_macros: bool = False
    hole_from_start: bool = False
    returns_no_lower: bool = False
    level_from_start: bool = False
    conditions: bool = False
    feed_along_first: bool = False
    drawn: str = ""
    nose_in_tool: bool = False
    polar: str = ""
    polar_group: str = "polar"
    contour: int = 0
    length_in_machine: bool = False

    @cached_property
    def shifts_at_once(self) -> list[int]:
        """Letters, as bytes, whose word alone changes a shift of the coordinates."""
        own = self.length_letter != "H"
        alone = self.length_at_once or self.length_modal
        lengths = {self.length_letter, "T"} if own else {"H"} if alone else set()
        return [ord(x) for x in {*lengths, *self.offset_letter}]

    @cached_property
    def by_number(self) -> dict[int, Code]:
        """G codes by ten times their number; of several spellings the one that is like no other."""
        return {code.number: code for code in sorted(self.codes, key=lambda code: not code.like)}

    @cached_property
    def groups(self) -> tuple[str, ...]:
        """Modal groups in the order of the table, each once."""
        return tuple(dict.fromkeys(code.group for code in self.codes if code.group))

    @cached_property
    def group_of(self) -> np.ndarray:
        """(LARGEST_G,) index of the modal group of G number / 10; NO_GROUP, or UNKNOWN for a code
        it has not."""
        table = np.full(LARGEST_G, UNKNOWN, dtype=np.int64)
        for code in self.codes:
            table[code.number] = self.groups.index(code.group) if code.group else NO_GROUP
        return table

    @cached_property
    def is_refused(self) -> np.ndarray:
        """(LARGEST_G,) True where the code is known but can not be followed."""
        table = np.zeros(LARGEST_G, dtype=bool)
        for code in self.codes:
            table[code.number] = bool(code.refuses) and not code.does
        return table

    @cached_property
    def refusing_groups(self) -> tuple[str, ...]:
        """Modal groups, but for that of motions, in which a code can not be followed or takes the
        axis words."""
        of = {code.group for code in self.codes if (code.refuses and not code.does) or code.takes}
        return tuple(group for group in self.groups if group in of and group != "motion")

    @cached_property
    def meant(self) -> np.ndarray:
        """(LARGEST_G,) the number that each written code counts as: another one where it is but
        another spelling, and NOTHING where the control has no such code, though it may have one
        that is like it (G20 of Siemens)."""
        table = np.full(LARGEST_G, NOTHING)
        for code in self.codes:
            table[code_number(code.word)] = code.number
        return table

    @cached_property
    def is_hole(self) -> np.ndarray:
        """(LARGEST_G,) canned cycles for holes."""
        table = np.zeros(LARGEST_G, dtype=bool)
        table[[code.number for code in self.codes if code.does in HOLES]] = True
        return table

    @cached_property
    def is_tap(self) -> np.ndarray:
        """(LARGEST_G,) cycles for holes whose feed is tied to the spindle."""
        table = np.zeros(LARGEST_G, dtype=bool)
        table[[code.number for code in self.codes if code.does in HOLES[1:]]] = True
        return table

    @cached_property
    def stays(self) -> dict[int, Code]:
        """By number: threading cycles, which stay as they are."""
        return {code.number: code for code in self.codes if code.does in STAY_KEYS}

    @cached_property
    def there_and_back(self) -> np.ndarray:
        """(LARGEST_G,) taps that go from where the axes stand to their words, and back there."""
        table = np.zeros(LARGEST_G, dtype=bool)
        table[[code.number for code in self.codes if code.does == "there and back"]] = True
        return table

    @cached_property
    def engraves(self) -> tuple[int, ...]:
        """Codes that engrave a text, each in its own block."""
        return tuple(code.number for code in self.codes if code.does == "engrave")

    @cached_property
    def hole_axis(self) -> dict[int, str]:
        """The axis of cycles, by number, that drill along the same one in every plane: those of
        lathes."""
        return {
            code.number: code.does[-1] for code in self.codes if code.does in ("tap Z", "tap X")
        }

    @cached_property
    def modal_stops(self) -> tuple[int, ...]:
        """Those of the exact stops that hold until G64."""
        return tuple(n for n in self.exact_stops if n in self.by_number and self.by_number[n].group)

    @cached_property
    def calls(self) -> tuple[int, ...]:
        """Ten times the G codes that hand the words of their block over to a macro."""
        sentence = CALL.partition(":")[0]
        return tuple(
            code_number(c.word)
            for c in self.codes
            if c.word[0] == "G" and c.refuses.startswith(sentence)
        )

    @cached_property
    def beside(self) -> tuple[int, ...]:
        """Codes by which the control shifts the path sideways by the tool's radius."""
        return tuple(
            code.number for code in self.codes if code.group == "cutter" and code.does == "cutter"
        )

    @cached_property
    def kind(self) -> np.ndarray:
        """(LARGEST_G,) what a motion code makes of a motion: a value of postproc.motions."""
        table = np.full(LARGEST_G, FOREIGN, np.int8)
        table[[0, 10, 20, 30]] = RAPID, FEED, CLOCKWISE, COUNTER
        for code in self.codes:
            if code.does in (*CYCLE_KEYS, "spline"):
                table[code.number] = {"thread": THREAD, "spline": SPLINE}.get(code.does, HOLE)
        return table

    @cached_property
    def frame_codes(self) -> dict[int, str]:
        """Numbers of the codes that shift the coordinates, and what each does."""
        return {code.number: code.does for code in self.codes if code.does in FRAME_KEYS}

    @cached_property
    def begins_segment(self) -> np.ndarray:
        """(LARGEST_G,) codes, as written, whose block begins a segment: the shifts change there, or
        cycles begin or end."""
        table = np.zeros(LARGEST_G, dtype=bool)
        cycles = any(code.does in HOLES for code in self.codes)
        for code in self.codes:
            table[code_number(code.word)] = (
                code.does in FRAME_KEYS
                or code.does in STAY_KEYS
                or (self.extended_by_p and code.number == 540)
                or (cycles and (code.does in CYCLE_KEYS or code.number == 800))
            )
        return table


def names() -> list[str]:
    """The dialects that there are, as a user writes them."""
    here = Path(__file__).parent
    return sorted(x.stem.replace("_", "-") for x in here.glob("*.py") if x.stem != "__init__")


@lru_cache
def load(name: str) -> Dialect:
    """The dialect called `name`. Raises UsageError with the names that there are."""
    if name not in names():
        raise UsageError(f"there is no dialect {name!r}", f"dialects: {', '.join(names())}")
    dialect: Dialect = importlib.import_module(f"{__name__}.{name.replace('-', '_')}").DIALECT
    return replace(dialect, grammar=_grammar(dialect))


def _grammar(dialect: Dialect) -> Grammar:
    """The grammar with what the dialect's own fields say about its text."""
    ignores = dialect.grammar.ignores
    head = r"^[ \t]*(?:N[ \t]*[0-9]+[ \t]*)?"
    if dialect.g_takes:
        numbers = "|".join(map(str, dialect.g_takes))
        ignores += (head + rf"(G[ \t]*0*(?:{numbers}))(?![0-9.])[^;{dialect.block_end}\n]*",)
    if dialect.m_takes:
        if text := "|".join(map(str, dialect.m_text)):
            ignores += (head + rf"(M[ \t]*0*(?:{text}))(?![0-9])[^;\n]*",)
        rest = r"[^;\n]" if dialect.one_command else r"(?![GM][ \t]*[0-9])[^;\n]"
        ignores += (head + rf"(M[ \t]*[0-9]+(?:\.[0-9]+)?)(?:{rest})*",)
    macros = dialect.grammar.macros
    if dialect.other_codes_are_macros:
        own = "|".join(re.escape(code.word[1:]) for code in dialect.codes)
        alone = "" if dialect.one_command else r"(?![^;\n]*[GM][ \t]*[0-9])"
        macros += (
            (
                (
                    rf"^([ \t]*N[ \t]*[0-9]+)?[ \t]*G(?![ \t]*0*(?:{own})(?![0-9.]))["
                    rf" \t]*[0-9.]+{alone}[^;\n]*"
                ),
                0,
            ),
        )
    return replace(
        dialect.grammar,
        macros=macros,
        ignores=ignores,
        bare_letters=dialect.bare_letters,
        block_end=dialect.block_end,
        machine_variables=dialect.language in ("linuxcnc", "fanuc"),
    )
