"""Examples of the benchmarks run with `make test-long`."""

import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark those of this folder."""
    for item in items:
        if "benchmarks" in item.nodeid.split("/")[0]:
            item.add_marker(pytest.mark.long)
