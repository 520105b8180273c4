"""Bytes of a controller that answers in lines, cut into its answers."""

from __future__ import annotations

LONGEST = 4096  # bytes without a line end that are no answer any more


def cut(rest: bytes, data: bytes) -> tuple[list[str], bytes]:
    """The answers that are whole, without line ends, blanks around them and empty ones; and what is
    left of the next. rest: what the last call left."""
    *lines, rest = (rest + data).split(b"\n")
    if len(rest) > LONGEST:
        lines, rest = [*lines, rest], b""
    texts = (line.strip(b"\r\0 \t").decode("latin-1") for line in lines)
    return [text for text in texts if text], rest
