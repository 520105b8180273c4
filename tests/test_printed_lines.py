"""Every line that README.md and the tutorial print is run, in their order, in a copy of what a
clone has."""

from __future__ import annotations

import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from postproc.cli import main
from tests.streaming.grbl_model import GrblModel

ROOT = Path(__file__).resolve().parents[1]
PAGES = ("README.md", "docs/TUTORIAL.md")
COPIED = ("machines", "sample_programs", "sample_recordings")
# What sets up: .ci/run begins with it. Its parts are held against setup.sh and pyproject.toml
# below.
SETUP = ("sh setup.sh", "export PATH=")
EMPTY = {"XDG_CONFIG_HOME": "config", "XDG_CACHE_HOME": "cache", "HOME": "home"}


def lines(page: str) -> list[str]:
    """Lines of a page's sh blocks, without comments."""
    found = []
    for block in re.findall(r"```sh\n(.*?)```", (ROOT / page).read_text("utf-8"), re.DOTALL):
        found += [
            line.partition(" #")[0].strip()
            for line in block.splitlines()
            if line.strip() and not line.startswith("#")
        ]
    return found


class Shell:
    """The little of a shell that the pages use: pipes, > FILE, &&, file names with ?; gcomp in this
    process."""

    def __init__(self, port: str):
        self.port = port

    def run(self, line: str) -> None:
        for part in line.split(" && "):
            self._pipe(
                [shlex.split(p.replace("/dev/ttyUSB0", self.port)) for p in part.split(" | ")]
            )

    def _pipe(self, commands: list[list[str]]) -> None:
        data = b""
        for words in commands:
            target = words[words.index(">") + 1] if ">" in words else None
            words = self._named(words[: words.index(">")] if ">" in words else words)
            data = (
                self._gcomp(words[1:], data)
                if words[0].endswith("gcomp")
                else self._other(words, data)
            )
            if target:
                Path(target).write_bytes(data)

    def _named(self, words: list[str]) -> list[str]:
        return [
            name for w in words for name in (sorted(map(str, Path().glob(w))) if "?" in w else [w])
        ]

    def _other(self, words: list[str], data: bytes) -> bytes:
        assert words[0] in ("cat", "mkdir", "cp", "printf"), words
        if words[0] == "printf":
            return words[1].encode().decode("unicode_escape").encode()
        return subprocess.run(words, input=data, capture_output=True, check=True).stdout

    def _gcomp(self, words: list[str], data: bytes) -> bytes:
        kept = sys.stdin, sys.stdout
        with Path("in").open("wb") as file:
            file.write(data)
        try:
            with Path("in").open("rb") as source, Path("out").open("wb") as target:
                sys.stdin, sys.stdout = (
                    io.TextIOWrapper(source),
                    io.TextIOWrapper(target, write_through=True),
                )
                status = main(words)
                sys.stdout.flush()
        finally:
            sys.stdin, sys.stdout = kept
        assert status == (
            1
            if words[:2] == ["machines", "check"] and b"in doubt" in Path("out").read_bytes()
            else 0
        ), words
        return Path("out").read_bytes()


@pytest.fixture
def clone(tmp_path, monkeypatch) -> Iterator[Path]:
    """A folder with what a clone has for a user to try, and none of the user's own settings."""
    for name in COPIED:
        shutil.copytree(ROOT / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    for name, folder in EMPTY.items():
        monkeypatch.setenv(name, str(tmp_path / folder))
    monkeypatch.setattr("webbrowser.open", lambda address: True)
    yield tmp_path


def test_every_line_of_the_readme_runs(clone, capfd):
    from tests.streaming.pty_host import PtyHost

    made = GrblModel()
    made.stored["G54"] = [0.0, 0.0, -50.0]
    with PtyHost(made, speed=400.0) as host:
        ran = _ran("README.md", host.path)
    assert ran > 20
    assert (clone / "shaft_comp.nc").read_bytes() == (clone / "shaft_comp2.nc").read_bytes()
    assert (clone / "corrected" / "gcomp-batch.csv").exists() and (
        clone / "machines" / "studer-found"
    ).is_dir()
    for name in ("run.html", "z.html", "my-lathe.html", "answer.html"):
        assert "plotly.js (MIT)" in (clone / name).read_text("utf-8"), name
    capfd.readouterr()


def test_every_line_of_the_tutorial_runs(clone, capfd):
    assert _ran("docs/TUTORIAL.md", "/nowhere") > 15
    for name in (
        "square.html",
        "turning.html",
        "turning_accept.html",
        "circle.html",
        "why.html",
        "print.html",
        "incremental.html",
        "shaft_now.html",
    ):
        assert (clone / name).exists(), name
    assert "X400" not in (clone / "square_corrected.nc").read_text()
    capfd.readouterr()


def _ran(page: str, port: str) -> int:
    shell, count = Shell(port), 0
    for line in lines(page):
        if line.startswith(SETUP) and "gcomp" not in line:
            continue
        own = line.partition(" && ")[2] if line.startswith(SETUP) else line
        shell.run(own)
        count += 1
    return count


def test_python_in_the_readme_runs(clone, capfd):
    (block,) = re.findall(
        r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL
    )
    exec(block, {})
    assert "largest deviation from the nominal path" in capfd.readouterr().out


def test_what_sets_up_is_what_the_continuous_test_begins_with():
    printed = [line for line in lines("README.md") if line.startswith(SETUP)]
    assert len(printed) == 3 and "-m pytest -n auto --dist loadfile" in printed[1]
    ci = (ROOT / ".ci" / "run").read_text()
    assert "sh setup.sh test" in ci and "-m pytest -n auto --dist loadfile" in ci
    assert os.access(ROOT / "setup.sh", os.R_OK)
