"""Stop signs that are in CARLA's towns but not in their OpenDRIVE files."""

from __future__ import annotations

_TRIGGERS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "Town04": (
        (189.93, -169.58, 0.3),
        (198.84, -180.40, 91.3),
        (201.95, -163.35, 271.3),
        (212.05, -172.95, 180.3),
        (245.63, -246.14, 359.6),
        (255.20, -258.51, 90.2),
        (258.63, -237.08, 270.2),
        (267.72, -249.80, 179.6),
    ),
}
"""Town to the middles of the trigger volumes on their lanes, m, in CARLA's frame, and the lanes' yaw in degrees: the
`stop_sign_centers_np` that fail2drive (MIT) keeps in `toolbox/carla_map_data`. Town10HD's three are in its file."""


def unlisted_stops(town: str, listed: int) -> tuple[tuple[float, float, float], ...]:
    """Return x, y (m) and yaw (degrees) of the stop signs that `town` has besides the `listed` ones of its file.

    Empty if the file lists stop signs itself: then it is another version of the town.
    """
    return () if listed else _TRIGGERS.get(town.removesuffix("_Opt"), ())
