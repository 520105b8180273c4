"""Values as TOML writes them, each on one line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

BARE = re.compile(r"[A-Za-z0-9_-]+")


def entry(name: str, value: Any, remark: str = "") -> str:
    """A line of TOML, with its comment."""
    line, behind = f"{key(name)} = {text(value)}", comment(remark)
    return f"{line:<38} # {behind}" if behind else line


def key(name: str) -> str:
    """A key as TOML writes it: bare where it may be."""
    return name if BARE.fullmatch(name) else _string(name)


def text(value: Any) -> str:
    # before int: True is one in Python
    """A value as TOML writes it, on one line; what is none of its kinds as a string."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))  # of a numpy number too
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key(k)} = {text(v)}" for k, v in value.items())
        return "{ " + inner + " }" if inner else "{}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(text, value)) + "]"
    return _string(str(value))


def _string(value: str) -> str:
    """A TOML basic string: quotes, backslashes and what can not be printed escaped."""
    escaped = _encodable(value).replace("\\", "\\\\").replace('"', '\\"')
    # by code point, \U and eight digits: TOML takes no raw control character in a basic string
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08X}" for c in escaped) + '"'


def comment(line: str) -> str:
    """One line that can stand behind a `#`: a file's name may hold anything."""
    return "".join(c if c.isprintable() else " " for c in _encodable(line)).strip()


def _encodable(line: str) -> str:
    """Bytes of a file name that are no UTF-8 come as lone surrogates, which no file can hold."""
    return line.encode("utf-8", "replace").decode()
