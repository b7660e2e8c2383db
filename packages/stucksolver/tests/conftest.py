"""No test measures time: a machine may be busy."""

import pytest
from hypothesis import settings

from alike import comparing

settings.register_profile("untimed")
settings.load_profile("untimed")


@pytest.fixture
def alike():
    """What a test has judged (of looks, every fiftieth) is judged in the mirrored, turned and shuffled world."""
    with comparing(every=50) as found:
        yield
    assert found == []
