"""Trials of the tool on simulated recordings from textbooks.

    python -m proof.textbook --seed 1 --counts null=10,single=34 -o build/textbook-1

Makes the cases of a seed, runs `gcomp diagnose` on each, and prints the table of the other trials.
Cases, truth, answers and score stay in the folder.
"""

from __future__ import annotations

import sys

from proof import worlds

from .trial import made


def main(argv: list[str] | None = None) -> int:
    return worlds.main("textbook", __doc__, made, argv)


if __name__ == "__main__":
    sys.exit(main())
