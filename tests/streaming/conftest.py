"""The marker of tests that need a receiver from outside, and the folder of a job."""

import pytest


def pytest_configure(config) -> None:
    config.addinivalue_line(
        "markers", "real: a receiver that nobody here wrote; skipped where it is not installed"
    )


@pytest.fixture
def place(tmp_path):
    """A folder with a program in it."""
    from tests.streaming.stream_process import program  # where there are no pseudo-terminals: none

    (tmp_path / "job.nc").write_text(program())
    return tmp_path
