"""docs/REFUSALS.md is what the source says."""

from __future__ import annotations

from tests.refusals_doc import DOC, sentences, text


def test_the_page_is_up_to_date():
    assert DOC.read_text() == text(), "run: python -m tests.refusals_doc"


def test_it_finds_the_sentences_there_are():
    found = sentences()
    assert len(found) >= 10
    assert sum(map(len, found.values())) > 150
    every = {message for rows in found.values() for message, _ in rows}
    assert "an arc of radius 0" in every
    assert any("can not be read back" in message for message in every)
