"""What streaming promises, on a real GRBL 1.1h image, judged by the step pulses of its motors.

    python -m proof.streaming whole          12 programs, whole
    python -m proof.streaming interrupted    each of them, interrupted in seven ways at random
                                             lines, and begun again
    python -m proof.streaming faults         100 schedules of faults on the wire and at the machine
    python -m proof.streaming short          20 clean jobs of pieces of 0.1 to 1 mm at F1000 to
                                             F5000

Needs ../shared/receivers and as many seconds as the machine would (10 to 40 a job). A job in which
the simulator could not keep up with the clock is made again. Exit status 1 where something was not
as promised."""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections import Counter
from collections.abc import Callable

from proof.streaming import faults, programs, real
from proof.streaming.real import Row
from tests.streaming import real_grbl

AGAIN = 4  # times that a job is made again where the simulator fell behind
Case = Callable[[], Row]


def cases(kind: str, seed: int) -> list[Case]:
    """All jobs of one campaign."""
    if kind == "whole":
        return [lambda make=make: real.clean(make()) for make in programs.ALL]
    if kind == "interrupted":
        return [
            lambda make=make, how=how: real.interrupted(make(), how, seed)
            for make, how in itertools.product(programs.ALL, real.ALL)
        ]
    if kind == "faults":
        return [lambda k=k: faults.schedule(1000 * seed + k) for k in range(100)]
    return [lambda k=k: faults.quick(20 * seed + k) for k in range(20)]


def kept_up(case: Case) -> Row:
    """A job in which the simulator kept up with the clock."""
    for _ in range(AGAIN):
        row = case()
        if row.behind < real_grbl.BEHIND:
            return row
        print(f"  again: the simulator fell {row.behind:.1f} s behind in {row.what}", flush=True)
    return row


def main() -> int:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("kind", choices=("whole", "interrupted", "faults", "short"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="jobs by number, from 0: 3,5,17")
    options = parser.parse_args()
    why = real_grbl.missing()
    if why:
        parser.error(why)
    wanted = {int(k) for k in options.only.split(",") if k}
    ends: Counter = Counter()
    wrong, twice, unseen = [], [], []
    for number, case in enumerate(cases(options.kind, options.seed)):
        if wanted and number not in wanted:
            continue
        begun = time.monotonic()
        row = kept_up(case)
        ends[row.status] += 1
        wrong += [row.what] * (not row.right)
        twice.append(row.verdict.twice if row.verdict else 0)
        unseen += [round(row.unseen, 3)] * (row.unseen > 0)
        words = row.verdict.words() if row.verdict else ""
        mark = "right" if row.right else "WRONG"
        took = time.monotonic() - begun
        print(f"{number} {mark} {row.what}: exit {row.status}; {words}; {took:.0f} s")
        if not row.right or not row.verdict:
            print(f"    {row.said}")
        sys.stdout.flush()
    print(
        f"{sum(ends.values())} jobs, exit statuses {dict(ends)}; twice {max(twice, default=0)}"
        f" motions; done and aside, mm: {sorted(unseen)}; wrong {len(wrong)}: {wrong}"
    )
    return bool(wrong)


if __name__ == "__main__":
    raise SystemExit(main())
