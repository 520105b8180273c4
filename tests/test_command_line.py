"""The command line as people know it: near misses, --version anywhere, completion; and every line
that the README prints."""

from __future__ import annotations

import argparse
import importlib
import io
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest

from postproc import __version__, colour
from postproc.cli import DEFAULT, commands, main
from postproc.machine import places

ROOT = Path(__file__).resolve().parents[1]
PAGES = ("README.md", "sample_recordings/README.md")


@pytest.mark.parametrize(
    "words, says",
    [
        (["plot", "part.nc"], "gcomp --help lists the commands"),
        (["machnies"], "did you mean gcomp machines?"),
        (["diagnos", "a.csv"], "did you mean gcomp diagnose?"),
        (["--machine", "perfect", "--tolernace", "1um", "x.nc"], "did you mean --tolerance?"),
        (
            ["a.nc", "b.nc", "--machine", "perfect"],
            "one program at a time, and b.nc is another\n    gcomp batch PROGRAM... -o DIR",
        ),
        (["a.nc", "--machine", "perfekt"], "did you mean perfect? machines: "),
        (["a.nc", "--machine", "perfekt"], "(looked in "),
        (["a.nc", "--machine", "lathes/perfect"], "gcomp machines lists those"),
        (["iso", "x.csv", "--figur", "--colour=red"], "--help lists the options"),
    ],
)
def test_a_near_miss_is_answered_with_what_is_meant(tmp_path, monkeypatch, capfd, words, says):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    err = capfd.readouterr().err
    assert says in err and len(err.splitlines()) <= 4


def test_a_file_that_is_called_almost_as_a_command_is_a_program(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("machine").write_text("G21 G90 G0 X1 Y1 Z1\n")
    assert main(["machine", "--machine", "perfect"]) == 0
    assert capfd.readouterr().out == "G21 G90 G0 X1 Y1 Z1\n"


@pytest.mark.parametrize(
    "words",
    [
        ["--version"],
        ["machines", "--version"],
        ["--machine", "x", "--version"],
        ["batch", "--version"],
    ],
)
def test_the_version_is_reported_beside_anything(capfd, words):
    assert main(words) == 0
    assert capfd.readouterr().out == f"gcomp {__version__}\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_has_every_command_and_option(capfd, shell):
    assert main(["completion", shell]) == 0
    script = capfd.readouterr().out
    assert all(re.search(rf"\b{name}\b", script) for name in commands())
    assert "hole-tolerance" in script and "mean step ramp off" in script
    if shell != "zsh" and shutil.which(shell):
        assert (
            subprocess.run([shell, "-n"], input=script.encode(), capture_output=True).stderr == b""
        )


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize(
    "line, offers",
    [
        ("gcomp mach", ["machines"]),
        ("gcomp job.nc --revers", ["--reversal"]),
        ("gcomp job.nc --reversal st", ["step"]),
        ("gcomp iso --rep", ["--report"]),
        ("gcomp batch --sched", ["--scheduler"]),
    ],
)
def test_bash_completes(capfd, line, offers):
    assert main(["completion", "bash"]) == 0
    words = line.split()
    script = (
        f"{capfd.readouterr().out}\nCOMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1};"
        " _gcomp; echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, cwd="/")
    assert done.stdout.split() == offers, done.stderr


def printed() -> list[tuple[str, str]]:
    """Lines of the pages that run gcomp, each with its page: without comments, pipes and what
    follows them."""
    found = []
    for page in PAGES:
        for block in re.findall(r"```sh\n(.*?)```", (ROOT / page).read_text("utf-8"), re.DOTALL):
            for line in block.splitlines():
                for part in re.split(r"\s*(?:\||&&)\s*", line.partition(" #")[0].strip()):
                    if re.match(r"(?:\.venv/bin/)?gcomp ", part):
                        found.append((page, part.partition(" > ")[0]))
    return found


@pytest.mark.parametrize("page, line", printed())
def test_every_line_that_is_printed_has_options_that_there_are(page, line, capsys):
    words = shlex.split(line)[1:]
    name = words.pop(0) if words[0] in commands() else DEFAULT
    module = importlib.import_module(f"postproc.commands.{name}")
    parser = argparse.ArgumentParser(prog=name)
    module.arguments(parser)
    if hasattr(module, "HANDS_ON") and "--" in words:
        words = words[: words.index("--")]
    parser.parse_args(words)


def test_there_are_lines_to_be_tried():
    assert len(printed()) > 20


def test_a_message_has_the_colour_of_what_it_is(monkeypatch):
    """Errors are told as such, by whoever tells them; what a command tells besides is no error."""
    written = io.StringIO()
    painted = colour.Painted(written)
    monkeypatch.setattr(sys, "stderr", painted)
    for text in ("a.nc: 6 lines, 90 bytes received", "waiting for the control", "3 rows"):
        print(f"gcomp: {text}", file=painted)
        assert written.getvalue() == f"gcomp: {text}\n"
        written.truncate(written.seek(0))
    for kind, code in (("warning: w", 33), ("written: a.nc", 32), ("notice: n", 36)):
        print(f"gcomp: {kind}", file=painted)
        assert written.getvalue() == f"\x1b[{code}mgcomp:\x1b[0m {kind}\n"
        written.truncate(written.seek(0))
    assert main(["--tolerance", "x"]) == 2
    assert written.getvalue().startswith("\x1b[1;31mgcomp:\x1b[0m argument --tolerance")


def test_the_manual_page_is_what_the_commands_say(capfd):
    """All commands are in it; groff, where it is installed, warns of nothing."""
    assert main(["man"]) == 0
    made = capfd.readouterr().out
    assert all(f'.SH "GCOMP {name.upper()}"' in made for name in commands() if name != DEFAULT)
    if shutil.which("groff"):
        done = subprocess.run(
            ["groff", "-man", "-ww", "-z"], input=made.encode(), capture_output=True
        )
        assert done.stderr == b""


def test_the_manual_names_variables_that_are_read(tmp_path, monkeypatch, capfd):
    """Each of the environment's, by what it changes."""
    assert main(["man"]) == 0
    section = capfd.readouterr().out.split('.SH "ENVIRONMENT"')[1].split(".SH")[0]
    named = re.findall(r"\\fB(\w+)\\fR", section)
    does = {
        "NO_COLOR": lambda: colour.wanted(SimpleNamespace(isatty=lambda: True)),
        "XDG_CONFIG_HOME": lambda: list(map(str, places.folders())),
        "TMPDIR": lambda: (setattr(tempfile, "tempdir", None), tempfile.gettempdir())[1],
    }
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setenv("TERM", "xterm")
    (tmp_path / "gcomp" / "machines").mkdir(parents=True)
    for name in named:
        monkeypatch.delenv(name, raising=False)
        before = does[name]()
        monkeypatch.setenv(name, str(tmp_path))
        assert does[name]() != before, name


def test_colour_is_for_terminals_alone(tmp_path, monkeypatch):
    """By a pseudo-terminal: an error's gcomp: is red, with NO_COLOR it is plain; in a pipe it
    always is."""
    import os
    import pty
    import sys

    def said(**more) -> bytes:
        reader, writer = pty.openpty()
        environment = (
            {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
            | {"PYTHONPATH": str(ROOT), "TERM": "xterm"}
            | more
        )
        subprocess.run(
            [sys.executable, "-m", "postproc", "no.nc", "--machine", "perfect"],
            stderr=writer,
            env=environment,
            cwd=tmp_path,
        )
        os.close(writer)
        return os.read(reader, 4096)

    assert said().startswith(b"\x1b[1;31mgcomp:\x1b[0m no.nc")
    assert said(NO_COLOR="1").startswith(b"gcomp: no.nc")
