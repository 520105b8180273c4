"""Keys of a Windows console, with a msvcrt that this test makes up: single, without Enter, and no
half of a function key."""

from __future__ import annotations

import sys
from types import SimpleNamespace

from postproc.commands.stream import keys


def test_a_windows_console_gives_single_keys(monkeypatch):
    typed = list("r\xe0Hx\x00;+")
    console = SimpleNamespace(kbhit=lambda: bool(typed), getwch=lambda: typed.pop(0))
    monkeypatch.setitem(sys.modules, "msvcrt", console)
    monkeypatch.setattr(keys, "os", SimpleNamespace(name="nt"))
    with keys.Keys() as pressed:
        assert pressed.pressed() == "rx+"  # an arrow and F1 left out, both halves
        assert pressed.pressed() == ""
