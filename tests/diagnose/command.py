"""gcomp simulate and gcomp diagnose as the tests of this folder call them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from postproc.cli import main


def simulated(files: Sequence[Path], tests: Sequence[str], machine: str, seed: int, *more: str):
    """A recording of each test, with noise of 0.4 um, in the file of the same place. The files'
    names."""
    for k, (file, test) in enumerate(zip(files, tests, strict=True)):
        words = ["simulate", "--test", test, "--machine", machine, *more, "--noise", "0.4"]
        assert main([*words, "--seed", str(seed + k), "-o", str(file), "--quiet"]) == 0
    return [str(file) for file in files]


def diagnosed(files: Sequence[str], machine: str, out: Path, *more: str) -> dict:
    """The JSON of a diagnosis."""
    words = ["diagnose", *files, "--machine", machine, "--json", str(out), "--force", "--quiet"]
    assert main([*words, *more]) == 0
    return json.loads(out.read_text())
