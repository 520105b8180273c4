"""The page about Python, run as it is printed, in a folder of its own."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest

import gcomp

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def beside(tmp_path, monkeypatch):
    """A folder with the samples in it, as in a clone, and nothing else to be written over."""
    for name in ("sample_programs", "sample_recordings"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)


def test_the_page_about_python_says_what_happens(beside):
    failed, tried = doctest.testfile(str(ROOT / "docs" / "PYTHON.md"), module_relative=False)
    assert (failed, tried > 30) == (0, True)


def test_the_first_example_of_the_module(beside):
    assert doctest.testmod(gcomp).failed == 0


def test_every_public_name_is_said_on_the_page_or_stands_in_the_list_of_types():
    page = (ROOT / "docs" / "PYTHON.md").read_text()
    types = {
        "Compensated",
        "Verified",
        "Evaluated",
        "Diagnosed",
        "Calibrated",
        "Filter",
        "Machine",
        "Recording",
        "Place",
        "Notice",
    }
    missing = [
        n for n in gcomp.__all__ if not n.startswith("__") and n not in types and n not in page
    ]
    assert not missing
    assert all(getattr(gcomp, name).__doc__ for name in gcomp.__all__ if not name.startswith("__"))
