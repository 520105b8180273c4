"""A Dask scheduler in a process of its own, with workers of its own: the same results, and a killed
worker loses nothing."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.batch.test_batch import COUNT, ledger, programs, results, run

pytestmark = pytest.mark.skipif(  # found, and not loaded by every worker that collects the tests
    importlib.util.find_spec("distributed") is None,
    reason="Dask is not installed (pip install 'gcomp[cluster]')",
)
ROOT = Path(__file__).resolve().parents[2]
START = 60.0  # s


def started(*words: str) -> subprocess.Popen:
    env = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "DASK_DISTRIBUTED__ADMIN__LOG_FORMAT": "%(message)s",
    }
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        env=env,
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )


def address_in(file: Path) -> str:
    import json

    limit = time.monotonic() + START
    while time.monotonic() < limit:
        if file.exists() and file.read_text().strip():
            return json.loads(file.read_text())["address"]
        time.sleep(0.05)
    raise AssertionError("the scheduler does not start")


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """Address of a scheduler with two workers, each a process that was begun elsewhere."""
    folder = tmp_path_factory.mktemp("dask")
    file = folder / "scheduler.json"
    own = ("--no-dashboard",)
    children = [
        started(
            "dask_scheduler",
            "--port",
            "0",
            "--host",
            "127.0.0.1",
            "--scheduler-file",
            str(file),
            *own,
        )
    ]
    try:
        address = address_in(file)
        for k in range(2):
            children.append(
                started(
                    "dask_worker",
                    address,
                    "--nthreads",
                    "1",
                    "--no-nanny",
                    *own,
                    "--local-directory",
                    str(folder / str(k)),
                )
            )
        yield address, children
    finally:
        for child in children:
            child.kill()
            child.wait()


def test_the_workers_of_a_scheduler_give_the_same_and_one_that_is_killed_loses_nothing(
    tmp_path, monkeypatch, scheduler
):
    monkeypatch.chdir(tmp_path)
    programs(tmp_path / "in")
    address, children = scheduler
    assert run("in", "--machine", "studer-s36", "-o", "here", "-j", 1, "--quiet") == 0
    assert (
        run("in", "--machine", "studer-s36", "-o", "there", "--scheduler", address, "--quiet") == 0
    )
    assert results(tmp_path / "there") == results(tmp_path / "here")
    assert len(ledger(tmp_path / "there")) == COUNT
    children[1].send_signal(signal.SIGKILL)
    assert (
        run("in", "--machine", "studer-s36", "-o", "again", "--scheduler", address, "--quiet") == 0
    )
    assert results(tmp_path / "again") == results(tmp_path / "here")
    # Done files are not done again, whoever did them.
    assert (
        run("in", "--machine", "studer-s36", "-o", "there", "--scheduler", address, "--quiet") == 0
    )
    assert len(ledger(tmp_path / "there")) == COUNT
