"""What the tests share."""

import pytest

import judge


@pytest.fixture(scope="session")
def independent():
    """The independent judges, for tests that import nothing from there."""
    return judge
