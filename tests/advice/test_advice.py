"""For every sentence that stops a program, its advice is followed: it must not lead to the same
sentence again.

The sentences are those of docs/REFUSALS.md, read out of the source: a new one needs a case here, or
a reason in NO_CASE.
"""

from __future__ import annotations

from functools import lru_cache

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from tests.advice import (
    bspline,
    fadal,
    follow,
    klartext,
    okuma,
    plain,
    rest,
    written_fanuc,
    written_linuxcnc,
    written_siemens,
)
from tests.advice.no_case import NO_CASE
from tests.refusals_doc import sentences

CASES = [
    *plain.ALL,
    *written_fanuc.ALL,
    *written_linuxcnc.ALL,
    *written_siemens.ALL,
    *rest.ALL,
    *klartext.ALL,
    *fadal.ALL,
    *okuma.ALL,
    *bspline.ALL,
]


@lru_cache(None)
def provoked_by(number: int) -> ProgramError:
    """What stops the first program of CASES[number]: three tests ask for it."""
    case = CASES[number]
    error = follow.stopped(case.dialect, case.before, {**case.how, **case.first})
    assert error is not None, "it is not refused"
    assert follow.sentence(error.message), f"no sentence of docs/REFUSALS.md: {error.message}"
    return error


@lru_cache
def met() -> dict[str, ProgramError]:
    """Every sentence that the cases provoke, with one error of each."""
    errors = map(provoked_by, range(len(CASES)))
    return {follow.sentence(error.message): error for error in errors}


@pytest.mark.parametrize("number", range(len(CASES)), ids=map(str, CASES))
def test_the_advice_leads_on(number):
    case, error = CASES[number], provoked_by(number)
    assert error.advice, error.message
    assert len(str(error).splitlines()) <= 4
    after = follow.stopped(case.dialect, case.after, {**case.how, **case.also})
    if not case.then:
        assert after is None, f"{error}\n-- and then --\n{after}"
        return
    assert after is not None
    assert case.then in after.message
    assert follow.sentence(after.message) != follow.sentence(error.message)


@pytest.mark.parametrize("number", range(len(CASES)), ids=map(str, CASES))
def test_the_line_that_a_person_wrote_is_named(number):
    case, error = CASES[number], provoked_by(number)
    lines = case.before.replace("|", "\n").split("\n")
    if error.place.file != "part.nc":
        return
    assert 0 < error.place.line <= len(lines)
    shown = error.place.text.rstrip("\r\n")
    assert shown == lines[error.place.line - 1].rstrip("\r\n")[:1000].rstrip("\r")


def test_every_sentence_has_a_case():
    every = {follow.bare(m) for c in follow.CHAPTERS for m, _ in sentences().get(c, ())}
    missing = sorted(m for m in every if m not in met() and m not in NO_CASE)
    assert not missing, f"{len(missing)} sentences without a case:\n" + "\n".join(missing)
    assert not sorted(m for m in NO_CASE if m in met()), "they have a case now"
    assert not sorted(m for m in NO_CASE if m not in every), "nothing says this any more"


CODES = [
    (name, code.word)
    for name in dialects.names()
    for code in dialects.load(name).codes
    if "--expand" in code.refuses and code.word[0] == "G"
]


@pytest.mark.parametrize(("name", "word"), CODES)
@pytest.mark.parametrize("words", ["", " X20. Z-1.", " P9 X20. Z-1. R2. Q100."])
def test_a_code_that_points_to_expand_is_written_out_or_refused_for_another_reason(
    name, word, words
):
    lathe = "lathe" in name
    head = "G90|G0 X10.|" + ("" if lathe else "G0 Y10.|") + "G0 Z5.|"
    if lathe:
        words = words.replace("P9", "P900")  # um from groove to groove: 6 of them, not 556
    text = f"{head}{word}{words}|G1 X5. F9|G0 Z5."
    error = follow.stopped(name, text, {})
    if error is None or "--expand" not in error.advice:
        return
    after = follow.stopped(name, text, follow.WRITE)
    assert after is None or follow.sentence(after.message) != follow.sentence(error.message)


@pytest.mark.parametrize("name", ["fanuc-mill", "haas", "grbl", "linuxcnc"])
def test_only_fanucs_corners_are_written_out(name):
    error = follow.stopped(name, "G90|G0 X0. Y0. Z5.|G1 X5.,R2. F9|Y9.", {})
    writes = "--expand writes ,R and ,C" in error.advice
    assert writes == (dialects.load(name).language == "fanuc")


@pytest.mark.parametrize("name", dialects.names())
@pytest.mark.parametrize(
    "text", ["#1=5|G1 X#1 F9", "o100 sub|o100 endsub", "IF[1 EQ 1]GOTO 5", "G1 X[1+2] F9"]
)
def test_only_where_a_language_runs_is_it_named(name, text):
    error = follow.stopped(name, text, {})
    if error is not None and "run with --expand" in error.advice:
        after = follow.stopped(name, text, follow.WRITE)
        assert after is None or follow.sentence(after.message) != follow.sentence(error.message)


def test_a_place_that_a_homing_lost_is_not_asked_for_at_the_start():
    text = "G91 G28 X0|G90 G92 X0|G1 X5. F9"
    error = follow.stopped("fanuc-mill", text, {})
    assert "a new zero where the machine stands" in error.message
    assert "leads it nowhere known" in error.advice
    error = follow.stopped("fanuc-mill", text, {"start": follow.NOWHERE})
    assert "--start X0" in error.advice
