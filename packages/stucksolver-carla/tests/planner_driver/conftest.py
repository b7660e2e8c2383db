"""The planner drives CARLA's vehicles."""

import pytest

pytest.importorskip("carla")
