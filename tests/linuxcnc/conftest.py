"""The marker of tests against a controller that nobody here wrote."""


def pytest_configure(config):
    config.addinivalue_line(
        "markers", "real: a receiver that nobody here wrote; skipped where it is not installed"
    )
