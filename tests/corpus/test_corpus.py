"""Every real program is corrected and verified, or truly refused; none gets worse than
docs/COVERAGE.md says."""

from __future__ import annotations

from functools import lru_cache

import pytest

from postproc.nc import dialects

from . import report, run, tables
from .machines import MAIN, Machines, Variant
from .programs import Program, has_cycles, programs

PROGRAMS = programs()
pytestmark = pytest.mark.skipif(
    not PROGRAMS, reason="the programs beside the project are not there"
)
COARSE = Variant(True, 0.001, 5.0)
SINGLE = Variant(False, 0.0001, 5.0)


@pytest.fixture(scope="session")
def machines(tmp_path_factory) -> Machines:
    return Machines(tmp_path_factory.mktemp("machines"))


@pytest.fixture(params=PROGRAMS, ids=lambda program: program.name)
def program(request) -> Program:
    if request.param.dialect not in dialects.names():
        pytest.skip(f"there is no dialect {request.param.dialect}")
    return request.param


@lru_cache(None)
def row_of(machines: Machines, program: Program) -> report.Row:
    return report.row_of(program, program.short, (), machines)


@lru_cache
def written() -> tuple[dict[str, str], dict[str, str]]:
    return report.read(report.TARGET.read_text(encoding="utf-8"))


def test_laws(machines, program):
    """No byte moved by a map without errors; no traceback, nothing lost, paths as long, within the
    tolerance."""
    row = row_of(machines, program)
    if written()[1].get(program.name) == report.BROKEN:
        pytest.xfail("docs/COVERAGE.md names an error here")
    assert row.faults == []
    for outcome in (row.zero, row.zero_expanded, row.plain, row.expanded):
        assert outcome.status != "broken", outcome.message
    if row.result == report.REFUSED:
        assert row.best.line > 0
        assert row.best.message
        assert row.best.advice


def test_not_worse_than_written(machines, program):
    before = written()[1].get(program.name)
    now = row_of(machines, program).result
    assert before is None or report.RANK[now] >= report.RANK[before], f"{before} before, {now} now"


@pytest.mark.parametrize("variant", [SINGLE, COARSE], ids=str)
def test_other_machines(machines, program, variant):
    if written()[1].get(program.name) == report.BROKEN:
        pytest.xfail("docs/COVERAGE.md names an error here")
    outcome = run.run_smooth(machines, program, program.short, False, variant)
    assert outcome.faults == []
    if row_of(machines, program).plain.good:
        assert outcome.good


def test_cuts_of_the_input_do_not_matter(machines, program):
    text = b"".join(program.short.splitlines(keepends=True)[:120])
    as_one = run.run_cut(machines, program, text)
    third = len(text) // 3
    for cuts in [(0,), (third, third + 1, 2 * third)]:
        parts = run.run_cut(machines, program, text, cuts)
        assert parts.output == as_one.output
        assert (parts.status, parts.line, parts.message) == (
            as_one.status,
            as_one.line,
            as_one.message,
        )


def test_written_out_without_need_is_the_same(machines, program):
    """Where nothing has to be written out, --expand passes the lines as they are."""
    plain = run.run_zero(machines, program, program.short, False)
    expanded = run.run_zero(machines, program, program.short, True)
    if not plain.good or not expanded.good or has_cycles(program):
        return
    assert expanded.output.rstrip() == program.short[: len(expanded.output.rstrip())]


def test_tables_of_places(machines, program):
    if tables.table_of(program) is None:
        return
    fault = tables.table_fault(machines, program)
    if fault and written()[1].get(program.name) == report.BROKEN:
        pytest.xfail("docs/COVERAGE.md names an error here")
    assert fault == ""


def test_totals_are_those_of_the_tables():
    """The head of docs/COVERAGE.md counts what stands below it, and every program stands there."""
    numbers, results = written()
    found = list(results.values())
    assert set(results) == {p.name for p in PROGRAMS if p.dialect in dialects.names()}
    assert int(numbers["programs"]) == len(found)
    assert int(numbers["corrected and verified without an option"]) == found.count(report.AS_IS)
    assert int(numbers["corrected and verified with --expand"]) == found.count(report.EXPANDED)
    assert int(numbers["refused"]) == found.count(report.REFUSED)
    assert int(numbers["errors of gcomp"]) == found.count(report.BROKEN)
    # um: each of three slides by the hysteresis, and half of it inside a block
    held_back = 1.5 * 1.0 * 3**0.5
    assert float(numbers["largest deviation corrected, um"]) <= MAIN.tolerance_um + held_back
