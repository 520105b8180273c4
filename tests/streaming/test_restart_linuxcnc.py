"""LinuxCNC's interpreter as judge of A11: preamble and rest of a program end where the whole
program ends, in the same modes.

Behind the restart point, and again before the program's end, both runs are asked for their modes:
by dwells of as many seconds as the named parameters of LinuxCNC say (`G4 P[#<_feed>]`), which the
witness reports. A dwell changes nothing.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from postproc.errors import GcompError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.streaming import restart, resumable
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import setup_for

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared" / "corpus"
MODES = (
    "_plane",
    "_metric",
    "_absolute",
    "_coord_system",
    "_feed",
    "_rpm",
    "_spindle_on",
    "_spindle_cw",
    "_mist",
    "_flood",
    "_current_tool",
    "_tool_offset",
    "_units_per_minute",
    "_inverse_time",
    "_units_per_rev",
    "_lathe_diameter_mode",
)
ASK = "".join(f"G4 P[#<{m}>+5]\n" for m in MODES)
ASKED = len(MODES)
FEED = MODES.index("_feed")
# behind a change of units the interpreter asks its machine for F, and the witness has none: it says
# 1
NO_FEED = 1 + 5.0
END = re.compile(r"(?i)^[^(;]*M0*(2|30)(?![0-9])|^%")
NEEDED = {
    "sample_programs": 12,
    "inch": 3,
    "G91": 3,
    "G55": 2,
    "G43": 2,
    "arc in G18": 2,
    "spindle and coolant": 2,
}

SHAFT = """G21 G90 G18 G55 G94
T1 M6
G43 H1
G0 X20 Y0 Z30
S1500 M4
M7
M8
G1 Z10 F250
G2 X30 Z0 I0 K-10
G3 X20 Z-10 I-10 K0
G1 X5
G20 G91
G1 X1 F8
Z-0.25
G2 X0.5 Z-0.5 I0 K-0.5
G21 G90
G17
G1 X1 Y1
G2 X11 Y1 I5
G64 P0.01
G1 X2
M9
G0 Z40
G49
G54
G1 X0 F90
G0 Z20
M5
M30
"""
TOOLS = {
    "parameters": {5221: 10.0, 5223: -20.0, 5241: 100.0, 5243: -50.0},
    "tools": {1: {"Z": 12.5, "D": 6.0}},
}


def programs() -> list[tuple[str, str, dict]]:
    found = [("shaft", SHAFT, TOOLS)]
    for path in sorted((ROOT / "sample_programs").glob("*.*")):
        if path.suffix in (".nc", ".ngc"):
            found.append(
                (
                    f"sample_programs/{path.name}",
                    path.read_bytes().decode("ascii"),
                    {"tools": {1: {"Z": 0.0}, 3: {"Z": 0.0}}},
                )
            )
    for name in (
        "inch_program",
        "incremental",
        "incremental_chain_inch",
        "work_offsets",
        "work_offset_inch",
        "contour",
        "pocket_incremental",
        "tool_length_h",
        "tool_length_inch",
        "tool_length_work_offsets",
        "arcs_g18",
        "spindle_and_coolant",
        "thread_mill",
    ):
        found.append((name, *oracle.load(oracle.PROGRAMS / f"{name}.ngc")))
    for path in sorted(SHARED.glob("mixed/*.ngc")):
        found.append(
            (
                f"corpus/{path.name}",
                path.read_bytes().decode("ascii", "replace"),
                {"tools": {1: {"Z": 0.0}}},
            )
        )
    return found


def ended(lines: list[str]) -> int:
    return next((i for i, line in enumerate(lines) if i and END.match(line)), len(lines))


def restart_points(text: str, kwargs: dict) -> list[tuple[int, list[str]]]:
    """(line, preamble) wherever the job can begin again."""
    lines = text.splitlines(keepends=True)
    stop = ended(lines)
    found = []
    for line in range(3, stop, max(1, stop // 6)):
        machine = places.load("perfect")
        setup = (
            setup_for(kwargs) if kwargs else setup_of(machine, start=dict.fromkeys("XYZABC", 0.0))
        )
        filter = Filter(machine, dialects.load("linuxcnc"), setup)
        try:
            before, rest = restart.read_before(filter, [x.encode() for x in lines], line)
            resumable.refuse(filter, rest, line)
            found.append(
                (line, [x.decode() for x in restart.preamble(filter, before, {"Z": 500.0})])
            )
        except GcompError:
            continue
    return found


def runs(text: str, line: int, preamble: list[str]) -> tuple[str, str]:
    """The whole program and the resumed one, both with questions at the restart point and before
    the end."""
    lines = [
        x if x.endswith("\n") else x + "\n"
        for x in text.replace("\r", "").splitlines(keepends=True)
    ]
    stop = ended(lines)
    head, rest = "".join(lines[: line - 1]), "".join(lines[line - 1 : stop])
    body = ASK + rest + ASK + "M2\n"
    opens = lines[0].strip() == "%"
    return (head.removeprefix("%\n") if opens else head) + body, "\n".join(preamble) + "\n" + body


def of_rest(motions: list, started: int) -> list[tuple]:
    """What happens from a line on, without lengths of nothing."""
    return [
        (
            m.kind,
            *(round(x, 6) for x in m.end),
            m.centre and tuple(round(x, 6) for x in m.centre),
            m.turns,
            m.seconds and round(m.seconds, 5),
        )
        for m in motions
        if m.line > started
    ]


@pytest.fixture(scope="module")
def judged() -> list[tuple[str, int, list[str], list[str], object, object]]:
    if (why := oracle.available()) is not None:
        pytest.skip(why)
    jobs, names = [], []
    for name, text, kwargs in programs():
        for line, preamble in restart_points(text, kwargs):
            whole, resumed = runs(text, line, preamble)
            jobs += [(whole, kwargs), (resumed, kwargs)]
            names.append((name, line, preamble, text.splitlines()))
    results = oracle.motions_of_many(jobs)
    return [(*n, results[2 * i], results[2 * i + 1]) for i, n in enumerate(names)]


def test_A11_LinuxCNC_makes_the_same_motions_in_the_same_modes_after_a_restart(judged):
    wrong = []
    refused = 0
    for name, line, preamble, lines, whole, resumed in judged:
        # the program itself is none for LinuxCNC: nothing to compare
        if isinstance(whole, oracle.ProgramError):
            refused += 1
            continue
        opens = 1 if lines[0].strip() == "%" else 0
        first = [] if isinstance(resumed, oracle.ProgramError) else of_rest(resumed, len(preamble))
        all_of_it = of_rest(whole, line - 1 - opens)
        for at in (FEED, len(all_of_it) - ASKED + FEED):
            if len(first) == len(all_of_it) > at >= 0 and all_of_it[at][-1] == NO_FEED:
                first[at] = all_of_it[at]
        if all_of_it != first:
            wrong.append(f"{name}:{line}: {resumed if not first else ''} {preamble}")
        elif sum(row[0] == "dwell" for row in first) < 2 * ASKED:
            wrong.append(f"{name}:{line}: the modes were not told")
    assert not wrong, "\n".join(wrong[:5])
    assert len(judged) - refused >= 40 and refused < len(judged) / 4


def test_A11_the_restart_points_cover_what_the_design_names(judged):
    good = [j for j in judged if not isinstance(j[4], oracle.ProgramError)]

    def modes(j):
        return j[2][-2] + " " + j[2][-1]

    seen = {
        "sample_programs": sum(j[0].startswith("sample_programs") for j in good),
        "inch": sum("G20" in modes(j) for j in good),
        "G91": sum("G91" in modes(j) for j in good),
        "G55": sum("G55" in j[2] for j in good),
        "G43": sum(any(x.startswith("G43.1") for x in j[2]) for j in good),
        "arc in G18": sum(
            "G18" in modes(j) and bool(re.search("(?i)g0?[23]", j[3][j[1] - 1])) for j in good
        ),
        "spindle and coolant": sum(
            {"M7", "M8"} & set(j[2]) != set() and any(x[:2] in ("M3", "M4") for x in j[2])
            for j in good
        ),
    }
    assert all(seen[name] >= least for name, least in NEEDED.items()), seen
