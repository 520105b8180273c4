"""What each part of the diagnosis is worth: `python -m proof.ablations [--kinds later] [--seed S]
[--share 0.5]`.

The same cases of `proof/strangers` are answered by the whole tool and by the tool without one of
its parts, which is taken out while it runs. For development: a family that is held back is not
for it.

Of `--share 0.4` (50 cases of the open kinds). P, R: precision and recall of pairs; aliens: called
unknown, and names in one. Differences of one case are not significant. Without the threshold from
drawn nulls, burst noise, the look at the thermometers or lone wrong readings every figure is that
of the whole.

                                          nulls   first     right if           aliens   names
                                          named   name      named     P        unknown  an alien
    the whole                             1 of 16 14 of 20  14 of 15  11 of 13 2 of 6   1.67
    wander of the instruments             5 of 16 12 of 20  12 of 15  11 of 14 3 of 6   1.83
    correlation of neighbouring samples   2 of 16 13 of 20  13 of 16  11 of 14 2 of 6   1.33
    an error of the map                   2 of 16 13 of 20  13 of 17  10 of 11 3 of 6   1.83
    processes (unknown is no candidate)   1 of 16 14 of 20  14 of 17  11 of 14 0 of 6   1.50
    errors of form                        1 of 16 13 of 20  13 of 16  11 of 14 3 of 6   1.33
    a search: the single best name        1 of 16 15 of 20  15 of 17  4 of 5   2 of 6   0.83
    shapes between those of the grid      1 of 16 14 of 20  14 of 15  11 of 14 2 of 6   1.33

R is 11 of 16, without an error of the map 10, without a search 4.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np

from postproc.diagnose import (
    abrupt,
    isolated,
    map_agreement,
    noise,
    nuisances,
    search,
    sets,
    shapes,
    shared_jump,
    telegraph,
    thermometers,
)
from proof import laid, score, trial_run
from proof.strangers import make
from proof.strangers.registry import FAMILIES

TIERS = {"null": 30, "adversarial": 10, "single": 50, "pair": 20, "alien": 16}
Patch = tuple[Any, str, Any]


def _unwandering(unit: Any) -> list:
    return []


def _unpolished(found: Any, fit: Any, k: int) -> int:
    return k


PARTS: dict[str, Callable[[], list[Patch]]] = {
    "the whole": list,
    "without wander of the instruments": lambda: [(nuisances, "wander", _unwandering)],
    "without correlation of neighbouring samples": lambda: [(noise, "ORDERS", (0,))],
    "without an error of the map": lambda: [(nuisances, "of_map", _exact)],
    "without processes (unknown is no candidate)": lambda: [
        (nuisances, "processes", lambda rows, unit: [])
    ],
    "without errors of form": lambda: [
        (sets, "FORM", 0.0),
        (sets.Sets, "_forms", lambda self, fit: []),
    ],
    "without a search: the single best name": lambda: [(search, "MOST", 1)],
    "without shapes between those of the grid": lambda: [(shapes, "polished", _unpolished)],
    "without a threshold from drawn nulls": lambda: [
        (search.Search, "calibrate", lambda self, rng: None)
    ],
    "without the commonest of names that say the same": lambda: [
        (search.Search, "_commonest", lambda self, best, states: best)
    ],
    "without burst noise": lambda: [(telegraph, "levels", lambda rows, units: [None] * len(units))],
    "without a look at the thermometers": lambda: [
        (thermometers, "faulty", lambda value, time: None)
    ],
    "without lone wrong readings": lambda: [(isolated, "isolated", _nothing_isolated)],
    "without a look at the readings beside a jump": lambda: [
        (abrupt, "borne_out", lambda *_: True)
    ],
    "without departures that several readings share": lambda: [
        (shared_jump, "find", lambda *_: [])
    ],
    "without the comparison with the map's details": lambda: [
        (map_agreement, "disagreements", lambda *_: {})
    ],
}


def _nothing_isolated(
    rows: Any, residual: np.ndarray, sigma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(len(rows)), np.zeros(len(rows))


def _exact(rows: Any, machine: Any) -> list:
    return []


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m proof.ablations", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--kinds", choices=FAMILIES, default="open")
    parser.add_argument("--seed", default="ablations")
    parser.add_argument("--share", type=float, default=1.0, help="of the cases of every tier")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", help="a word of the parts' names")
    options = parser.parse_args(argv)
    work = [(tier, k) for tier, n in TIERS.items() for k in range(max(1, round(n * options.share)))]
    print(
        "| | nulls named | first name right | right, if named | P | R | alien unknown | names an"
        " alien | s |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for part in [p for p in PARTS if not options.only or options.only in p]:
        with ProcessPoolExecutor(options.jobs) as pool:
            found = list(pool.map(partial(one, part, options.seed, options.kinds), work))
        print(f"| {part} | {' | '.join(cells([o for o in found if o is not None]))} |", flush=True)
    return 0


@contextmanager
def without(part: str) -> Iterator[None]:
    """The tool without one of its parts, for the block."""
    with ExitStack() as stack:
        for place, name, value in PARTS[part]():
            stack.enter_context(patch.object(place, name, value))
        yield


def one(part: str, seed: str, kinds: str, which: tuple[str, int]) -> score.Outcome | None:
    """The answer to one case, judged; None where nothing of its truth shows."""
    tier, number = which
    case = make(seed, tier, number, kinds)
    if tier not in ("null", "adversarial") and not any(t.get("visible", True) for t in case.truth):
        return None
    with laid.folder(case) as place, TemporaryDirectory() as out, without(part):
        (place / case.name).mkdir()
        for path in [*laid.files(place), place / "machine"]:
            path.rename(place / case.name / path.name)
        done = trial_run.answer(place / case.name, [], Path(out))
        return score.judge(
            case.name, tier, case.truth, trial_run.read(Path(out), case.name), done["seconds"]
        )


def cells(outcomes: list[score.Outcome]) -> list[str]:
    """A line of the table."""
    of = {t: [o for o in outcomes if o.tier == t] for t in TIERS}
    single, pair, alien = of["single"], of["pair"], of["alien"]
    named = [o for o in single if o.names]
    return [
        _share([bool(o.names) for o in (*of["null"], *of["adversarial"])]),
        _share([o.top[k] for o in single for k in range(len(o.truths))]),
        _share([any(o.top) for o in named]),
        _share([n not in o.wrong for o in pair for n in o.names]),
        _share([v for o in pair for v in o.named]),
        _share([o.unknown for o in alien]),
        f"{sum(len(o.names) for o in alien) / max(len(alien), 1):.2f}",
        f"{np.mean([o.seconds for o in outcomes]):.1f}",
    ]


def _share(values: list[bool]) -> str:
    return f"{sum(values)} of {len(values)}"


if __name__ == "__main__":
    raise SystemExit(main())
