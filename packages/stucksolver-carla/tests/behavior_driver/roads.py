"""A straight road written for the tests: 400 m along x, two lanes forward (broken line between), one back."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import carla

LENGTH_M = 400.0
LANE_M = 3.5
LANE_Y = {-1: LANE_M / 2.0, -2: 1.5 * LANE_M, 1: -LANE_M / 2.0}
"""y of each lane's center in CARLA's frame, where y grows to the right of the road."""

_LANE = """<lane id="{id}" type="driving" level="false"><link/>
<width sOffset="0" a="3.5" b="0" c="0" d="0"/>
<roadMark sOffset="0" type="{mark}" weight="standard" color="white" width="0.12" laneChange="{change}"/></lane>"""

_ROAD = """<?xml version="1.0" standalone="yes"?>
<OpenDRIVE><header revMajor="1" revMinor="4" name="" version="1" north="0" south="0" east="0" west="0"/>
<road name="r" length="{length}" id="1" junction="-1"><link/>
<planView><geometry s="0" x="0" y="0" hdg="0" length="{length}"><line/></geometry></planView>
<elevationProfile><elevation s="0" a="0" b="0" c="0" d="0"/></elevationProfile><lateralProfile/>
<lanes><laneSection s="0"><left>{left}</left>
<center><lane id="0" type="none" level="false"><roadMark sOffset="0" type="solid" weight="standard"
 color="yellow" width="0.12" laneChange="none"/></lane></center>
<right>{near}{far}</right></laneSection></lanes></road></OpenDRIVE>"""


@lru_cache(maxsize=1)
def straight_road() -> Any:
    """The road as `carla.Map`."""
    text = _ROAD.format(
        length=LENGTH_M,
        left=_LANE.format(id=1, mark="solid", change="none"),
        near=_LANE.format(id=-1, mark="broken", change="both"),
        far=_LANE.format(id=-2, mark="solid", change="none"),
    )
    return carla.Map("straight", text)
