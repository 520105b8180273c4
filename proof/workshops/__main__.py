"""Trials of the tool on simulated recordings of workshops.

    python -m proof.workshops --seed 1 --counts null=10,single=34 -o build/workshops-1

Makes the cases of a seed, runs `gcomp diagnose` on each, and prints the table of the other trials.
Cases, truth, answers and score stay in the folder. Other counts of a seed are other cases.
"""

from __future__ import annotations

import sys

from proof import worlds

from .trial import made


def main(argv: list[str] | None = None) -> int:
    return worlds.main("workshops", __doc__, made, argv)


if __name__ == "__main__":
    sys.exit(main())
