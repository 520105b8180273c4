"""Laws for every dialect, also a stranger's."""

from __future__ import annotations

import pytest

from postproc.errors import UsageError
from postproc.nc import dialects

NAMES = dialects.names()


@pytest.mark.parametrize("name", NAMES)
def test_codes_are_whole(name):
    dialect = dialects.load(name)
    numbers = [code.number for code in dialect.codes]
    assert len(numbers) == len(set(numbers)), "a G number stands twice"
    for code in dialect.codes:
        assert code.word[0] == "G", code
        assert code.meaning, code
        assert 0 <= code.number < dialects.LARGEST_G
    assert {"motion", "plane", "distance", "units", "work offset"} <= set(dialect.groups)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_refused_says_the_way_out(name):
    dialect = dialects.load(name)
    for code in dialect.codes:
        if code.refuses:
            assert ":" in code.refuses or "," in code.refuses, f"{code.word}: say what is wrong, then what to do"
    for number, reason in dialect.m_refuses.items():
        assert number >= 0
        assert reason


@pytest.mark.parametrize("name", NAMES)
def test_a_dialect_is_found_by_its_name_and_is_data(name):
    dialect = dialects.load(name)
    assert dialect.name == name
    assert dialect.grammar.semicolon in ("comment", "end of block")
    assert dialect.plane in (170, 180, 190)
    with pytest.raises(AttributeError):
        dialect.plane = 170


def test_an_unknown_name_is_answered_with_the_names():
    with pytest.raises(UsageError, match="linuxcnc"):
        dialects.load("klingon")
