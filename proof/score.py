"""One case judged: what is hidden in it against what was answered (format gcomp-diagnosis/1). Opens
nothing.

A name is right when effect and axis are those of the truth; the axes of a pair in any order; an
effect that belongs to no axis (light in the air, a late recorder, or a truth that names none:
contract, "null where none applies"; a beam along a diagonal) is right by its name. Truths that the
generator's own oracle calls invisible in these recordings ask for nothing, and naming them is no
mistake.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

NO_AXIS = {"laser_air", "dead_path", "delay", "clock_skew", "tool_size"}
OF_BEAM = {"cosine"}  # of a beam along which several axes move it is of none of them
# medians of these are stated
VALUES = {"backlash": "size_um", "cyclic": "amplitude_um", "servo_lag": "tau_ms"}
NARROWEST = 1e-9  # of the value: an interval that narrow is none
# The contract says that two axes lag differently, not which of them is taken from which.
UNSIGNED = {"delta_tau_ms"}


def kept(found: dict[str, Any]) -> str:
    """The JSON of a trial's score to be kept: a line for each case, so that a person can read and
    compare it."""
    held = []
    for name, value in found.items():
        rows = ",\n".join(json.dumps(one) for one in value) if isinstance(value, list) else ""
        held.append(f"{json.dumps(name)}: " + (f"[\n{rows}\n]" if rows else json.dumps(value)))
    return "{\n" + ",\n".join(held) + "\n}\n"


def key_of(effect: dict[str, Any]) -> str:
    """effect:axis, as the contract writes it."""
    return f"{effect['effect']}:{effect['axis'] or ''}"


def same(truth: str, name: str) -> bool:
    """Whether a name, written effect:axis, is the truth's."""
    (a, _, x), (b, _, y) = truth.partition(":"), name.partition(":")
    of_none = a in NO_AXIS or not x or (a in OF_BEAM and not y)
    return a == b and (sorted(x) == sorted(y) or of_none)


def hit(truth: str, names: list[str]) -> bool:
    return any(same(truth, n) for n in names)


@dataclass
class Outcome:
    """What became of one case. top, named, in_set: for each visible truth whether it was the first
    name by size, among the names, or among the names and their equivalents; wrong: accepted names
    that are no truth; errors: (effect, relative error of its size); inside: for each stated 95 %
    interval of a parameter with a truth, whether it holds it."""

    case: str
    tier: str
    names: list[str] = field(default_factory=list)
    unknown: bool = False
    truths: list[str] = field(default_factory=list)
    peaks: list[float] = field(default_factory=list)
    apart: list[bool] = field(default_factory=list)
    top: list[bool] = field(default_factory=list)
    named: list[bool] = field(default_factory=list)
    in_set: list[bool] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    errors: list[tuple[str, float]] = field(default_factory=list)
    inside: list[bool] = field(default_factory=list)
    before: float | None = None
    after: float | None = None
    floor: float | None = None
    coverage: float | None = None
    seconds: float = 0.0
    failed: str = ""


def accepted(answer: dict[str, Any]) -> list[dict[str, Any]]:
    """Accepted effects, the one that explains most first."""
    found = [e for e in answer.get("effects", []) if e.get("status") == "accepted"]
    return sorted(found, key=lambda e: -e.get("rms_explained_um", 0.0))


def unknown(answer: dict[str, Any]) -> bool:
    return answer.get("unknown") is not None or answer.get("verdict") == "unknown"


def judge(
    case: str,
    tier: str,
    truth: list[dict[str, Any]],
    answer: dict[str, Any] | None,
    seconds: float = 0.0,
) -> Outcome:
    """The outcome of one case. answer: None where the tool gave none."""
    outcome = Outcome(case, tier, seconds=seconds)
    if answer is None:
        outcome.failed = "no answer"
        answer = {}
    effects = accepted(answer)
    # twice the same is a shape refined, one name
    outcome.names = list(dict.fromkeys(key_of(e) for e in effects))
    outcome.unknown = unknown(answer)
    wanted = [key_of(t) for t in truth]
    sets = [n for e in effects for n in [key_of(e), *(e.get("equivalent") or [])]]
    for t, key in zip(truth, wanted, strict=True):
        if not t.get("visible", True):
            continue
        outcome.truths.append(key)
        outcome.peaks.append(float(t["peak_um"]))
        outcome.apart.append(not t.get("twins"))
        outcome.top.append(hit(key, outcome.names[:1]))
        outcome.named.append(hit(key, outcome.names))
        outcome.in_set.append(hit(key, sets))
    outcome.wrong = [n for n in outcome.names if not any(same(w, n) for w in wanted)]
    for t in truth:
        first = next((e for e in effects if same(key_of(t), key_of(e))), None)
        if first is not None:
            _parameters(outcome, t, first)
    fit = answer.get("fit") or {}
    outcome.before, outcome.after = fit.get("rms_before_um"), fit.get("rms_after_um")
    outcome.floor, outcome.coverage = fit.get("noise_floor_um"), fit.get("coverage95")
    return outcome


def _parameters(outcome: Outcome, truth: dict[str, Any], effect: dict[str, Any]) -> None:
    for name, value in truth.get("parameters", {}).items():
        found = effect.get("parameters", {}).get(name)
        if not found or not value:
            continue
        if VALUES.get(truth["effect"]) == name:
            outcome.errors.append((truth["effect"], abs(found["value"] - value) / abs(value)))
        low, high = sorted(found.get("ci95") or (0.0, 0.0))
        if name in UNSIGNED and value * found["value"] < 0:
            value = -value
        if high - low > NARROWEST * abs(value):
            outcome.inside.append(bool(low <= value <= high))


# -- tests that can not see ------------------------------------------------------------------------


@dataclass
class Spotted:
    """A blind test. named: the answer says that this test leaves the question open; tested: the
    program that it writes would show it; asked: what it wants done; hidden, followed: whether
    something visible in the follow-up was hidden, and was named."""

    case: str
    spot: str
    named: bool
    tested: bool
    asked: str = ""
    hidden: bool = False
    followed: bool = False
    extra: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)


def openly(answer: dict[str, Any] | None, blind: dict[str, Any]) -> tuple[bool, list[str]]:
    """Whether the answer names the blind spot, and the tests that it asks for.

    Lost motion with one direction: every kind of it is named as not visible (or in a set).
    Elsewhere one of the suspects is named as not visible, or stands in a set of names that these
    recordings do not tell apart.
    """
    if answer is None:
        return False, []
    blank = {key_of(e): e.get("next_test") or "" for e in answer.get("not_visible", [])}
    sets = [
        ([key_of(e), *e["equivalent"]], e.get("next_test") or "")
        for e in answer.get("effects", [])
        if e.get("equivalent") and e.get("status") in ("accepted", "tentative")
    ]
    found, tests = [], []
    for suspect in blind["suspects"]:
        told = [test for name, test in blank.items() if same(suspect, name)]
        told += [test for names, test in sets if hit(suspect, names)]
        found.append(bool(told))
        tests += told
    every = blind["spot"] == "one_direction"
    return (all(found) if every else any(found)), [t for t in dict.fromkeys(tests) if t]


def spotted(
    case: str,
    blind: dict[str, Any],
    first: dict[str, Any] | None,
    shows: list[bool],
    later: Outcome,
) -> Spotted:
    """The blind case judged. shows: for each test that the answer asks for, whether its program
    would show the effect."""
    named, tests = openly(first, blind)
    good = [t for t, ok in zip(tests, shows, strict=True) if ok]
    wrong = [key_of(e) for e in accepted(first or {})]
    expected = blind["suspects"]
    return Spotted(
        case,
        blind["spot"],
        named,
        named and bool(good),
        (good or tests or [""])[0],
        bool(later.truths),
        bool(later.truths) and all(later.named),
        later.wrong,
        [n for n in wrong if not hit(n, expected)],
    )
