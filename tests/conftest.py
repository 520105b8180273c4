"""The laws draw the same examples in every run; GCOMP_FUZZ=1 draws new ones, to look for what nobody thought of."""

import os

import pytest
from hypothesis import settings

# As the command line does, before numpy is loaded: with two threads for each of two workers the diagnosis' tests took 2.2 times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from postproc.errors import GcompError

MOST_LINES = 4  # where and what, the line, the columns, the way out

# No deadline: a time limit of 0.2 s an example fails where the computer is busy. Timing is for benchmarks.
settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("new", derandomize=False, deadline=None)
settings.load_profile("new" if os.environ.get("GCOMP_FUZZ") else "same")


@pytest.fixture(autouse=True)
def no_long_message(monkeypatch):
    """No error that a test provokes has more than four lines."""
    made: list[GcompError] = []
    begin = GcompError.__init__

    def kept(self, *words, **more):
        begin(self, *words, **more)
        if len(made) < 1000:
            made.append(self)

    monkeypatch.setattr(GcompError, "__init__", kept)
    yield
    long = [str(error) for error in made if len(str(error).splitlines()) > MOST_LINES]
    assert not long, long[0]
