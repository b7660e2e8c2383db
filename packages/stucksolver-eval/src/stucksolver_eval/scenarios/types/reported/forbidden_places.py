"""Places where the ego may not stand, with room behind it: leave them."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.reported import register
from stucksolver_eval.scenarios.families.situation_rows import Actor, HeroPose, Situation

CAR, ENGINE = "vehicle.lincoln.mkz_2020", "vehicle.carlamotors.firetruck"
LORRY = "vehicle.carlamotors.carlacola"
BLUE_LAMPS = ("Special1", "Special2")

register(
    (
        Situation(
            5800,
            "StoppedOnRails",
            "The ego stopped on the rails of a level crossing behind a car, and behind it is room: leave.",
            "Business Insider, 2023-04, footage of a robotaxi on tracks before a train in San Francisco",
            "leave",
            20.0,
            (Actor(CAR, 9.0),),
            site="rails",
            near_m=6.0,
            hero_pose=HeroPose(1.0),
            zone_m=(-3.0, 3.0),
        ),
        Situation(
            5810,
            "StoppedAcrossLine",
            "The ego stopped with its nose 0.8 m beyond the stop line of a red light, and traffic crosses: back up.",
            "Apollo issue 12511 (2020-09-13), the vehicle stops on the crosswalk",
            "leave",
            20.0,
            site="lights",
            traffic="busy",
            near_m=8.0,
            hero_pose=HeroPose(-1.65),
            lights=((0.0, "red"),),
            zone_m=(0.1, 30.0),
        ),
        Situation(
            5820,
            "BeforeFireStation",
            "The ego stopped before a fire station behind a car, and an engine wants to come out: leave.",
            "Mission Local, 2023-08, robotaxis obstruct fire stations, reports of the San Francisco Fire Department",
            "leave",
            20.0,
            (Actor(CAR, 9.0), Actor(ENGINE, 0.0, 6.0, "edge", -90.0, lamps=BLUE_LAMPS)),
            near_m=8.0,
            hero_pose=HeroPose(0.0),
            zone_m=(-4.0, 4.0),
        ),
        Situation(
            5830,
            "BesideStoppedLorry",
            "The ego stopped beside a collection lorry, and a fire engine comes past that in the ego's lane: back up.",
            "San Francisco Fire Department, report of 2022-04-05, a robotaxi beside a truck blocks an engine",
            "leave",
            30.0,
            (
                Actor(LORRY, 0.0, 0.0, "left", 180.0),
                Actor(ENGINE, 12.0, 0.0, "lane", 180.0, lamps=BLUE_LAMPS),
            ),
            near_m=8.0,
            hero_pose=HeroPose(0.0),
            zone_m=(-5.0, 5.0),
        ),
    )
)
