"""`--json`: what a command reports, for other programs; one format with a name and a schema
(postproc/schemas) each."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, TextIO

from postproc import ports

SCHEMAS = Path(__file__).resolve().parents[1] / "schemas"


def beside(path: str | None) -> TextIO:
    """Where words for a person go: standard output, unless the JSON is there."""
    return sys.stderr if path == "-" else sys.stdout


def text(data: dict[str, Any]) -> str:
    """JSON as every command writes it: what is not defined is null, never NaN."""
    import json

    return json.dumps(data, indent=1, allow_nan=False)


def put(path: str | None, data: dict[str, Any]) -> None:
    """Write it, whole or not at all; nothing where none was asked for."""
    if not path:
        return
    written = (text(data) + "\n").encode()
    if path == "-":
        ports.write_standard(written)
    else:
        ports.write_whole(path, written)
