"""Programs that nobody would write, and some that people do: every one is corrected or refused by
the laws (laws.py).

A fixed number of cases with fixed seeds; GCOMP_FUZZ=1 draws new ones, GCOMP_FUZZ_SECONDS=600 goes
on for so long.
"""

from __future__ import annotations

import os
import resource
import time
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fuzz import grammar, laws, mutate
from fuzz.cases import Case, case_of, filter_of, random_case
from postproc.nc.lexer import lex

FOUND = Path(__file__).with_name("found")
NEW = bool(os.environ.get("GCOMP_FUZZ"))
SECONDS = float(os.environ.get("GCOMP_FUZZ_SECONDS", 0))
EXAMPLES = 60 if NEW else 10
CASES = 1000 if NEW else 120
PHASES = [
    phase for phase in Phase if phase not in (Phase.explain, *(() if NEW else (Phase.shrink,)))
]


# -- what was found once ---------------------------------------------------------------------------


def found() -> list:
    """Each case of found/: its text, and beside it one line of options and, while it waits to be
    mended, why."""
    result = []
    for path in sorted(FOUND.glob("*.txt")):
        options, _, reason = path.read_text().strip().partition(" | open: ")
        marks = [pytest.mark.xfail(strict=False, reason=reason)] if reason else []
        case = case_of(path.with_suffix(".nc").read_bytes(), options)
        result.append(pytest.param(case, bool(reason), id=path.stem, marks=marks))
    return result


@pytest.mark.parametrize("case, still_open", found())
def test_what_was_found_keeps_the_laws(case, still_open):
    assert laws.broken(case, 2 if still_open else laws.SECONDS) == ""


@cache
def waiting() -> frozenset[str]:
    """Kinds of broken laws that wait to be mended: the other tests pass them by."""
    told = [laws.kind(laws.broken(p.values[0], 2)) for p in found() if p.values[1]]
    # these have nothing of their own in it
    told = [kind for kind in told if kind and not kind.startswith("verifier")]
    return frozenset(kind.split(":")[0] if kind.startswith("hang") else kind for kind in told)


def wrong(told: str) -> bool:
    kind = laws.kind(told) if told else ""
    return bool(told) and kind not in waiting() and kind.split(":")[0] not in waiting()


@pytest.mark.parametrize(
    "name, code", [("fanuc-mill", b"G54.1 P1"), ("haas", b"G154 P1"), ("fanuc-lathe", b"G54 P1")]
)
def test_a_plain_work_offset_takes_the_additional_one_back(name, code):
    """No law sees this: the Verifier reads the output as the filter reads the input."""
    filter_ = filter_of(Case(b"", name))
    text = b"G0 X10. Z0.\n" + code + b"\nG0 X10. Z0.\nG54\nG0 X10. Z0.\n"
    motions, _, _ = filter_.interpreter.run(
        lex(text, filter_.dialect.grammar), filter_.interpreter.initial()
    )
    before, other, after = motions.target.T.tolist()
    assert before != other and before == after


# -- programs of the generator ---------------------------------------------------------------------


@st.composite
def cases(draw, name: str) -> Case:
    wild = draw(st.sampled_from((0.0, 0.02, 0.05)))
    text = draw(grammar.programs(name, 16, wild))
    return random_case(draw(st.randoms(use_true_random=False)), text, name)


@pytest.mark.parametrize("name", grammar.every())
@given(data=st.data())
@settings(
    deadline=None, max_examples=EXAMPLES, phases=PHASES, suppress_health_check=list(HealthCheck)
)
def test_programs_keep_the_laws(name, data):
    case = data.draw(cases(name))
    told = laws.broken(case)
    assert not wrong(told), f"{told}\n{case.options()}\n{case.text!r}"


# -- bytes -----------------------------------------------------------------------------------------


def test_any_bytes_keep_the_laws():
    seed = time.time_ns() % 10**9 if NEW or SECONDS else 1
    fuzzer = mutate.run(seed, 0 if SECONDS else CASES, SECONDS, guided=bool(NEW or SECONDS))
    waits = {p.values[0].text for p in found() if p.values[1]}
    told = [
        f"{f.told}\n    {small.options()}\n    {small.text!r}"
        for f in fuzzer.found.values()
        if wrong(f.told)
        for small in [laws.smallest(f.case, 300)]
        if small.text not in waits  # a case of found/ by itself
    ]
    assert not told, f"seed {seed}:\n" + "\n".join(told)


# -- long and deep ---------------------------------------------------------------------------------

HERE = b"G90 G0 X10. Y5. Z0.\n"
LONG = {
    "a loop of a million steps": (
        b"#1=0\no1 repeat [1000000]\nG1 X[#1 MOD 5] F100\n#1=[#1+1]\no1 endrepeat\n",
        "linuxcnc",
        True,
    ),
    "a loop without end": (b"WHILE[1EQ1]DO1\nG1X1.F1\nEND1\n", "fanuc-mill", True),
    "a loop without end, of Siemens": (b"LOOP\nG1 X1 F1\nENDLOOP\n", "siemens", True),
    "a million calls": (b"M98 P100 L999999\nM30\nO100\nG1 X1. F1.\nM99\n", "fanuc-mill", True),
    "a label repeated": (b"LA:\nG1 X1 F1\nREPEAT LA P=999999999\n", "siemens", True),
    "calls of itself": (b"o1 sub\no1 call\no1 endsub\no1 call\n", "linuxcnc", True),
    "a million holes": (HERE + b"G91 G81 X.001 Z-1. R-.1 L999999 F100\n", "linuxcnc", True),
    "a million pecks": (HERE + b"G83 X1. Z-10. R0. Q0.00001 F100\n", "fanuc-mill", True),
    "brackets": (b"G1 X" + b"[" * 100_000 + b"1" + b"]" * 100_000 + b" F1\n", "linuxcnc", True),
    "brackets of Fanuc": (
        b"#1=" + b"[" * 100_000 + b"1" + b"]" * 100_000 + b"\n",
        "fanuc-mill",
        True,
    ),
    "brackets of Siemens": (
        b"R1=" + b"(" * 100_000 + b"1" + b")" * 100_000 + b"\n",
        "siemens",
        True,
    ),
    "signs": (b"#1=" + b"-" * 100_000 + b"1\n", "fanuc-mill", True),
    "powers": (b"#1=[10**10**10**10]\nG1 X#1 F1\n", "linuxcnc", True),
    "references": (b"G1 X" + b"#" * 50_000 + b"1 F1\n", "linuxcnc", True),
    "a line of comments": (b"G1 " + b"(A)" * 300_000 + b"X5 F10\n", "linuxcnc", False),
    "a line of digits": (b"G1 X" + b"1" * 900_000 + b"\n", "linuxcnc", False),
    "a line of letters": (b"X" * 900_000 + b"\n", "linuxcnc", False),
    "a line of assignments": (b"G1 " + b"X=IC(" * 180_000 + b"\n", "siemens", False),
    "a line of messages": (b"MSG(" * 220_000 + b"\n", "siemens", False),
    "a line of checksums": (b"*1 " * 300_000 + b"\n", "marlin", False),
    "carriage returns": (b"\r" * 900_000 + b"\n", "linuxcnc", False),
    "empty lines": (b"\n" * 500_000, "linuxcnc", False),
    "tapes": (b"%\n" * 50_000, "linuxcnc", False),
    "presets": (HERE + b"G92 X1. Y2.\n" * 1500, "linuxcnc", False),
    "tools": (b"T0101\n" * 10_000, "fanuc-lathe", False),
    "G10 of no offset": (
        b"G10 L2 P1000000000000000000 X5.\nG10 L2 P100000000000000000 X5.\n",
        "linuxcnc",
        False,
    ),
    "eighteen digits": (b"G1 X999999999999999999 F1\nG1 X.999999999999999999\n", "linuxcnc", False),
    "faults behind the end": (b"M2\n" + b"G1 X#\n" * 20_000, "linuxcnc", False),
}
MOST_MEMORY = 300  # MB beyond what the test run takes itself
MOST_TIME = 30  # s, for a machine that does other things too; one that does not needs 2


@pytest.mark.parametrize("what", LONG)
def test_long_and_deep_ones_end_in_time_and_memory(what):
    """In a process of its own, whose memory is its own."""
    text, name, expand = LONG[what]
    child = os.fork()
    if not child:
        os._exit(_measure(Case(text, name, expand=expand)))
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0, RESULTS.get(
        os.waitstatus_to_exitcode(status), "it died"
    )


RESULTS = {0: "well", 1: "something else than a ProgramError", 2: "too much memory", 3: "too long"}


def _measure(case: Case) -> int:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with laws.in_time(MOST_TIME):
            if case.expand:
                laws.expanded(case)
            else:
                laws.outcome(filter_of(case), [case.text])
    except laws.TookTooLong:
        return 3
    except BaseException:
        return 1
    return (
        2 if resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before > MOST_MEMORY * 1024 else 0
    )
