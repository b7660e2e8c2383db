"""The order in which the lights of CARLA's own towns are spawned, which is the order of a junction's phases.

CARLA adds a controller to its junction's cycle when the first of its lights is spawned, so the cycle follows neither
the file nor the controllers' sequence numbers. The ids below are OpenDRIVE signals in that order: the reverse of the
order in which `world.get_actors()` lists the lights, which fail2drive (MIT) keeps for each town in
`toolbox/carla_map_data` as `traffic_light_centers_np`. Other maps have no such record; theirs go by the file.
"""

from __future__ import annotations

from collections.abc import Collection

_SPAWNED = {
    "Town01": """375 377 376 390 392 391 384 385 386 367 368 366 374 372 373 395 394 393 383 381 361 362 382 389 387
        388 379 378 380 364 363 365 371 370 369 360""",
    "Town02": "464 463 462 472 471 473 465 466 467 470 469 468 458 457 456 477 478 459 460 461 476 475 474 479",
    "Town04": """1623 1622 1625 1617 1616 1614 1645 1646 1643 1632 1633 1631 1630 1635 1628 1634 1636 1610 1627 1609
        1626 1608 1607 1644 1638 1637 1639 1642 1640 1641 1612 1629 1613 1611 1620 1619 1618 1615 1621 1624 1649 1648
        1647""",
    "Town10HD": "960 959 943 944 958 957 950 952 951 961 945 962 953 954 949",
}


def spawn_order(town: str, lights: Collection[str]) -> dict[str, int]:
    """Return each signal id's place in the order in which CARLA spawns the town's lights.

    Empty if the town is not one of CARLA's, or if `lights` (those that the file's controllers name) lacks one of them:
    then the file is another map of the same name.
    """
    spawned = _SPAWNED.get(town.removesuffix("_Opt"), "").split()
    return {item: place for place, item in enumerate(spawned)} if set(spawned) <= set(lights) else {}
