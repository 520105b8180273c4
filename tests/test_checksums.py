"""Numbers and checksums of host streams: what a receiver accepts, and that nothing else is
touched."""

from __future__ import annotations

import re
from functools import reduce
from operator import xor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.nc.checksums import START, Numbering, bare, check, cover, renumber


def sealed(code: bytes, tail: bytes = b"") -> bytes:
    """A line with its checksum."""
    return b"%s*%d%s\n" % (code, reduce(xor, code, 0), tail)


def printer(dialect: str = "marlin") -> Filter:
    machine = places.load("example-printer").carrying(("E",))
    return Filter(machine, dialects.load(dialect), setup_of(machine))


class Receiver:
    """Marlin's line check, from get_serial_commands in queue.cpp: comments cut, leading spaces
    skipped, then N, then *."""

    def __init__(self):
        self.last = 0
        self.taken: list[bytes] = []

    def take(self, text: bytes) -> None:
        for line in re.split(rb"[\r\n]+", text):
            command = line.partition(b";")[0].lstrip(b" ")
            if not command:
                continue
            if command.startswith(b"N"):
                at = 0
                reset = b"M110" in command
                if reset and command.find(b"N", 4) >= 0:
                    at = command.find(b"N", 4)
                number = int(re.match(rb"[ ]*([+-]?\d+)", command[at + 1 :])[1])
                assert reset or number == self.last + 1, f"N{number} after {self.last}: {line}"
                star = command.rfind(b"*")
                assert star >= 0, f"no checksum: {line}"
                assert int(command[star + 1 :]) == reduce(xor, command[:star], 0), (
                    f"checksum: {line}"
                )
                self.last = number
            self.taken.append(re.sub(rb"^N[+-]?\d+ *|\*.*", b"", command).strip())


# -- by hand ---------------------------------------------------------------------------------------


def test_the_checksum_of_marlins_manual():
    line = b"N3 T0*57 ; a comment\n"  # reprap.org/wiki/G-code, "N and *"
    assert check(line) is None
    assert check(line.replace(b"57", b"56"))[0] == 0


@pytest.mark.parametrize(
    "text, covered",
    [
        (b"N12 G1 X1*85\n", b"N12 G1 X1   \n"),
        (b"N12 G1 X1 *85 \r\n", b"N12 G1 X1     \r\n"),
        (b"N12 G1 X1*85;x*3\nG1 X2", b"N12 G1 X1   ;x*3\nG1 X2"),
        (b"G1 X1 ;2*85\n", b"G1 X1 ;2*85\n"),
        (b"G1 (2*3) X1\n", b"G1 (2*3) X1\n"),
        (b"G1 X[#1*2]\n", b"G1 X[#1*2]\n"),
        (b"G1 X1* \n", b"G1 X1* \n"),
        (b"M117 2*3*77", b"M117 2*3   "),
        (b"", b""),
    ],
)
def test_cover_takes_checksums_and_nothing_else(text, covered):
    assert cover(text) == covered


def test_a_wrong_checksum_is_named_by_its_line():
    text = b"; x*1\n" + sealed(b"N1 G1 X1") + b"\nN2 G1 X2*1\nN3 G1 X3*1\n"
    right = reduce(xor, b"N2 G1 X2", 0)
    assert check(text) == (3, f"the checksum is *1, and the bytes before it give *{right}")
    assert check(b"N1 G1 X1*257\n")[0] == 0
    assert check(b"G1 X1\n") is None


def test_blanks_before_the_number_may_count_or_not():
    code = b"N1 G1 X1"
    for counted in (code, b" " + code):
        assert check(b" %s*%d\n" % (code, reduce(xor, counted, 0))) is None


def test_added_lines_take_the_next_number_and_shift_the_later_ones():
    text = (
        sealed(b"N7 G1 X1", b" ; first")
        + b"G1 X2\r\nX3 ; more\n"
        + sealed(b"N8 G1 X4")
        + sealed(b"N0009G1X5")
    )
    out, state = renumber(text)
    assert out == (
        sealed(b"N7 G1 X1", b" ; first") + sealed(b"N8 G1 X2", b"\r") + sealed(b"N9 X3", b" ; more")
        + sealed(b"N10 G1 X4") + sealed(b"N0011G1X5")
    )  # fmt: skip
    assert state == Numbering(11, 2)


@pytest.mark.parametrize("before", [b"", b"\n", b"\n\n", b"; note\n"])
def test_a_damaged_line_is_named_where_it_stands(before):
    on = printer()
    with pytest.raises(ProgramError, match="the checksum is") as caught:
        on.feed(before + sealed(b"N1 G28") + b"N2 G1 X2*1\n")
    assert caught.value.place.line == before.count(b"\n") + 2
    assert caught.value.place.text == "N2 G1 X2*1"
    assert (caught.value.place.start, caught.value.place.stop) == (0, 0)


def test_of_a_very_long_line_a_thousand_characters_are_shown():
    on = printer()
    with pytest.raises(ProgramError) as caught:
        on.feed(b"N2 G1 X2 ;" + b"x" * 2000 + b"\nN2 G1 X2*1 ;" + b"y" * 2000 + b"\n")
    assert caught.value.place.text == "N2 G1 X2*1 ;" + "y" * 988


def test_a_fault_of_a_whole_block_marks_no_columns():
    on = printer()
    with pytest.raises(ProgramError) as caught:
        on.feed(b"G28\nG1 X9999\n")
    assert caught.value.place.text == "G1 X9999"
    assert (caught.value.place.start, caught.value.place.stop) == (0, 0)


def test_behind_the_end_what_moves_no_axis_is_no_notice():
    """Of RepRap: lines behind M2 pass; where they name an axis, that is said with their line."""
    on = printer("reprap")
    assert on.feed(b"G28\nM2\n; done\nM104 S0\n") == b"G28\nM2\n; done\nM104 S0\n"
    assert not [n for n in on.notices if n.code == "behind"]
    on.feed(b"M84\nG1 X5\n")
    assert [n.line for n in on.notices if n.code == "behind"] == [6]


def test_a_changed_line_keeps_its_number_and_gets_its_checksum():
    assert renumber(b"N7 G1 X1.001 Y2*85 ;a\r\n")[0] == sealed(b"N7 G1 X1.001 Y2", b" ;a\r")
    assert renumber(b"  N7 G1 X1.001*85\n")[0] == sealed(b"N7 G1 X1.001")


@pytest.mark.parametrize(
    "reset",
    [b"N3 M110 N0", b"N0 M110", b"N3M110N0", b"n3 m110 n0"],
    ids=["both", "one", "packed", "small"],
)
def test_m110_sets_the_count_anew(reset):
    text = sealed(b"N1 G1 X1") + b"G1 X2\n" + sealed(reset) + sealed(b"N1 G1 X3")
    out, state = renumber(text)
    assert out == sealed(b"N1 G1 X1") + sealed(b"N2 G1 X2") + sealed(reset) + sealed(b"N1 G1 X3")
    assert state == Numbering(1, 0)


def test_m110_without_a_number_in_front_is_not_numbered():
    text = sealed(b"N1 G1 X1") + b"G1 X2\nM110 N20\n" + sealed(b"N21 G1 X3")
    assert renumber(text)[0].endswith(b"\nM110 N20\n" + sealed(b"N21 G1 X3"))


def test_half_numbered_lines():
    text = sealed(b"N1 G1 X1") + b"G1 X2\nN2 G1 X3\n" + sealed(b"M105") + b"G1 X9*1\n"
    out = renumber(text)[0]
    assert out == sealed(b"N1 G1 X1") + sealed(b"N2 G1 X2") + b"N3 G1 X3\n" + sealed(
        b"M105"
    ) + sealed(b"G1 X9")


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"G1 X1\nX2\n",
        b"%\nO1\nN10 G1 X1\nG1 X2\nN20 X3\n%\n",
        b"N1 G1 X1\nG1 X2\nN2 X3",
        b"; 3*4\n(5*6)\nG1 X1 ;7*8\n",
    ],
)
def test_programs_without_checksums_are_not_touched(text):
    assert renumber(text) == (text, START)


def test_comments_and_blank_lines_take_no_number():
    text = sealed(b"N1 G1 X1") + b"\n \t\r\n; x\n(GCOMP 0.1)\n%\n" + sealed(b"N2 G1 X2")
    assert renumber(text)[0] == text


# -- laws ------------------------------------------------------------------------------------------

WORDS = st.sampled_from(
    [b"G1 X1.5 Y2", b"G1X3F600", b"M104 S200", b"G28", b"X4.", b"T0", b"G2 X1 I2 J0"]
)
TAILS = st.sampled_from([b"", b" ; a*b", b";c", b"\r", b" "])
LINES = st.lists(
    st.tuples(
        st.sampled_from(["right", "right", "stale", "added", "added", "comment", "reset"]),
        WORDS,
        TAILS,
        st.sampled_from([b"N%d %s", b"N%d%s", b"N%04d %s"]),
    ),
    max_size=25,
)


def stream(lines) -> tuple[bytes, list[bytes]]:
    """What stands in a corrected file whose nominal stream was right, and its commands in order."""
    text, commands, number = b"", [], 1
    for kind, words, tail, form in lines:
        if kind == "comment":
            text += b"; %s*12%s\n" % (words, tail)
        elif kind == "added" and number > 1:
            text += words + tail + b"\n"
            commands.append(words)
        elif kind == "reset":
            text += sealed(b"N%d M110 N%d" % (number, 100), tail)
            commands.append(b"M110 N100")
            number = 101
        else:
            code = form % (number, words)
            text += (
                sealed(code, tail)
                if kind != "stale"
                else code.replace(b"X", b"X9") + b"*%d%s\n" % (reduce(xor, code, 0), tail)
            )
            commands.append(words.replace(b"X", b"X9") if kind == "stale" else words)
            number += 1
    return text, commands


@given(LINES)
def test_a_receiver_accepts_every_output(lines):
    text, commands = stream(lines)
    out, _ = renumber(text)
    receiver = Receiver()
    receiver.take(out)
    assert receiver.taken == commands
    assert check(out) is None
    numbered = [line for line in out.split(b"\n") if line.partition(b";")[0].strip()]
    assert all(re.match(rb"N\d+.*\*\d+", line) for line in numbered)
    assert renumber(out)[0] == out


@given(LINES, st.lists(st.integers(0, 25), max_size=4))
def test_any_cut_at_line_ends_gives_the_same_bytes(lines, cuts):
    text, _ = stream(lines)
    whole = renumber(text)
    ends = [0, *(m.end() for m in re.finditer(rb"\n", text))]
    places = sorted({ends[c % len(ends)] for c in cuts} | {0, len(text)})
    out, state = b"", START
    for start, stop in zip(places, places[1:]):
        piece, state = renumber(text[start:stop], state)
        out += piece
    assert (out, state) == whole


@given(LINES)
def test_nothing_added_nothing_changed(lines):
    text, _ = stream([line for line in lines if line[0] not in ("added", "stale")])
    assert renumber(text)[0] == text


def test_a_stream_that_is_written_out_has_no_numbers():
    """Lines come and go when a curve is written out: no number and no checksum of the stream is
    right behind it."""
    text = (
        b"; a print\n"
        + sealed(b"N1 G28")
        + sealed(b"N2 G5 X30 I5 J5 P-5 Q5", b" ; curve")
        + b"G1 X5 ; *7\n"
    )
    assert bare(text) == b"; a print\n G28\n G5 X30 I5 J5 P-5 Q5 ; curve\nG1 X5 ; *7\n"
    assert bare(b"N1 G28*1\n") == b"N1 G28*1\n"  # damaged: refused where it is read
    assert bare(b"N10 G1 X5\n") == b"N10 G1 X5\n"


@given(st.binary(max_size=200) | st.text("N1G*;() \t\r\nM0X.-", max_size=60).map(str.encode))
def test_any_bytes_are_survived(data):
    covered = cover(data)
    assert len(covered) == len(data)
    assert covered.count(b"\n") == data.count(b"\n")
    check(data)
    out, state = renumber(data)
    assert out.count(b"\n") == data.count(b"\n")
    assert renumber(out)[0].count(b"\n") == data.count(b"\n")
    if state == START:
        again, _ = renumber(b"G1 X1\n", state)
        assert again == b"G1 X1\n"


def test_a_long_line_takes_no_long_time():
    for text in (
        b"N1 G1" + b" " * 500_000 + b"X1*5\n",
        b"*1 " * 200_000,
        b"(" * 500_000 + b"*1",
        b"*1;" * 300_000,
    ):
        cover(text), check(text), renumber(text)
