"""What the tests share."""

import pytest

import judge

# Scripts for other environments.
collect_ignore_glob = ["data/*"]


@pytest.fixture(scope="session")
def independent():
    """The independent judges, for tests that import nothing from there."""
    return judge
