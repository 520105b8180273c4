"""The laws draw the same examples in every run; GCOMP_FUZZ=1 draws new ones, to look for what
nobody thought of."""

import gc
import os
import sys

import pytest

# As the command line does, before numpy is loaded: with two threads for each of two workers the
# diagnosis' tests took 2.2 times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Each worker, and each command that a test starts, loads what was compiled once: 14 s of a worker
# that collects the tests, 0.2 s of each command. Before hypothesis, which is compiled here too.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

from hypothesis import HealthCheck, settings  # noqa: E402

from postproc import kernel  # noqa: E402
from postproc.errors import GcompError  # noqa: E402
from tests import slow_tests  # noqa: E402

MOST_LINES = 4  # where and what, the line, the columns, the way out

# No limit of time for an example or for drawing it: such limits fail where the computer is busy.
# Timing is for benchmarks.
CALM = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("same", derandomize=True, **CALM)
settings.register_profile("new", derandomize=False, **CALM)
settings.load_profile("new" if os.environ.get("GCOMP_FUZZ") else "same")


@pytest.hookimpl(optionalhook=True)  # without pytest-xdist nobody asks
def pytest_xdist_auto_num_workers(config):
    """Two more than there are processors: of the time of all tests, the streaming ones wait for a
    third. Without the slow ones hardly any waits, and each worker collects all tests (5 s)."""
    waits = "not slow" not in config.option.markexpr
    return (os.cpu_count() or 1) + 2 * waits


def pytest_configure(config):
    if hasattr(config.option, "loadscopereorder"):
        # else pytest-xdist begins with the files of most tests, and ends with the longest tests
        config.option.loadscopereorder = False


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What was loaded by its end stays: the collector of garbage looks at it neither now nor later
    (0.9 s of a worker, then a twentieth of the time of the tests)."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


def pytest_collection_modifyitems(items):
    """The slow ones are marked, and the files put in order."""
    slow = slow_tests.listed()
    files: dict[str, list[pytest.Item]] = {}
    for item in items:
        if slow_tests.name_of(item.nodeid) in slow:
            item.add_marker("slow")
        files.setdefault(slow_tests.file_of(item.nodeid), []).append(item)
    items[:] = [item for name in slow_tests.in_order(files) for item in files[name]]


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


@pytest.fixture(scope="module", params=[False, True] if kernel.library() else [False])
def both_ways(request):
    """Without the compiled kernel, and with it where it was built: for tests that compare bytes of
    arcs."""
    with pytest.MonkeyPatch.context() as m:
        if not request.param:
            m.setattr(kernel, "library", lambda: None)
        yield
