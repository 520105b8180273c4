"""Fanuc's parameters and compensation numbers as text: CSV, G10 programs, and the N..P.. records of
a memory card.

Knows numbers and where they stand; what they do is said in fanuc.py. No control.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from postproc.control_tables import ExportOptions
from postproc.control_tables import _common as common
from postproc.errors import UsageError
from postproc.recordings import Source

MEANING = {
    1851: "backlash compensation",
    1852: "backlash compensation at rapid",
    3605: "bit 0: tables by direction",
    3620: "pitch table number of the reference position",
    3621: "smallest table number",
    3622: "largest table number",
    3623: "magnification",
    3624: "interval in um",
    3625: "",
    3626: "smallest table number for travel in -",
    3627: "compensation at the reference from the other side",
}
ORDER = (3605, 3620, 3621, 3622, 3623, 3624, 3625, 3626, 3627, 1851, 1852)
#     program, l50        program, l52           memory card        CSV
#     G10 L50             G10 L52                N03620 A1 P100     axis,parameter_no,value
#     N3620 P1 R100       N3624 P1 R20.0000      N10051 P1          X,51,1
#     N10051 R1           G11
#     G11                 G10 L50
#                         N10051 R1
#                         G11
PITCH = 10000  # N10051 is compensation number 51
LAST = 1535
WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
RECORD = re.compile(rf"(?=N)(?:{WORD.pattern}\s*)+")
LETTERS = {True: ("P", "R"), False: ("A", "P")}  # axis and value, in a program and on a card
EMPTY = re.compile(r"|%|[O:]\d+|M30|M02|M99|M2")  # a block without numbers to enter


@dataclass
class Listing:
    """settings: axis to parameter number to value; pitch: compensation number to increment; owner:
    the axis that the file itself states for it; line: compensation number to its line; points:
    parameters whose value bore a decimal point, so that it is a length and not a count."""

    source: Source
    settings: dict[str, dict[int, float]] = field(default_factory=dict)
    pitch: dict[int, int] = field(default_factory=dict)
    owner: dict[int, str] = field(default_factory=dict)
    line: dict[int, int] = field(default_factory=dict)
    lengths: set[tuple[str, int]] = field(default_factory=set)

    def take(self, at: common.Line, number: int, value: str, axis: str, pitch: bool) -> None:
        """One number of the file. Raises TableError where it can not be one, or stands twice."""
        amount = at.finite(value, "the value")
        if pitch:
            self._increment(at, number, value, amount)
            if axis:
                self.owner[number] = axis
            return
        if number not in MEANING:
            raise at.fault(
                f"parameter {number} is none of pitch error or backlash compensation",
                f"parameters: {', '.join(map(str, sorted(MEANING)))}",
            )
        known = self.settings.setdefault(axis, {})
        if number in known:
            raise at.fault(f"parameter {number} of {axis} stands twice")
        known[number] = amount
        # 3624 with a point is a length in mm or inch, without one a count of least increments
        # (Listing).
        if "." in value:
            self.lengths.add((axis, number))
        elif amount != int(amount):
            raise at.fault(f"parameter {number} = {value} is not a whole number")

    def _increment(self, at: common.Line, number: int, value: str, amount: float) -> None:
        """One compensation number."""
        if not 0 <= number <= LAST:
            raise at.fault(f"compensation number {number} is not between 0 and {LAST}")
        if amount != int(amount) or not -128 <= amount <= 127:
            raise at.fault(
                f"{value} is not an increment of pitch error compensation",
                "a whole number from -128 to 127",
            )
        if number in self.pitch:
            raise at.fault(f"compensation number {number} stands twice")
        self.pitch[number], self.line[number] = int(amount), at.number


def parse(source: Source, options: ExportOptions) -> Listing:
    """Any of the forms, told by how they begin. Raises TableError with file and line."""
    lines = common.numbered(source)
    listing = Listing(source)
    head = next(at.text for at in lines if at.text.strip())
    if head.lower().startswith("axis,"):
        _csv_pitch(listing, source, lines)
        if settings := options.extra.get("settings", ""):
            other = Source(options.extra.get("settings_name", "settings"), settings.encode())
            _csv_settings(listing, other, common.numbered(other))
    elif head.lower().startswith("parameter_no,"):
        _csv_settings(listing, source, lines)
    else:
        _words(listing, source, lines, options)
    return listing


def _cells(lines: list[common.Line]) -> tuple[list[str], list[tuple[common.Line, list[str]]]]:
    """The heading, and the rows below it."""
    rows = list(common.csv_rows(lines))
    return (rows[0][1] if rows else []), rows[1:]


def _csv_pitch(listing: Listing, source: Source, lines: list[common.Line]) -> None:
    header, rows = _cells(lines)
    if header != ["axis", "parameter_no", "value"]:
        raise common.fault(
            source, 1, f"the columns are {', '.join(header)}", "axis,parameter_no,value"
        )
    for at, (axis, name, value) in rows:
        if not re.fullmatch(r"[A-Za-z]", axis) or not name.isdigit():
            raise at.fault(f"{axis},{name} is not an axis and a number", "like X,51,0")
        listing.take(at, int(name), value, axis.upper(), pitch=int(name) not in MEANING)


def _csv_settings(listing: Listing, source: Source, lines: list[common.Line]) -> None:
    header, rows = _cells(lines)
    axes = [name.upper() for name in header[2:]]
    known = header[:2] == ["parameter_no", "meaning"]
    if not known or not axes or not all(re.fullmatch("[A-Z]", a) for a in axes):
        raise common.fault(
            source, 1, f"the columns are {', '.join(header)}", "parameter_no,meaning,x,y,z"
        )
    for at, cells in rows:
        if not cells[0].isdigit():
            raise at.fault(f"{cells[0]!r} is not a parameter number")
        for axis, value in zip(axes, cells[2:], strict=True):
            if value:
                listing.take(at, int(cells[0]), value, axis, pitch=False)


def _words(
    listing: Listing, source: Source, lines: list[common.Line], options: ExportOptions
) -> None:
    """N10051 R1 and N3620 P1 R100 between G10 L50 (or L52) and G11; N10051 P1 and N3620 A1 P100 A2
    P200 between %."""
    axes = axis_order(options)
    program = any("G10" in _plain(at.text).replace(" ", "") for at in lines)
    entering = not program
    for at in lines:
        plain = _plain(at.text)
        if EMPTY.fullmatch(plain):
            continue
        if program and re.fullmatch(r"G10\s*L(50|52)|G11", plain):
            entering = plain != "G11"
            continue
        if not entering or not RECORD.fullmatch(plain):
            raise at.fault(
                f"this is no parameter or compensation number{' between G10 and G11' * program}",
                "like N10051 R1 in G10 L50, or N10051 P1",
            )
        _record(listing, at, WORD.findall(plain), LETTERS[program], axes)
    if program and entering:
        raise common.fault(source, lines[-1].number, "G11 is missing: the program is not whole")


def _plain(text: str) -> str:
    """A block without comments and its end, in capitals."""
    return re.sub(r"\([^)]*\)", "", text).strip().rstrip(";").strip().upper()


def _record(
    listing: Listing,
    at: common.Line,
    words: list[tuple[str, str]],
    form: tuple[str, str],
    axes: str,
) -> None:
    """N and its number: a compensation number, or a parameter of one axis or several. form: letters
    of an axis' number and of a value; axes: in the control's order."""
    number, rest = int(float(words[0][1])), words[1:]
    first, second = form
    if number >= PITCH:
        value = [v for letter, v in rest if letter == second]
        if len(value) != 1:
            raise at.fault(f"N{number} has no value")
        listing.take(at, number - PITCH, value[0], "", pitch=True)
        return
    if not rest or [letter for letter, _ in rest] != [first, second] * (len(rest) // 2):
        raise at.fault(f"parameter {number} needs {first} axis and {second} value")
    for (_, axis), (_, value_) in zip(rest[::2], rest[1::2], strict=True):
        index = int(float(axis))
        if not 1 <= index <= len(axes):
            raise at.fault(
                f"there is no axis number {index}: axes are {', '.join(axes)}", "--set axes=XZ"
            )
        listing.take(at, number, value_, axes[index - 1], pitch=False)


def axis_order(options: ExportOptions) -> str:
    """Letters of the control's axes 1, 2, 3 ...: --set axes=XZ, else XYZ."""
    axes = options.extra.get("axes", "XYZ").upper()
    if not re.fullmatch("[A-Z]+", axes) or len(set(axes)) != len(axes):
        raise UsageError(
            f"axes = {axes!r} is not the axes' letters in the control's order", "--set axes=XYZ"
        )
    return axes


def csv_files(
    settings: dict[str, dict[int, float]], pitch: dict[str, dict[int, int]], name: str
) -> dict[str, bytes]:
    """The two CSV files: compensation numbers by axis, and the parameters, a column an axis."""
    rows = [
        f"{axis},{n},{v}" for axis, numbers in pitch.items() for n, v in sorted(numbers.items())
    ]
    table = ["parameter_no,meaning," + ",".join(axis.lower() for axis in settings)]
    for number in ORDER:
        if any(number in known for known in settings.values()):
            cells = [
                f"{settings[axis][number]:.0f}" if number in settings[axis] else ""
                for axis in settings
            ]
            table.append(f"{number},{MEANING[number]}," + ",".join(cells))
    return {
        f"{name}_pitch.csv": common.text_of(["axis,parameter_no,value", *rows]),
        f"{name}_settings.csv": common.text_of(table),
    }


def g10(
    settings: dict[str, dict[int, float]],
    pitch: dict[str, dict[int, int]],
    comments: list[str],
    options: ExportOptions,
    form: str,
) -> bytes:
    """A program that enters the numbers: G10 L50 (0i 16i 18i), or L52 for parameters and L50 for
    pitch numbers (30i, 0i-F)."""
    axes = axis_order(options)
    lines = ["%", f"O{common.whole(options, 'program_number', 7900, 1, 9999):04d}"]
    # capitals, digits and a few signs: no bracket may end the comment
    lines += [f"({re.sub('[^A-Z0-9 .,:=+/-]', ' ', text.upper())})" for text in comments]
    lines.append("G10 L52" if form == "l52" else "G10 L50")
    for number in ORDER:
        if number == 3605:
            continue  # the other bits of that byte would be overwritten
        for axis, known in settings.items():
            if number in known:
                lines.append(
                    f"N{number} P{axes.index(axis) + 1}"
                    f" R{_value(number, known[number], form, options)}"
                )
    if form == "l52":
        lines += ["G11", "G10 L50"]
    lines += [
        f"N{PITCH + n} R{v}" for numbers in pitch.values() for n, v in sorted(numbers.items())
    ]
    return common.text_of([*lines, "G11", "M30", "%"])


def _value(number: int, value: float, form: str, options: ExportOptions) -> str:
    if number == 3624 and form == "l52":  # a length with a decimal point on these controls
        return f"{value * increment(options) / common.mm_per_unit(options):.4f}"
    return f"{value:.0f}"


def records(
    settings: dict[str, dict[int, float]], pitch: dict[str, dict[int, int]], options: ExportOptions
) -> bytes:
    """The records of a memory card: N3620 A1 P100 A2 P200, N10051 P1."""
    axes = axis_order(options)
    lines = ["%"]
    for number in ORDER:
        have = [
            (axes.index(axis) + 1, known[number])
            for axis, known in settings.items()
            if number in known
        ]
        if have and number != 3605:
            lines.append(f"N{number:05d} " + " ".join(f"A{i} P{v:.0f}" for i, v in sorted(have)))
    lines += [
        f"N{PITCH + n} P{v}" for numbers in pitch.values() for n, v in sorted(numbers.items())
    ]
    return common.text_of([*lines, "%"])


def increment(options: ExportOptions) -> float:
    """mm of the least input increment, in which 3624 is counted: 0.001 mm or 0.0001 inch, or --set
    increment_mm=."""
    usual = 0.001 if options.unit == "mm" else 0.0001 * common.mm_per_unit(options)
    return common.number(options, "increment_mm", usual, 1e-6, 0.1)
