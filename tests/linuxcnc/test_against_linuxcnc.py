"""Our interpreter against LinuxCNC's own: the same motions, to a nanometre's thousandth.

LinuxCNC also reports motions of no length (a bare G1, both halves of G28); ours has none for them,
so motions without length are left out on both sides.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.motions import CLOCKWISE, COUNTER, RAPID
from postproc.nc import dialects
from postproc.nc.state import ModalState, Setup
from postproc.units import TICKS_PER_MM
from tests.linuxcnc import oracle

AXES = ("X", "Y", "Z", "A", "B", "C")
CLOSE = 1e-9  # mm
# Programs by the beginning of their names: written out first (test_expanded.py), or not followed at
# all.
EXPANDED = ("oword_", "turn_", "sync_", "cycle_", "rotate_")
NOT_FOLLOWED = ("cutter_", "spline_", "probe_", "unknown_")
PROGRAMS = [
    p
    for p in sorted(oracle.PROGRAMS.glob("*.ngc"))
    if not p.stem.startswith(EXPANDED + NOT_FOLLOWED)
]
REFUSED = sorted(oracle.REFUSED.glob("*.ngc"))
WORK = {
    5221 + 20 * i: name
    for i, name in enumerate(("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"))
}


def setup_for(kwargs) -> Setup:
    offsets = {name: dict.fromkeys(AXES, 0.0) for name in WORK.values()}
    for number, value in (kwargs.get("parameters") or {}).items():
        for base, name in WORK.items():
            if base <= int(number) < base + 6:
                offsets[name][AXES[int(number) - base]] = float(value)
    parameters = kwargs.get("parameters") or {}
    if parameters.get(5210):
        offsets["G92"] = {axis: float(parameters.get(5211 + i, 0.0)) for i, axis in enumerate(AXES)}
    for name, base in (("G28", 5161), ("G30", 5181)):
        offsets[name] = {axis: float(parameters.get(base + i, 0.0)) for i, axis in enumerate(AXES)}
    for number, tool in (kwargs.get("tools") or {}).items():
        offsets[f"T{number}"] = {axis: float(tool.get(axis, 0.0)) for axis in AXES}
    return Setup(
        axes=AXES,
        least_increment=dict.fromkeys(AXES, 1e-4),
        offsets=offsets,
        start=dict.fromkeys(AXES, 0.0),
        block_delete=kwargs.get("block_delete", False),
    )


def ours(text: str, kwargs) -> list[dict]:
    """Motions with length, as plain numbers; unknown positions are None."""
    from postproc.filter import Filter, setup_of
    from postproc.machine import places

    setup = setup_for(kwargs)
    seen: list[dict] = []

    class Watched(Filter):
        def _pass(self, words):
            motions, _, _ = self.interpreter.run(words, self.modal)
            result = super()._pass(words)
            seen.extend(plain(motions, words, self.summary.lines - words.text.count(b"\n")))
            return result

    machine = places.load("perfect")
    watched = Watched(machine, dialects.load("linuxcnc"), setup)
    assert setup_of(machine).axes == AXES
    watched.modal = initial_state(watched.modal, kwargs)
    watched.feed(text.encode())
    watched.finish()
    return seen


def initial_state(state: ModalState, kwargs) -> ModalState:
    """The modal state with what the parameters say of the start: work offset, G92, no tool."""
    parameters = kwargs.get("parameters") or {}
    active = int(parameters.get(5220, 1))
    codes = {**state.codes, "work offset": 530 + 10 * active if active < 7 else 584 + active}
    stored = [round(float(parameters.get(5211 + i, 0.0)) * TICKS_PER_MM) for i in range(6)]
    frame = replace(state.frame, preset=np.array(stored), preset_on=bool(parameters.get(5210)))
    return replace(state, codes=codes, frame=frame, tool_number=0, next_tool=0)


def plain(motions, words, first_line) -> list[dict]:
    arc_of = {int(m): k for k, m in enumerate(motions.arcs.motion)}
    result = []
    for i in range(len(motions)):
        start = [
            s / TICKS_PER_MM if k else None
            for s, k in zip(motions.start[:, i], motions.start_known[:, i], strict=True)
        ]
        end = [
            t / TICKS_PER_MM if k else None
            for t, k in zip(motions.target[:, i], motions.target_known[:, i], strict=True)
        ]
        one = {
            "line": first_line + int(words.line[motions.block[i]]) + 1,
            "start": start,
            "end": end,
            "reason": motions.reasons[int(motions.reason[i])],
        }
        one["kind"] = {RAPID: "rapid", CLOCKWISE: "arc", COUNTER: "arc"}.get(
            int(motions.code[i]), "feed"
        )
        if one["kind"] == "arc":
            k = arc_of[i]
            one["centre"] = tuple(motions.arcs.centre[:, k])
            one["sweep"] = float(motions.arcs.sweep[k])
        hole = np.flatnonzero((motions.holes.motion == i) & ~motions.holes.place)
        if len(hole):  # G33.1: there and back
            down = list(end)
            down[int(motions.holes.axis[hole[0]])] = (
                float(motions.holes.bottom[hole[0]]) / TICKS_PER_MM
            )
            result += [{**one, "end": down}, {**one, "start": down}]
        elif one["kind"] == "arc" or start != end:
            result.append(one)
    return result


@pytest.fixture(scope="module")
def theirs():
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    loaded = {path: oracle.load(path) for path in PROGRAMS}
    return dict(zip(loaded, oracle.motions_of_many(list(loaded.values())), strict=True))


def test_there_are_enough_programs():
    assert len(PROGRAMS) >= 300
    assert len(REFUSED) >= 150


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_motions_are_those_of_linuxcnc(path, theirs):
    expected = theirs[path]
    assert isinstance(expected, list), expected
    text, kwargs = oracle.load(path)
    mine = ours(text, kwargs)
    lost = reference_lines(text)
    expected = [
        m
        for m in expected
        if m.kind != "dwell"
        and m.line not in lost
        and (
            m.kind == "arc" or max(abs(a - b) for a, b in zip(m.start, m.end, strict=True)) > CLOSE
        )
    ]
    mine = [m for m in mine if m["line"] not in lost]
    blank = len(text[: text.find("%")].split("\n")) - 1 if text.lstrip().startswith("%") else 0
    # LinuxCNC does not count blank lines before the first "%".
    assert [(m["line"] - blank, m["kind"]) for m in mine] == [(m.line, m.kind) for m in expected]
    for a, b in zip(mine, expected, strict=True):
        assert not a["reason"][0], a
        for axis in range(6):
            if a["end"][axis] is not None:
                assert a["end"][axis] == pytest.approx(b.end[axis], abs=CLOSE), (a, b)
            if a["start"][axis] is not None:
                assert a["start"][axis] == pytest.approx(b.start[axis], abs=CLOSE), (a, b)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b)
            assert math.copysign(1, a["sweep"]) == math.copysign(1, b.turns)
            assert full_turns(a["sweep"]) == abs(b.turns), (a, b)


def full_turns(sweep: float) -> int:
    """LinuxCNC counts begun turns."""
    return math.ceil(abs(sweep) / (2 * math.pi) - 1e-9)


def reference_lines(text: str) -> set[int]:
    """Lines with G28 or G30: to a place that our machine files do not know, so it is not
    followed."""
    import re

    return {
        n
        for n, line in enumerate(text.split("\n"), 1)
        if re.search(r"[gG]\s*0*(28|30)(?![\d.])", re.sub(r"\([^)]*\)|;.*", "", line))
    }


# Refused by LinuxCNC for their feed, spindle, dwell, layout or end: gcomp follows them, and they
# move as written.
MANNERS = set(
    """
    dwell_negative dwell_without_time feed_missing feed_per_revolution_no_speed
    home_with_motion_code line_too_long line_with_p_word machine_coordinates_no_words n_not_first
    negative_feed no_end no_second_percent o_number_with_words percent_in_middle percent_with_text
    two_m_codes unknown_m_code
    """.split()
)


# Refused by LinuxCNC for what a cycle, a tool table or a dwell lacks: it stops there by itself, and
# what gcomp writes stops it at the same block.
MANNERS |= set(
    """
    cycle_code_alone cycle_code_changed_without_r cycle_dwell_missing cycle_inverse_time
    cycle_peck_missing cycle_peck_zero cycle_r_alone cycle_rotary_word
    cycle_spindle_stopped cycle_without_feed feed_zero g10_l1_bad_orientation g10_l1_missing_tool
    g10_l1_without_words g10_l2_with_i g10_with_motion_code g52_without_words
    g92_under_cutter_compensation g92_with_motion_code g92_without_words orientation_out_of_range
    output_number_missing reference_two_codes speed_missing speed_negative
    sync_tap_spindle_stopped sync_tap_wrong_way sync_thread_without_lead tool_change_needs_q
    tool_length_added_without_h tool_length_h_fraction tool_length_h_without_g43 tool_missing
    """.split()
)


@pytest.mark.parametrize("path", REFUSED, ids=lambda p: p.stem)
def test_what_linuxcnc_refuses_is_not_taken_for_a_motion(path):
    """Refused outright, or handed on with a reason (so refused wherever a correction would depend
    on it)."""
    text, kwargs = oracle.load(path)
    text = text.replace("\nM2", "\nG0 X1.5 Y2.5\nM2")  # a motion that a reason can stand beside
    try:
        refused = any(m["reason"][0] for m in ours(text, kwargs))
    except ProgramError:
        refused = True
    assert refused != (path.stem in MANNERS)


@pytest.mark.parametrize("units", ["G20", "G21"])
def test_how_far_an_arc_may_miss_its_end_by_units(units):
    """Radii 1 to 4000 (unit of the program), the miss on either side of each of LinuxCNC's limits:
    refused by both or by none."""
    if oracle.available():
        pytest.skip(oracle.available())
    limit = 0.002 * 2**0.5 * (1 if units == "G20" else 10)
    cases = []
    for radius in (1.0, 2.0, 30.0, 4000.0):
        for edge in (limit, 0.001 * radius, 100 * limit):
            for miss in (edge * 0.98, edge * 1.02):
                cases.append(
                    (
                        miss,
                        (
                            f"{units} G90\nG0 X0 Y0\nG2 X{2 * radius + miss:.6f} Y0 I{radius:g} J0"
                            " F10\nM2\n"
                        ),
                    )
                )
    judged = oracle.motions_of_many([(text, {}) for _, text in cases])
    refused = [isinstance(answer, oracle.ProgramError) for answer in judged]
    mine = [any("misses" in m["reason"][0] for m in ours(text, {})) for _, text in cases]
    assert mine == refused
    assert 4 < sum(refused) < len(cases) - 4
