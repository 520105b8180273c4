"""The documentation site builds without a warning, links lead somewhere, and the machine that its
page prints is one."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import gcomp

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([ROOT / "README.md", ROOT / "machines" / "README.md", *(ROOT / "docs").glob("*.md")])


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_to_files_that_there_are(page):
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text("utf-8")):
        assert (page.parent / target).exists(), target


def test_the_site_builds_without_a_warning(tmp_path):
    pytest.importorskip(
        "mkdocs",
        reason="mkdocs is not installed (pip install 'gcomp[docs]'): the site is not built",
    )
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env={"PATH": "/usr/bin:/bin", "NO_MKDOCS_2_WARNING": "1"},
    )
    assert done.returncode == 0 and "WARNING" not in done.stderr, done.stderr
    assert (tmp_path / "TUTORIAL" / "index.html").exists() and (
        tmp_path / "machines" / "index.html"
    ).exists()


def test_the_machine_of_the_page_errs_as_the_page_says(tmp_path):
    """10.7 and -2.25 um, by hand in docs/MACHINE.md."""
    text = (ROOT / "docs" / "MACHINE.md").read_text("utf-8")
    (toml,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    table = re.findall(r"```\n(Z_mm.*?)```", text, re.DOTALL)[0]
    (tmp_path / "machine.toml").write_text(toml)
    (tmp_path / "Z.csv").write_text(table)
    machine = gcomp.load_machine(tmp_path)
    off = machine.deviation(np.array([[90.0], [200.0]]), np.ones((2, 1)))[:, 0] * 1000
    assert dict(zip(machine.letters, off, strict=True)) == pytest.approx(
        {"X": -2.25, "Z": 10.7}, abs=1e-9
    )
