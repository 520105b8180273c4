"""The truth opened: every case judged, the asked tests tried, the loop closed, the baselines run,
metadata searched for leaks."""

from __future__ import annotations

import json
import math
import traceback
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from proof import baselines, loop, score, score_table, trial_leaks, trial_run, trial_tests

BASELINE_TIERS = ("null", "single", "masked")


def judged(places, jobs: int, say: Callable = print) -> dict[str, Any]:
    """All that a score holds: lines of the table, outcomes by case, baselines, loop, leaks."""
    truth = json.loads((places.sealed / "truth.json").read_text())
    details = json.loads((places.sealed / "details.json").read_text())
    cost = json.loads((places.first / "run.json").read_text())
    outcomes, blind = [], []
    for case in sorted(truth):
        tier, answer = details[case]["kind"], trial_run.read(places.first, case)
        outcome = score.judge(case, tier, truth[case], answer, cost[case]["seconds"])
        outcome.failed = (outcome.failed and cost[case].get("said", "").strip()[-160:]) or cost[
            case
        ].get("said", "")
        outcomes.append(outcome)
        if tier == "blind":
            blind.append(_spotted(places, case, details[case]["blind"], answer))
    rows = score_table.lines(outcomes, blind)
    say("closing the loop")
    closed = [
        c
        for c in sorted(truth)
        if details[c]["kind"] in ("single", "masked") and loop.wanted(truth[c])
    ]
    with ProcessPoolExecutor(jobs) as pool:
        loops = list(
            pool.map(
                _closed,
                [(c, details[c], places.cases / c, places.first / c / "machine") for c in closed],
            )
        )
        say("running the baselines")
        named = [o for o in outcomes if o.tier in BASELINE_TIERS]
        guesses = dict(
            zip(
                [o.case for o in named],
                pool.map(_guessed, [places.cases / o.case for o in named]),
                strict=True,
            )
        )
    good = [x for x in loops if isinstance(x, loop.Looped)]
    rows.append(_loop_line(good))
    say("looking for leaks")
    tiers = {
        tier: [places.cases / c for c in sorted(truth) if details[c]["kind"] == tier]
        for tier in ("null", "single")
    }
    return {
        "lines": [
            asdict(r) | {"value": None if math.isnan(r.value) else r.value, "cells": r.cells()}
            for r in rows
        ],
        "failures": score_table.failures(rows),
        "outcomes": [asdict(o) for o in outcomes],
        "blind": [asdict(s) for s in blind],
        "loop": [asdict(x) | {"ratio": x.ratio} for x in good],
        "loop_failed": [x for x in loops if isinstance(x, str)],
        "baselines": _compared(named, guesses),
        "leak": asdict(trial_leaks.leak(tiers["null"], tiers["single"])),
    }


def _spotted(
    places, case: str, blind: dict[str, Any], first: dict[str, Any] | None
) -> score.Spotted:
    later = score.judge(case, "follow-up", blind["follow_up"], trial_run.read(places.later, case))
    _, tests = score.openly(first, blind)
    shows = [trial_tests.shows(blind, t, places.cases / case / "machine") for t in tests]
    return score.spotted(case, blind, first, shows, later)


def _closed(work: tuple[str, dict, Path, Path]) -> loop.Looped | str:
    try:
        return loop.close(*work)
    # a program that the judge can not read is a finding, not the end of the trial
    except Exception as error:
        return f"{work[0]}: {type(error).__name__}: {error}"


def _guessed(case: Path) -> dict[str, dict] | str:
    try:
        return baselines.all_of(case)
    except Exception:
        return traceback.format_exc().strip().splitlines()[-1]


def _loop_line(good: list[loop.Looped]) -> score_table.Line:
    line = score_table.number(
        "loop: largest path error, diagnosed over geometry alone: median",
        [x.ratio for x in good],
        0.5,
        most=0.35,
    )
    line.failures = [
        f"{x.case} {', '.join(x.truth)}: {x.uncompensated:.1f} um as it is, {x.geometry:.1f} map"
        f" alone, {x.diagnosed:.1f} diagnosed{'; ' + x.note if x.note else ''}"
        for x in good
        if x.ratio > 0.35
    ]
    return line


def _compared(outcomes: list[score.Outcome], guesses: dict[str, Any]) -> list[dict[str, Any]]:
    """One row a method: how often a null gets a name, how often the first name of a single effect
    is right, and the rms of what was held out over the noise floor, on the same cases."""
    usable = [o for o in outcomes if isinstance(guesses[o.case], dict)]
    rows = []
    for method in ("gcomp", *baselines.METHODS):

        def names(o: score.Outcome, method: str = method) -> list[str]:
            return o.names if method == "gcomp" else guesses[o.case][method]["names"]

        def after(o: score.Outcome, method: str = method) -> float | None:
            return o.after if method == "gcomp" else guesses[o.case][method]["after_um"]

        nulls = [bool(names(o)) for o in usable if o.tier == "null"]
        top = [
            score.hit(o.truths[k], names(o)[:1])
            for o in usable
            if o.tier != "null"
            for k in range(len(o.truths))
        ]
        ratio = [
            v / o.floor
            for o in usable
            if o.tier != "null" and o.floor and (v := after(o)) is not None
        ]
        rows.append(
            {
                "method": method,
                "nulls": len(nulls),
                "null_named": sum(nulls),
                "effects": len(top),
                "top": sum(top),
                "ratios": len(ratio),
                "median": score_table.quantile(ratio, 0.5),
                "p90": score_table.quantile(ratio, 0.9),
                "names": method not in ("map alone", "Gaussian process"),
            }
        )
    return rows
