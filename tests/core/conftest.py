"""No test measures time: a machine may be busy."""

import pytest
from alike import comparing
from hypothesis import settings

settings.register_profile("untimed")
settings.load_profile("untimed")


@pytest.fixture
def alike():
    """What a test has judged (of looks, every fiftieth) is judged in the mirrored, turned and shuffled world."""
    with comparing(every=50) as found:
        yield
    assert found == []
