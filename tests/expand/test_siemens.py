"""Whole Sinumerik programs: real ones reach the positions of the tables beside them; anything
at all ends in lines or a refusal."""

from __future__ import annotations

import csv
import re
from itertools import groupby
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.nc.expand import Limits
from tests.expand.siemens_lines import AXES, Follower, refused, run

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT.parent / "shared" / "corpus" / "sinumerik"


# -- real programs ---------------------------------------------------------------------------------

STARTS = {"increment": {"Y": 900.0}}  # where the tables' producer stands before the first line
TABLES = {"flatten_demo": "flatten_demo_raw"}
REFUSED = {
    "custom_vars": "AA is not defined in this program",
    "arrays": "NN is not defined in this program",
    "axis_index_assignment": "ACC is an instruction: the value that it has can not be read",
    "edge_cases": "E_MULTIPLIER is not defined in this program",
}
# The same programs with what a control would need to run them: definitions, and a subprogram that
# the table passes over.
COMPLETED = {
    "custom_vars": lambda text: b"DEF INT aa=15, bb=9\n" + text,
    "arrays": lambda text: re.sub(
        rb"\b([mo])\b(?=[=,*;\n\] +])", rb"\1\1", b"DEF INT nn, mm, oo\n" + text
    ),
    "edge_cases": lambda text: b"DEF REAL E_MULTIPLIER, F_MULTI\n" + text,
}
LIBRARY = {"MATERIAL_UPDATE": b"M17"}


def corpus():
    return sorted(path.stem for path in CORPUS.glob("*.mpf")) if CORPUS.is_dir() else []


def table(name):
    """Axes and positions by row, rows without a change left out."""
    with open(CORPUS / f"{TABLES.get(name, name)}.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    axes = [axis for axis in AXES if rows and axis in rows[0]]
    places = [tuple(float(row[a]) if row[a] else None for a in axes) for row in rows]
    return axes, [key for key, _ in groupby(places) if any(v is not None for v in key)]


def followed(name, text):
    tracker = Follower()
    tracker.local.update(STARTS.get(name, {}))
    run(text, library=LIBRARY, tracker=tracker, name=name)
    axes, expected = table(name)
    places = [tuple(row.get(axis) for axis in axes) for row in tracker.rows]
    return [key for key, _ in groupby(places)], expected


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus is not here")
@pytest.mark.parametrize("name", corpus())
def test_real_programs_reach_the_positions_of_their_tables(name):
    text = (CORPUS / f"{name}.mpf").read_bytes()
    if name in REFUSED:
        refused(text, REFUSED[name], name=name)
        if name not in COMPLETED:
            return
        text = COMPLETED[name](text)
    found, expected = followed(name, text)
    assert len(found) == len(expected)
    for place, wanted in zip(found, expected, strict=True):
        assert [v is None for v in place] == [v is None for v in wanted]
        assert [v for v in place if v is not None] == pytest.approx(
            [v for v in wanted if v is not None], abs=1e-3
        )


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus is not here")
def test_an_unknown_subprogram_is_refused_and_not_passed_over():
    text = COMPLETED["edge_cases"]((CORPUS / "edge_cases.mpf").read_bytes())
    refused(
        text,
        "MATERIAL_UPDATE is neither a command that gcomp knows nor a subprogram",
        "could move an axis",
    )


# -- anything at all -------------------------------------------------------------------------------

SOUP = """IF ELSE ENDIF LOOP ENDLOOP WHILE ENDWHILE FOR ENDFOR REPEAT UNTIL REPEATB GOTOF GOTOB GOTO GOTOC GOTOS CASE OF DEFAULT DEF REAL INT BOOL
CHAR STRING AXIS PROC EXTERN RET CALL PCALL MCALL M17 M30 R1 R2 R[ ] ( ) , = == <> < > <= >= << + - * / DIV MOD AND OR XOR NOT B_AND B_OR B_NOT
SIN( ATAN2( ROUND( BOUND( SET( REP( TRUE $PI $AA_IW[X] $P_UIFR 1 2.5 -3 1EX5 1EX999 'H0F' "A" " ; X= Y=IC( CR= X1 N10 LA: LB: LA LB P=2 L10 SUB
SUB( AA BB[2] AA= AX[ TO VAR TRANS MSG( SAVE / % : . # \xff \x00 \xb2 \t . 99999999999999999999 T= G71 FOR""".split(  # noqa: E501
    " "
)
SOUP = [word for part in SOUP for word in part.split("\n")]
FUZZED = {"SUB": b"PROC SUB(REAL AA, VAR REAL BB)\nX=AA\nSUB(AA)\nM17", "L10": b"X1\nR1=R1+1"}


def only_refusals(text):
    try:
        run(text, library=FUZZED, limits=Limits(300, 4))
    except ProgramError as e:
        assert e.message and e.advice and str(e) and e.place.line >= 1


@settings(max_examples=400)
@given(
    st.lists(st.lists(st.sampled_from(SOUP), max_size=8), max_size=10), st.sampled_from(["", " "])
)
def test_words_in_any_order_are_run_or_refused(soup, between):
    only_refusals(
        "DEF REAL AA=1, BB[3]\nR1=1 R2=2\n" + "\n".join(between.join(line) for line in soup)
    )


@settings(max_examples=300)
@given(st.binary(max_size=60))
def test_any_bytes_are_run_or_refused(data):
    only_refusals(data)
    only_refusals(b"X=" + data)
    only_refusals(b"IF " + data + b"\nENDIF")
