"""What all results have in common: JSON, and a file that is whole or not there."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

from postproc import ports
from postproc.errors import UsageError


def as_text(data: dict[str, Any]) -> str:
    """JSON as every command writes it: what is not defined is null, never NaN."""
    return json.dumps(data, indent=1, allow_nan=False)


def write(path: str | Path, data: bytes, overwrite: bool) -> Path:
    """Put data in a file, whole or not at all. Raises UsageError where one stands and `overwrite`
    is not set."""
    target = Path(path)
    if target.exists() and not overwrite:
        raise UsageError(f"{target} exists", "overwrite=True replaces it")
    ports.replace_file(target, io.BytesIO(data), backup=False)
    return target
