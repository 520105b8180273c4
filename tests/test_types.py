"""Types hold as `[tool.mypy]` of pyproject.toml asks: for the packages that it names as strictly as
mypy --strict. What mypy knows of files from a run before (.mypy_cache) is used."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_types_hold():
    pytest.importorskip("mypy", reason="the test extra was not installed")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-error-summary"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
