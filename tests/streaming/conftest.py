"""The marker of tests that need a receiver from outside."""


def pytest_configure(config) -> None:
    config.addinivalue_line(
        "markers", "real: a receiver that nobody here wrote; skipped where it is not installed"
    )
