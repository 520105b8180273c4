"""Laws: the batch does not matter, without error not a byte moves, twice is refused, nothing of the
program is lost."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from reference.interpreter import run

from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.units import UM
from postproc.verify import Verifier
from tests.programs import programs
from tests.small_machines import MILL, STUDER_FANUC, STUDER_LINUXCNC, write_lagging, write_mill

by_the_kernel_too = pytest.mark.usefixtures("both_ways")  # where arcs are cut

ROOT = Path(__file__).resolve().parents[1]
FANUC = ROOT.parent / "shared" / "corpus" / "fanuc"
SAMPLES = sorted(p for p in (ROOT / "sample_programs").iterdir() if p.suffix in (".nc", ".ngc"))
MODES = ("mean", "step", "ramp", "off")
HALF_INCREMENT = {"mm": 0.05 * UM, "inch": 0.00001 * 25.4 / 2}

PHASES = [phase for phase in Phase if phase != Phase.explain]
site_law = settings(deadline=None, max_examples=35, phases=PHASES)  # each on several sites


class Machines(dict):
    """By name; hypothesis prints it, tables and all, unless told not to."""

    def __repr__(self) -> str:
        return f"<{', '.join(self)}>"


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    folder = tmp_path_factory.mktemp("machines")
    result = Machines()
    result |= {
        name: places.load(str(ROOT / "machines" / name))
        for name in ("studer-s36", "studer-s36-thesis", "perfect")
    }
    for name, two_way in (("one-way", False), ("two-way", True)):
        result[name] = places.load(str(write_mill(folder / name, two_way)))
    for name in ("studer-s36", "studer-s36-thesis"):  # in which X and Z have forward beyond reverse
        result[name + " lagging"] = places.load(
            str(write_lagging(ROOT / "machines" / name, folder / name))
        )
    return result


def filter_of(machine, dialect: str, offsets=None, **options) -> Filter:
    return Filter(
        machine, dialects.load(dialect), setup_of(machine, offsets=offsets), Options(**options)
    )


def outcome(filter_: Filter, parts) -> tuple[bytes, str]:
    """What comes out, also before a refusal, and the refusal."""
    out = b""
    try:
        for part in parts:
            out += filter_.feed(part)
        return out + filter_.finish(), ""
    except ProgramError as error:
        return out + error.delivered, str(error)


def cut(text: bytes, places_) -> list[bytes]:
    edges = [0, *sorted(min(at, len(text)) for at in places_), len(text)]
    return [text[a:b] for a, b in zip(edges, edges[1:], strict=False)]


SITES = {
    "studer-s36": STUDER_FANUC,
    "studer-s36-thesis": STUDER_LINUXCNC,
    "one-way": MILL,
    "two-way": MILL,
}
each_site = pytest.mark.parametrize("name", SITES)
each_mode = pytest.mark.parametrize("mode", MODES)


# -- the batch does not matter ---------------------------------------------------------------------


@by_the_kernel_too
@each_mode
@each_site
@given(data=st.data())
@settings(deadline=None, max_examples=20, phases=PHASES)
def test_any_cut_gives_the_same_bytes(machines, name, mode, data):
    text = data.draw(programs(SITES[name], blocks=10, late=True, away=True, radius=0.01, tiny=True))
    places_ = data.draw(st.lists(st.integers(0, len(text)), max_size=4))
    whole = outcome(filter_of(machines[name], SITES[name].dialect, reversal=mode), [text])
    assert (
        outcome(filter_of(machines[name], SITES[name].dialect, reversal=mode), cut(text, places_))
        == whole
    )


@by_the_kernel_too
@each_mode
@pytest.mark.parametrize(
    "text",
    [
        b"G0 X40. Z20.\nG2 X80. Z100. R60. F50\n",
        (
            b"G0 X320. Z224.\nG2 Z223.16698 X315.53982 K-7.08634 I1.37638 F5\nG1 U-29.838\nG2"
            b" Z213.96417 X292.29866 K-4.89217 I0.83795\n"
        ),
        (
            b"G0 X215.265 Z55.94\nG1 X69.74 Z446.769422 F100\nG0 X63.10\nG91\nG3 Z-22.4870 X44.9740"
            b" K-22.4870 I0.0000\n"
        ),
        b"G0 X40. Z20.\nG1 X40. Z400. F50\nG93 X80. F2\nG3 X80. Z300. R80. F3",
    ],
)
def test_one_line_at_a_time_gives_the_same_bytes(machines, mode, text):
    filter_ = filter_of(machines["studer-s36-thesis"], "fanuc-lathe", reversal=mode)
    whole = outcome(filter_of(machines["studer-s36-thesis"], "fanuc-lathe", reversal=mode), [text])
    assert outcome(filter_, text.splitlines(keepends=True)) == whole


@pytest.mark.parametrize(
    "text",
    [
        b"G0 X0 Z0\nG53 G1 X83.6 Z429.101 F10\nG1 X83.6 Z429.101\n",
        b"G0 Z35.34453\nG20\nG0 X7.086614\nG21\nG1 X180. F100\nG1 Z50.\n",
        b"G0 X0 Z0\nG53 G1 X83.6 Z429.101 F10\nG93 G1 Z429.101 F3\n",
    ],
)
def test_a_motion_that_is_all_take_up_is_one_block(machines, text):
    """Turning round can bring the slides exactly to where a short motion ends: then nothing is left
    to write."""
    filter_ = filter_of(machines["studer-s36"], "fanuc-lathe")
    Verifier(filter_)
    out, fault = outcome(filter_, [text])
    assert not fault
    assert all(
        re.search(rb"[A-Z]\S*\d", line) and not re.fullmatch(rb" *F[\d.]+", line)
        for line in out.splitlines()
    )


def test_ramp_on_a_one_way_machine_is_mean(machines):
    text = b"G0 X48. Y-30. Z-40.\nG1 Y30. Z-10. F100\n"
    by_mode = [
        outcome(filter_of(machines["one-way"], "linuxcnc", reversal=mode), [text]) for mode in MODES
    ]
    assert by_mode == by_mode[:1] * len(MODES)


@by_the_kernel_too
def test_pieces_of_an_arc_keep_their_order_when_it_is_alone(machines):
    """A batch with arcs alone, as the last line without newline is one."""
    text = b"G0 X19.651 Y-28.305 Z40.\nG2 X53.04789 Y-9.59681 Z39.97 I21.73319 J0.36633 F50"
    filter_ = filter_of(machines["one-way"], "linuxcnc")
    Verifier(filter_)
    whole, _ = outcome(filter_of(machines["one-way"], "linuxcnc"), [text + b"\n"])
    assert outcome(filter_, [text]) == (whole[:-1], "")


# -- without error not a byte moves ----------------------------------------------------------------


@pytest.mark.parametrize(
    "site", [STUDER_FANUC, STUDER_LINUXCNC, MILL], ids=["fanuc-lathe", "two axes", "three axes"]
)
@given(data=st.data())
@site_law
def test_perfect_machine_changes_no_byte(machines, site, data):
    text = data.draw(programs(site, late=True, away=True, radius=0.01, tiny=True))
    assert outcome(filter_of(machines["perfect"], site.dialect), [text]) == (text, "")


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "linuxcnc"])
@pytest.mark.parametrize("path", SAMPLES, ids=lambda p: p.name)
def test_perfect_machine_changes_no_byte_of_the_samples(machines, path, dialect):
    if (path.suffix == ".ngc") != (dialect == "linuxcnc"):
        pytest.skip("written in the other language")
    text = path.read_bytes()
    assert outcome(filter_of(machines["perfect"], dialect), [text]) == (text, "")


@pytest.mark.skipif(not FANUC.is_dir(), reason="the corpus is not here")
def test_perfect_machine_changes_no_byte_of_the_corpus(machines):
    told = {}
    for path in sorted(p for p in FANUC.iterdir() if p.suffix == ".NC"):
        text = path.read_bytes()
        result = outcome(filter_of(machines["perfect"], "fanuc-lathe"), [text])
        if result != (text, ""):
            told[path.name] = result[1] or "other bytes"
    assert told == {}


# -- twice is refused, nothing is lost -------------------------------------------------------------


@by_the_kernel_too
@each_site
@given(data=st.data())
@settings(deadline=None, max_examples=30, phases=PHASES)
def test_a_corrected_program_is_refused(machines, name, data):
    text = data.draw(programs(SITES[name]))
    out, fault = outcome(filter_of(machines[name], SITES[name].dialect), [text])
    assume(not fault)
    again, fault = outcome(filter_of(machines[name], SITES[name].dialect), [out])
    assert out == text or "gcomp's own output" in fault


def moving(text: bytes, machine, dialect: str) -> int:
    """How many blocks move, by the reference interpreter."""
    blocks = run(
        text.decode(),
        dialect,
        axes=machine.letters,
        diameter=machine.diameter,
        offsets=machine.offsets,
    )
    return sum(block.kind in ("rapid", "feed", "arc", "machine") for block in blocks)


@by_the_kernel_too
@each_site
@given(data=st.data())
@settings(deadline=None, max_examples=30, phases=PHASES)
def test_no_motion_is_lost(machines, name, data):
    text = data.draw(programs(SITES[name], away=True, tiny=True, radius=0.05))
    machine, dialect = machines[name], SITES[name].dialect
    out, fault = outcome(filter_of(machine, dialect), [text])
    assume(not fault)
    assert moving(out, machine, dialect) >= moving(text, machine, dialect)


@by_the_kernel_too
@pytest.mark.parametrize("mode", ["step", "mean"])
@each_site
@given(data=st.data())
@settings(deadline=None, max_examples=20, phases=PHASES)
def test_the_verifier_agrees(machines, name, mode, data):
    text = data.draw(programs(SITES[name], late=True, away=True, tiny=True, radius=0.05, blocks=10))
    machine = machines.get(name + " lagging", machines[name])
    filter_ = filter_of(machine, SITES[name].dialect, reversal=mode)
    verifier = Verifier(filter_)
    _, fault = outcome(filter_, [text])
    assume(not fault)
    inch = b"G20" in re.sub(rb"\([^)]*\)|\s", b"", text.upper())
    limit = filter_.compensator.tolerance + HALF_INCREMENT["inch" if inch else "mm"] + 1e-9
    if mode == "step":  # every axis may be held back by 1.5 times the hysteresis
        limit += 1.5 * UM * np.sqrt(machine.two_way.sum()) + machine.lateral
    assert verifier.corrected.deviation <= limit, verifier.report()
    assert verifier.passed, verifier.report()


# -- everything that is not a coordinate survives --------------------------------------------------

COMMENT = re.compile(rb"\([^)\n]*\)")
MOVED = re.compile(rb"[XYZUVWIJKR][-+.\d]+|G0?[0123](?![.\d])|G0?[0123]\.0*(?!\d)")
LATE = re.compile(rb"M0*(?:[0125]|9|30|60)(?!\d)")


def skeleton(text: bytes, dialect: str) -> list[tuple[bytes, bytes]]:
    """(block without its axis words, its end) of each block; blanks outside comments left out. F
    and P change with the length of pieces under G93, and where arcs are cut; M codes that act after
    the motion move to its last piece."""
    inverse = b"G93" in COMMENT.sub(b"", text).upper().replace(b" ", b"").replace(b"\t", b"")
    parts = re.split(rb"(;?[ \t]*\r?\n|;)" if dialect == "fanuc-lathe" else rb"(\r?\n)", text)
    result = []
    for block, end in zip(parts[::2], [*parts[1::2], b""], strict=False):
        remarks = COMMENT.findall(block)
        code = COMMENT.sub(b"", block)
        if dialect == "linuxcnc":
            code, mark, rest = code.partition(b";")
            remarks.append(mark + rest)
        code = re.sub(rb"[ \t]", b"", code).upper()
        code = LATE.sub(b"", MOVED.sub(b"", code))
        code = re.sub(rb"[FP][-+.\d]+", b"", code) if inverse and b"G4" not in code else code
        result.append((code + b"|" + b"|".join(remarks), end))
    return result


@by_the_kernel_too
@each_site
@given(data=st.data())
@settings(deadline=None, max_examples=30, phases=PHASES)
def test_all_but_coordinates_survives(machines, name, data):
    text = data.draw(programs(SITES[name], inverse=False, away=True))
    machine, dialect = machines[name], SITES[name].dialect
    filter_ = filter_of(machine, dialect)
    out, fault = outcome(filter_, [text])
    assume(not fault)
    newline = b"\r\n" if b"\r\n" in text else b"\n"
    marked = re.search(rb"\(GCOMP [^)]*\)" + newline, out)
    bare = out.replace(marked[0], b"", 1) if marked else out
    before, after = skeleton(text, dialect), skeleton(bare, dialect)
    assert len(after) == len(before) + filter_.summary.added
    rest = iter(after)
    for block in before:
        assert any(block[0] == other[0] for other in rest), block
    added = list(after)
    for block in before:
        found = next((b for b in added if b[0] == block[0]), None)
        assert found is not None, block
        added.remove(found)
    assert all(code in (b"|", b"/|", b"/||", b"||") for code, _ in added)
    assert re.findall(rb"M\d+", COMMENT.sub(b"", bare).upper()) == re.findall(
        rb"M\d+", COMMENT.sub(b"", text).upper()
    )
    assert out.count(b"\r\n") in (0, out.count(b"\n"))
