"""The command as a user, a slicer and a pipe meet it: run as a process, judged by what it writes
where."""

from __future__ import annotations

import contextlib
import os
import re
import select
import shutil
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

pty = pytest.importorskip("pty", reason="pipes, modes and signals as POSIX has them")
has_full = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
ROOT = Path(__file__).resolve().parents[1]
PROGRAM = b"(part)\nG90 G21\nG0 X20. Z10.\nG1 X40. Z50. F100\nM30\n"
FAULTY = b"(part)\nG90 G21\nG0 X20. Z10.\nG1 X400. Z50. F100\nM30\n"
GRINDER = ("--machine", "studer-s36")
COMMAND = (sys.executable, "-m", "postproc")
PATIENCE = 20.0  # s


@pytest.fixture
def place(tmp_path):
    """A folder to work in, with a folder for temporary files inside that must be empty
    afterwards."""
    for name in ("home", "temporary"):
        (tmp_path / name).mkdir()
    (tmp_path / "part.nc").write_bytes(PROGRAM)
    (tmp_path / "faulty.nc").write_bytes(FAULTY)
    yield tmp_path
    assert not list((tmp_path / "temporary").iterdir())
    assert not list(tmp_path.rglob("*.part"))


def surroundings(place: Path) -> dict[str, str]:
    return {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "HOME": str(place / "home"),
        "XDG_CONFIG_HOME": str(place / "home"),
        "TMPDIR": str(place / "temporary"),
        "LC_ALL": "C.UTF-8",
    }


class Ran:
    """What a run left: status, standard output (bytes), standard error (text)."""

    def __init__(self, status: int, out: bytes, err: bytes):
        self.status, self.out, self.err = status, out, err.decode("utf-8", "replace")
        assert "Traceback" not in self.err, self.err
        assert status >= 0, f"killed by signal {-status}"


def gcomp(place: Path, *arguments: str, input: bytes | None = None) -> Ran:
    done = subprocess.run(
        [*COMMAND, *arguments],
        input=input,
        stdin=None if input is not None else subprocess.DEVNULL,
        capture_output=True,
        cwd=place,
        env=surroundings(place),
        timeout=PATIENCE,
    )
    return Ran(done.returncode, done.stdout, done.stderr)


def in_shell(place: Path, line: str) -> Ran:
    """`line` with $GCOMP for the command."""
    done = subprocess.run(
        ["sh", "-c", line],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        cwd=place,
        timeout=PATIENCE,
        env={**surroundings(place), "GCOMP": " ".join(COMMAND)},
    )
    return Ran(done.returncode, done.stdout, done.stderr)


@contextlib.contextmanager
def started(place: Path, *arguments: str):
    process = subprocess.Popen(
        [*COMMAND, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
        cwd=place,
        env=surroundings(place),
        # ignored in jobs of a background shell
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        process.wait(PATIENCE)
        for stream in filter(None, (process.stdin, process.stdout, process.stderr)):
            with contextlib.suppress(OSError):
                stream.close()


def answer(process: subprocess.Popen) -> bytes:
    """What comes next on standard output, as far as whole lines; b"" at its end."""
    got, until = b"", time.monotonic() + PATIENCE
    while not got.endswith(b"\n"):
        ready, _, _ = select.select([process.stdout], [], [], max(0.0, until - time.monotonic()))
        assert ready, f"no answer after {PATIENCE} s, only {got!r}"
        more = os.read(process.stdout.fileno(), 1 << 16)
        if not more:
            return got
        got += more
    return got


def ended(process: subprocess.Popen) -> Ran:
    process.stdin.close()
    process.stdin = None
    out, err = process.communicate(timeout=PATIENCE)
    return Ran(process.returncode, out, err)


def zigzag(lines: int) -> bytes:
    """A program of so many motions, 25 bytes each or so."""
    return b"G90 G21\nG0 X20. Z10.\nG1 F500\n" + b"".join(
        b"X%d.%03d Z%d.%03d\n" % (20 + i % 50, i % 1000, 10 + i % 70, (7 * i) % 1000)
        for i in range(lines)
    )


@pytest.fixture(scope="module")
def corrected(tmp_path_factory) -> bytes:
    """The corrected PROGRAM, which every way of asking for it must give."""
    place = tmp_path_factory.mktemp("corrected")
    for name in ("home", "temporary"):
        (place / name).mkdir()
    ran = gcomp(place, *GRINDER, input=PROGRAM)
    assert ran.status == 0
    assert ran.out.startswith(b"(part)\nG90 G21\n(GCOMP ")
    assert ran.out.endswith(b"\nM30\n")
    return ran.out


# -- where it goes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ("part.nc", *GRINDER),
        (*GRINDER, "part.nc"),
        ("compensate", *GRINDER, "part.nc"),
        (*GRINDER, "-o", "-", "part.nc"),
    ],
)
def test_a_file_goes_to_standard_output(place, corrected, arguments):
    ran = gcomp(place, *arguments)
    assert (ran.status, ran.out) == (0, corrected)
    assert "motions changed" in ran.err
    assert (place / "part.nc").read_bytes() == PROGRAM


def test_dash_is_standard_input(place, corrected):
    assert gcomp(place, *GRINDER, "-", input=PROGRAM).out == corrected


def test_an_output_file_is_written_and_nothing_else(place, corrected):
    before = sorted(p.name for p in place.iterdir())
    ran = gcomp(place, "part.nc", *GRINDER, "-o", "out.nc")
    assert (ran.status, ran.out) == (0, b"")
    assert (place / "out.nc").read_bytes() == corrected
    assert sorted(p.name for p in place.iterdir()) == sorted([*before, "out.nc"])
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE((place / "out.nc").stat().st_mode) == 0o666 & ~mask


def test_the_output_may_be_the_input(place, corrected):
    assert gcomp(place, "part.nc", *GRINDER, "-o", "part.nc", "--force").status == 0
    assert (place / "part.nc").read_bytes() == corrected


def test_in_place_keeps_the_nominal_program_the_mode_and_the_link(place, corrected):
    (place / "real").mkdir()
    file, link = place / "real" / "job.nc", place / "link.nc"
    file.write_bytes(PROGRAM)
    file.chmod(0o640)
    link.symlink_to("real/job.nc")
    for backup in ("job.nc.bak", "job.nc.bak2"):
        ran = gcomp(place, *GRINDER, "--in-place", "link.nc")
        assert (ran.status, ran.out) == (0, b"")
        assert file.read_bytes() == corrected
        assert stat.S_IMODE(file.stat().st_mode) == 0o640
        assert link.is_symlink()
        assert backup in ran.err
        assert (file.parent / backup).read_bytes() == PROGRAM
        assert stat.S_IMODE((file.parent / backup).stat().st_mode) == 0o640
        file.write_bytes(PROGRAM)
    assert sorted(p.name for p in file.parent.iterdir()) == ["job.nc", "job.nc.bak", "job.nc.bak2"]


def test_as_slicers_call_it_the_path_stands_last_and_nothing_is_said(place, corrected):
    ran = gcomp(place, *GRINDER, "--in-place", "--quiet", str(place / "part.nc"))
    assert (ran.status, ran.out, ran.err) == (0, b"", "")
    assert (place / "part.nc").read_bytes() == corrected


def test_dry_run_writes_nothing(place):
    before = {p.name: p.stat().st_mtime_ns for p in place.iterdir()}
    ran = gcomp(place, *GRINDER, "--dry-run", "part.nc", "-o", "out.nc")
    assert ran.status == 0
    assert re.fullmatch(
        rb"2 of 2 motions changed, \d+ blocks added, largest correction \d+\.\d um, tolerance 0\.5"
        rb" um\n",
        ran.out,
    )
    assert {p.name: p.stat().st_mtime_ns for p in place.iterdir()} == before


def test_a_machine_without_errors_changes_nothing(place):
    ran = gcomp(place, "--machine", "perfect", "part.nc")
    assert (ran.status, ran.out) == (0, PROGRAM)
    assert "nothing to change" in ran.err


def test_an_empty_program_gives_an_empty_program(place):
    (place / "empty.nc").write_bytes(b"")
    ran = gcomp(place, *GRINDER, "empty.nc", "-o", "out.nc")
    assert (ran.status, (place / "out.nc").read_bytes()) == (0, b"")
    ran = gcomp(place, *GRINDER)
    assert (ran.status, ran.out) == (0, b"")


# -- refusals --------------------------------------------------------------------------------------


def refused(ran: Ran, *says: str) -> None:
    """Status 2, nothing on standard output, one message that says all this, in letters that a
    terminal shows."""
    assert (ran.status, ran.out) == (2, b"")
    assert len(re.findall("^gcomp: ", ran.err, re.MULTILINE)) == 1
    for part in says:
        assert part in ran.err
    assert not [c for c in ran.err if ord(c) < 32 and c != "\n"]


def test_a_faulty_program_writes_nothing(place):
    refused(
        gcomp(place, *GRINDER, input=FAULTY),
        "<stdin>:4: X = 200.0000 mm",
        "0 to 170 mm",
        "\n    G1 X400. Z50. F100\n",
        "--outside clamp",
    )
    (place / "out.nc").write_bytes(b"(GCOMP 0.1 old)")
    refused(gcomp(place, *GRINDER, "faulty.nc", "-o", "out.nc"), "faulty.nc:4: ")
    assert (place / "out.nc").read_bytes() == b"(GCOMP 0.1 old)"
    refused(gcomp(place, *GRINDER, "--quiet", "--in-place", "faulty.nc"), "faulty.nc:4: ")
    assert (place / "faulty.nc").read_bytes() == FAULTY
    assert not (place / "faulty.nc.bak").exists()


def test_a_second_pass_is_refused(place, corrected):
    (place / "once.nc").write_bytes(corrected)
    refused(
        gcomp(place, *GRINDER, "once.nc"), "once.nc:3: ", "corrected already", "nominal program"
    )


@pytest.mark.parametrize(
    "data",
    [
        b"\x7fELF\x02\x01\x01" + bytes(300),
        bytes(range(256)) * 8,
        b"\x1b[31mG1 X1.\n",
        b"PK\x03\x04" + b"\x00\xff" * 50,
        b"\xff\xfeG\x001\x00",
    ],
    ids=["program", "all bytes", "escape", "zip", "UTF-16"],
)
def test_a_binary_file_is_refused_without_spilling_it(place, data):
    (place / "binary").write_bytes(data)
    refused(gcomp(place, *GRINDER, "binary"), "binary:1: ")


def test_a_line_of_two_megabytes_is_refused(place):
    (place / "long.nc").write_bytes(b"G1 " + b"X1." * 700_000 + b"\n")
    ran = gcomp(place, *GRINDER, "long.nc")
    refused(ran, "long.nc:1: ", "1,000,000 characters")
    assert len(ran.err) < 1000


def test_what_there_is_not_is_answered_with_what_there_is(place):
    refused(
        gcomp(place, "--machine", "studer", "part.nc"),
        "'studer'",
        "perfect",
        "studer-s36",
        "path of a machine folder",
    )
    refused(
        gcomp(place, *GRINDER, "--dialect", "klingon", "part.nc"),
        "'klingon'",
        "fanuc-lathe",
        "linuxcnc",
    )
    refused(gcomp(place, *GRINDER, "no.nc"), "no.nc", "No such file")
    refused(gcomp(place, *GRINDER, "home"), "home is a folder, not a program")
    refused(gcomp(place, "--machine", str(place / "home"), "part.nc"), "has no machine.toml")


def test_an_output_that_can_not_be_written_is_named_as_it_was_given(place):
    ran = gcomp(place, *GRINDER, "part.nc", "-o", "nowhere/out.nc")
    assert ran.status in (1, 2)
    assert "nowhere" in ran.err
    assert ".part" not in ran.err


def test_an_output_that_is_a_folder_is_named_not_the_program(place):
    ran = gcomp(place, *GRINDER, "part.nc", "-o", "home")
    assert ran.status in (1, 2)
    assert "home" in ran.err
    assert "part.nc" not in ran.err


@pytest.mark.parametrize(
    "program",
    [
        ("--in-place",),
        ("--in-place", "-"),
        ("--in-place", "part.nc", "-o", "out.nc"),
        ("--unbuffered", "part.nc", "-o", "out.nc"),
        ("--unbuffered", "--dry-run", "part.nc"),
    ],
)
def test_options_that_exclude_each_other_are_refused(place, program):
    refused(gcomp(place, *GRINDER, *program), program[0])
    assert (place / "part.nc").read_bytes() == PROGRAM


def test_without_a_program_it_says_how(place):
    ran = in_shell(place, "$GCOMP --machine studer-s36 <&-")
    refused(ran, "no program", "gcomp --machine NAME FILE")
    try:
        master, terminal = pty.openpty()
    except OSError as error:  # a container without /dev/pts
        pytest.skip(f"no terminal to be had: {error}")
    try:
        done = subprocess.run(
            [*COMMAND, *GRINDER],
            stdin=terminal,
            capture_output=True,
            cwd=place,
            env=surroundings(place),
            timeout=PATIENCE,
        )
    finally:
        os.close(master), os.close(terminal)
    refused(Ran(done.returncode, done.stdout, done.stderr), "no program")


# -- how it is corrected ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text, um",
    [("0.5um", "0.5"), ("0.001mm", "1"), ("0.001", "1"), ("5\u00b5m", "5"), (".0001in", "2.54")],
)
def test_a_tolerance_may_be_written_so(place, text, um):
    ran = gcomp(place, *GRINDER, "--dry-run", "--tolerance", text, "part.nc")
    assert ran.status == 0
    assert f"tolerance {um} um" in ran.out.decode()


@pytest.mark.parametrize(
    "text", ["abc", "0", "-1um", "nan", "1e999um", "0,5um", "5", "20mm", "1m", ""]
)
def test_a_tolerance_may_not_be_written_so(place, text):
    ran = gcomp(place, *GRINDER, f"--tolerance={text}", "part.nc")
    assert (ran.status, ran.out) == (2, b"")
    last = ran.err.splitlines()[0]
    assert len(ran.err.splitlines()) == 2, "the sentence, and where the options are listed"
    assert f"argument --tolerance: {text!r}" in last
    assert "um" in last
    assert ("is that meant in um?" in last) == (text == "20mm")


def test_offsets_may_be_stated(place):
    program = b"G55\nG0 X20. Z10.\n"
    refused(gcomp(place, *GRINDER, input=program), "G55 is not stated", "--offset G55=X0,Z0")
    at_zero = gcomp(place, *GRINDER, "--offset", "G55=X0,Z0", input=program)
    assert at_zero.status == 0
    assert (
        at_zero.out.split(b"\n")[-2]
        == gcomp(place, *GRINDER, input=b"G0 X20. Z10.\n").out.split(b"\n")[-2]
    )
    elsewhere = gcomp(place, *GRINDER, "--offset", "g55 = x1, z-2.5", input=program)
    assert elsewhere.status == 0
    assert elsewhere.out != at_zero.out


@pytest.mark.parametrize(
    "option",
    [
        "--offset=G54",
        "--offset=G99=X1",
        "--offset=G54=X",
        "--offset=G54=X1,X2",
        "--offset=G504=X1",
        "--offset=G54.1=X1",
        "--start=Q1",
        "--start=X1;Z2",
        "--block-delete=yes",
        "--reversal=jump",
        "--outside=ignore",
    ],
)
def test_options_with_a_wrong_value_show_the_right_form(place, option):
    ran = gcomp(place, *GRINDER, option, "part.nc")
    assert (ran.status, ran.out) == (2, b"")
    last = ran.err.splitlines()[0]
    assert len(ran.err.splitlines()) == 2, "the sentence, and where the options are listed"
    assert option.split("=")[0] in last
    assert re.search(r"like (G54=X1|X1)|choose from", last)


@pytest.mark.parametrize("option", ["--offset=G54=X0,Y1", "--start=Y1"])
def test_an_axis_that_the_machine_has_not_is_named(place, option):
    refused(gcomp(place, *GRINDER, option, "part.nc"), "names Y", "studer-s36", "X Z")


def test_the_start_may_be_stated(place):
    program = b"G1 X20. F100\n"
    refused(
        gcomp(place, *GRINDER, input=program), "<stdin>:1: where Z stands is not known", "--start"
    )
    ran = gcomp(place, *GRINDER, "--start", "X5,Z10", input=program)
    assert ran.status == 0
    assert b"Z9.99" in ran.out


def test_block_delete_on_leaves_the_block_alone(place):
    program = b"G0 X20. Z10.\n/G1 X30. F100\nG1 X40. F100\n"
    on, off = (
        gcomp(place, *GRINDER, "--block-delete", way, input=program) for way in ("on", "off")
    )
    assert (on.status, off.status) == (0, 0)
    assert b"\n/G1 X30. F100\n" in on.out
    assert b"\n/G1 X30. F100\n" not in off.out
    assert "notice: " in on.err
    assert "line 2" in on.err


def test_beyond_the_table_the_end_value_may_be_held(place):
    program = b"G0 X20. Z10.\nG1 X345. F100\n"
    refused(gcomp(place, *GRINDER, input=program), "X = 172.5000 mm")
    assert gcomp(place, *GRINDER, "--outside", "clamp", input=program).status == 0
    beyond = gcomp(place, *GRINDER, "--outside", "clamp", input=b"G0 X20. Z10.\nG1 X352. F100\n")
    refused(beyond, "<stdin>:2: ", "beyond the travel of X (-5 to 175 mm)")


def test_the_ways_to_treat_a_reversal_are_accepted_and_differ(place):
    program = b"G0 X20. Z10.\nG1 X40. Z50. F100\nX20. Z90.\nX40. Z40.\n"
    outs = []
    for how in (["mean"], ["step"], ["ramp", "--ramp", "5mm"], ["off"]):
        ran = gcomp(place, *GRINDER, "--reversal", *how, input=program)
        assert ran.status == 0
        outs.append(ran.out)
    assert len(set(outs)) >= 3


def test_arc_centres_may_be_absolute(place):
    program = b"G0 X20. Z30.\nG3 X40. Z20. I10. K20. F100\n"
    refused(
        gcomp(place, *GRINDER, input=program),
        "misses its own end point",
        "incremental",
        "--arc-centre",
    )
    assert gcomp(place, *GRINDER, "--arc-centre", "absolute", input=program).status == 0


# -- what it says ----------------------------------------------------------------------------------


def test_verify_says_what_is_left(place, corrected):
    ran = gcomp(place, *GRINDER, "--verify", "part.nc")
    assert (ran.status, ran.out) == (0, corrected)
    left, without = re.search(
        r"nominal path ([\d.]+) um .*uncorrected ([\d.]+) um", ran.err
    ).groups()
    assert float(left) <= 0.55 < float(without)
    assert "2 motions in" in ran.err


def test_progress_is_told_as_linuxcnc_reads_it(place):
    (place / "long.nc").write_bytes(zigzag(60_000))
    ran = gcomp(place, "--machine", "perfect", "--filter-progress", "long.nc", "-o", "out.nc")
    assert ran.status == 0
    told = [int(n) for n in re.findall(r"^FILTER_PROGRESS=(\d+)$", ran.err, re.MULTILINE)]
    assert told == sorted(told)
    assert told[-1] == 100
    assert len(told) >= 3


def test_quiet_says_nothing(place, corrected):
    ran = gcomp(place, *GRINDER, "--quiet", input=b"M777\n" + PROGRAM)
    assert (ran.status, ran.err) == (0, "")
    assert gcomp(place, *GRINDER, "--quiet", "--dry-run", "part.nc").err == ""


def test_the_machines_are_listed_and_shown(place):
    ran = gcomp(place, "machines")
    assert ran.status == 0
    listed = [line.split()[0] for line in ran.out.decode().splitlines()]
    assert listed == sorted(listed) and {
        "perfect",
        "studer-s36",
        "studer-s36-thesis",
        "example-mill",
    } <= set(listed)
    text = gcomp(place, "machines", "show", "studer-s36").out.decode()
    for part in (
        "Studer S-36",
        "w-b-Z-X-t",
        "diameter",
        "travel -5 to 175 mm",
        "18 nodes",
        "EXX",
        "urad",
        "B0X  -382.4",
        "offset G54",
    ):
        assert part in text
    refused(gcomp(place, "machines", "show"), "which machine?")
    refused(gcomp(place, "machines", "show", "none"), "'none'", "studer-s36")


def test_machines_beside_the_work_come_first_and_a_broken_one_is_listed_as_such(place):
    own = place / "machines"
    shutil.copytree(ROOT / "machines" / "studer-s36", own / "perfect")
    (own / "broken").mkdir()
    (own / "broken" / "machine.toml").write_text("format = 1\n")
    lines = {line.split()[0]: line for line in gcomp(place, "machines").out.decode().splitlines()}
    assert "cylindrical grinder" in lines["perfect"]
    assert "can not be used" in lines["broken"]
    assert "studer-s36" in lines
    refused(gcomp(place, "--machine", "broken", "part.nc"), "broken/machine.toml:1: ")


def test_help_and_version(place):
    version = gcomp(place, "--version")
    assert version.status == 0
    assert re.fullmatch(rb"gcomp \d+\.\d+\.\d+\n", version.out)
    general = gcomp(place, "--help")
    assert general.status == 0
    for part in (b"compensate", b"machines", b"explain", b"example: "):
        assert part in general.out
    special = gcomp(place, "compensate", "--help")
    assert special.status == 0
    for part in (b"--machine", b"--tolerance", b"--in-place", b"example: cat job.nc | gcomp"):
        assert part in special.out
    alone = gcomp(place)
    assert (alone.status, alone.out) == (2, b"")
    assert "usage: gcomp" in alone.err


def test_without_a_machine_it_says_which_option_is_missing(place):
    ran = gcomp(place, "part.nc")
    assert (ran.status, ran.out) == (2, b"")
    assert "--machine is missing" in ran.err.splitlines()[0]
    assert "studer-s36" in ran.err


# -- pipes, signals, disks -------------------------------------------------------------------------


def test_a_live_pipe_is_answered_line_by_line_up_to_the_fault(place):
    with started(place, *GRINDER, "--unbuffered") as process:
        said = b""
        for line in (b"(part)\nG90 G21\n", b"G0 X20. Z10.\n", b"G1 X40. F100\n", b"Z50.\n"):
            process.stdin.write(line)
            got = answer(process)
            assert got.endswith(b"\n")
            said += got
        process.stdin.write(b"X30.\nX400.\nX20.\n")
        said += answer(process)
        ran = ended(process)
    before = gcomp(
        place, *GRINDER, input=b"(part)\nG90 G21\nG0 X20. Z10.\nG1 X40. F100\nZ50.\nX30.\n"
    )
    assert said + ran.out == before.out
    assert ran.status == 2
    assert "<stdin>:7: X = 200.0000 mm" in ran.err


def test_half_a_line_waits_for_the_other_half(place):
    with started(place, *GRINDER, "--unbuffered") as process:
        process.stdin.write(b"G0 X20. Z10.\nG0 X2")
        first = answer(process)
        assert b"X2\n" not in first
        process.stdin.write(b"4. Z12.\n")
        assert answer(process).startswith(b"G0 X2")
        assert ended(process).status == 0


@pytest.mark.parametrize("how", [(), ("--unbuffered",), ("-o", "out.nc")])
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_control_c_leaves_nothing_behind(place, how, end):
    """It waits on its pipe, more than a pipe holds already read."""
    before = sorted(p.name for p in place.iterdir())
    with started(place, *GRINDER, *how) as process:
        if "--unbuffered" in how:
            process.stdin.write(b"G0 X20. Z10.\n")
            answer(process)
        else:
            process.stdin.write(zigzag(20_000))
        process.send_signal(end)
        ran = ended(process)
    assert ran.status == 130
    assert "interrupted" in ran.err
    assert ran.out == b""
    assert sorted(p.name for p in place.iterdir()) == before


@pytest.mark.parametrize("how", [(), ("--unbuffered",)])
def test_a_reader_that_goes_away_is_no_fault(place, how):
    (place / "long.nc").write_bytes(zigzag(20_000))
    with started(place, *GRINDER, *how, "long.nc") as process:
        assert os.read(process.stdout.fileno(), 20)
        process.stdout.close()
        process.stdout = None
        ran = ended(process)
    assert ran.status == 141
    assert ran.err == ""


@pytest.mark.parametrize(
    "line",
    [
        "$GCOMP --machine studer-s36 part.nc",
        "$GCOMP --machine studer-s36 --unbuffered part.nc",
        "$GCOMP --machine studer-s36 --verify --quiet part.nc",
    ],
)
def test_without_standard_error_the_program_is_the_same(place, corrected, line):
    """As a service or a window without a console calls it: no message may end up in the program."""
    ran = in_shell(place, f"{line} 2>&-")
    assert (ran.status, ran.out) == (0, corrected)


def test_without_standard_output_there_is_a_message(place, corrected):
    ran = in_shell(place, "$GCOMP --machine studer-s36 part.nc >&-")
    assert ran.status in (1, 2)
    assert "gcomp: " in ran.err
    ran = in_shell(place, "$GCOMP --machine studer-s36 --quiet part.nc -o out.nc >&-")
    assert (ran.status, ran.err) == (0, "")
    assert (place / "out.nc").read_bytes() == corrected


@has_full
def test_a_full_standard_output_is_told(place):
    for line in (
        "$GCOMP --machine studer-s36 part.nc",
        "$GCOMP machines",
        "$GCOMP --machine studer-s36 --dry-run part.nc",
    ):
        ran = in_shell(place, f"{line} > /dev/full")
        assert ran.status == 1
        assert "No space left" in ran.err


@pytest.fixture
def small_disk(place):
    """A disk of 256 kB; skipped where none can be mounted."""
    disk = place / "disk"
    disk.mkdir()
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(disk)], capture_output=True
    )
    if done.returncode:
        pytest.skip("no disk can be mounted here")
    try:
        yield disk
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_full_disk_keeps_the_old_output(place, small_disk):
    (place / "long.nc").write_bytes(zigzag(20_000))
    (small_disk / "out.nc").write_bytes(b"(GCOMP 0.1 old)")
    ran = gcomp(place, *GRINDER, "long.nc", "-o", "disk/out.nc")
    assert (ran.status, ran.out) == (1, b"")
    assert "No space left" in ran.err
    assert [p.name for p in small_disk.iterdir()] == ["out.nc"]
    assert (small_disk / "out.nc").read_bytes() == b"(GCOMP 0.1 old)"


def test_a_disk_without_room_for_the_backup_keeps_the_program(place, small_disk):
    """New file and old one fit, a third copy does not: no half a backup may be left for the next
    run to step over."""
    program = zigzag(6_000)
    assert 2 * len(program) < 256 * 1024 < 3 * len(program)
    (small_disk / "job.nc").write_bytes(program)
    ran = gcomp(place, "--machine", "perfect", "--in-place", "disk/job.nc")
    assert ran.status == 1
    assert "No space left" in ran.err
    assert (small_disk / "job.nc").read_bytes() == program
    assert [p.name for p in small_disk.iterdir()] == ["job.nc"]


@has_full
def test_an_output_that_is_a_device_is_written_to(place):
    assert gcomp(place, *GRINDER, "part.nc", "-o", "/dev/null").status == 0
    ran = gcomp(place, *GRINDER, "part.nc", "-o", "/dev/full")
    assert ran.status == 1
    assert "No space left" in ran.err
