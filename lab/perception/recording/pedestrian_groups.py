"""Groups of pedestrians in a crowd: a network that was trained on single pedestrians mistakes six of them for a car.

The numbers are ours.
"""

from __future__ import annotations

from random import Random

EVERY_M = 30.0
"""Average distance between groups along the route (m)."""
SIZES = (2, 7)
"""Smallest and largest number of pedestrians of a group."""
APART_M = (0.45, 0.8)
"""Range of the distances between neighbors, and between rows and columns (m)."""
REACH_M = 1.8
"""Radius of the space that a group requires (m)."""
STANDS = 0.6
"""Share of the groups that stand still; the others walk together."""
ASIDE = (0.3, 1.6)
"""Range of the distances from the center of the ego's lane, in widths of the lane."""
ROWS = (1, 1, 2, 2, 3)
"""Numbers of rows, each equally likely."""


def places_of_a_group(chance: Random) -> list[tuple[float, float]]:
    """Return the positions of the pedestrians of a group (m), to the right of its center and ahead.

    They stand in one to three rows, each a little out of line. No two are nearer than the least of `APART_M`.
    """
    count, rows = chance.randint(*SIZES), chance.choice(ROWS)
    least_m, most_m = APART_M
    step_m = chance.uniform(least_m + 0.1, most_m)
    columns = -(-count // rows)
    jitter_m = (step_m - least_m) / 2.0
    places = []
    for number in range(count):
        column, row = number % columns, number // columns
        right_m = (column - (columns - 1) / 2.0) * step_m + chance.uniform(-jitter_m, jitter_m)
        places.append((right_m, (row - (rows - 1) / 2.0) * step_m))
    return places
