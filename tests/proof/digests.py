"""The digest of a world's cases as another process makes them, for the tests of the worlds."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def elsewhere(module: str, seed: int) -> str:
    """What `digest(seed)` of a module is where sets lie in another order."""
    script = f"from {module} import digest; print(digest({seed}))"
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": "77", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()
