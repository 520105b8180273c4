"""How many random cases a campaign makes: some in every run of the tests, all of them with
GCOMP_CAMPAIGN=1 in the environment (before a release, or after a change of what the campaign
judges)."""

from __future__ import annotations

import os


def cases(every_run: int, whole: int) -> int:
    """The number of cases of this run."""
    return whole if os.environ.get("GCOMP_CAMPAIGN") else every_run
