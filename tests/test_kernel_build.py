"""The compiled kernel is built where there is a compiler, by hand or by setup.sh, and taken only if
it is of the source that is there."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from postproc import kernel
from tests.test_kernel import needs_compiler

# ---- building ------------------------------------------------------------------------------------


@needs_compiler
def test_only_a_kernel_of_this_source_is_taken(tmp_path, monkeypatch):
    built = tmp_path / "built.so"
    assert kernel.build(str(built)) == ""
    fresh = kernel.library.__wrapped__
    monkeypatch.setattr(kernel, "BUILT", str(tmp_path / "kernel-built.so"))
    assert fresh() is None
    (tmp_path / "kernel-built.so").write_bytes(b"for another computer")
    assert fresh() is None
    shutil.copy(built, tmp_path / "kernel-built.so")
    assert fresh() is not None
    for name in kernel.SOURCES:
        other = tmp_path / Path(name).name
        other.write_bytes(Path(name).read_bytes() + b"\n")
        others = [str(other) if source == name else source for source in kernel.SOURCES]
        with monkeypatch.context() as m:
            m.setattr(kernel, "SOURCES", others)
            assert fresh() is None
    assert fresh() is not None


def test_without_a_compiler_that_is_said(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(kernel, "BUILT", str(tmp_path / "kernel-built.so"))
    monkeypatch.setenv("CC", "no-such-compiler -m64")
    assert kernel.main() == 1
    assert "no C compiler no-such-compiler here" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@needs_compiler
@pytest.mark.parametrize("which", range(len(kernel.SOURCES)))
def test_a_compiler_that_fails_is_heard(tmp_path, monkeypatch, capsys, which):
    broken = tmp_path / "kernel.c"
    broken.write_text("this is no C\n")
    sources = [*kernel.SOURCES]
    sources[which] = str(broken)
    monkeypatch.setattr(kernel, "SOURCES", sources)
    monkeypatch.setattr(kernel, "BUILT", str(tmp_path / "kernel-built.so"))
    assert kernel.main() == 1
    assert "error" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [broken]


@needs_compiler
def test_it_is_built_where_it_is_found(tmp_path):
    package = tmp_path / "postproc"
    shutil.copytree(Path(kernel.FOLDER), package, ignore=shutil.ignore_patterns("*.so", "*.pyc"))
    command = [sys.executable, "-m", "postproc.kernel"]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert told == f"built {package / 'kernel-built.so'}\n"
    asked = "from postproc import kernel; print(kernel.library() is not None)"
    done = subprocess.run(
        [sys.executable, "-c", asked], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout == "True\n"


# ---- setting up ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "compiler, status, built, said",
    [
        ("cc", 0, True, []),
        ("cc -m64", 0, True, []),
        ("cc", 1, True, ["setup.sh: cc could not build the kernel: gcomp works without it"]),
        ("no-such-compiler", 1, False, []),
    ],
)
def test_setting_up_builds_it_where_there_is_a_compiler(tmp_path, compiler, status, built, said):
    """With a pip that installs nothing and a python that builds nothing: what is run and said."""
    shutil.copy(Path(kernel.FOLDER).parent / "setup.sh", tmp_path)
    bin_ = tmp_path / ".venv" / "bin"
    bin_.mkdir(parents=True)
    ran = tmp_path / "ran"
    for name, script in {
        "pip": "exit 0",
        "python": f'echo "$@" >>{shlex.quote(str(ran))}; echo told; echo told >&2; exit {status}',
        "cc": "exit 0",
    }.items():
        (bin_ / name).write_text(f"#!/bin/sh\n{script}\n")
        (bin_ / name).chmod(0o755)
    path = f"{bin_}:{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "setup.sh"], cwd=tmp_path, capture_output=True, text=True,
        env={"PATH": path, "CC": compiler},
    )  # fmt: skip
    assert done.returncode == 0 and done.stdout == ""
    assert done.stderr.splitlines()[1:] == said
    assert (ran.read_text() if ran.exists() else "") == ("-m postproc.kernel\n" if built else "")


def test_git_and_packages_leave_it_out():
    """hatchling packs nothing that .gitignore names."""
    root = Path(kernel.FOLDER).parent
    assert "*.so" in (root / ".gitignore").read_text().splitlines()
    hatch = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["hatch"]["build"]
    assert not [o for o in ("artifacts", "ignore-vcs") if o in str(hatch)]
