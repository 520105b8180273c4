"""Trials of the tool on simulated recordings from textbooks.

    python -m proof.textbook --seed 1 --counts null=10,single=34 -o build/textbook-1

Makes the cases of a seed, runs `gcomp diagnose` on each, and prints the table of the other trials.
Cases, truth, answers and score stay in the folder.
"""

from __future__ import annotations

import argparse
import os
import sys
from functools import partial
from pathlib import Path

from proof.strangers_trial import counts
from proof.trial_seal import ROOT, SealError

from .tiers import TIERS
from .trial import trial

COUNTS = {"null": 40, "adversarial": 15, "single": 90, "pair": 24, "alien": 24}


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m proof.textbook",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, required=True, help="every case follows from it")
    parser.add_argument(
        "--counts",
        type=partial(counts, tiers=TIERS),
        default=COUNTS,
        help="how many cases of which tiers, such as null=60,single=128",
    )
    parser.add_argument(
        "-o", "--output", type=Path, help="a new folder (build/textbook/<seed> of the repository)"
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--beside", metavar="COMMIT", help="its tool on the same cases, too")
    options = parser.parse_args(argv)
    out = options.output or ROOT / "build" / "textbook" / str(options.seed)
    try:
        print(trial(options.seed, options.counts, out, options.jobs, options.beside))
    except (FileExistsError, SealError) as error:
        print(f"textbook: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
