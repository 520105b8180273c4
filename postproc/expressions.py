"""Regular expressions that are compiled when they are first used: most runs use few of them, and
compiling all takes a thirtieth of the time of a short program."""

from __future__ import annotations

import re
from typing import Any, AnyStr, cast


class _Pattern:
    """What a compiled one can, from the first use of each of its methods on as fast."""

    def __init__(self, *written: Any):
        self._written = written

    def __getattr__(self, name: str) -> Any:
        value = getattr(re.compile(*self._written), name)  # `re` keeps what it has compiled
        setattr(self, name, value)
        return value


def expression(text: AnyStr, flags: int = 0) -> re.Pattern[AnyStr]:
    """As re.compile."""
    return cast("re.Pattern[AnyStr]", _Pattern(text, flags))
