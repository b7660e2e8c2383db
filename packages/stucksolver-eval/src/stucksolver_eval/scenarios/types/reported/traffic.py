"""Other vehicles that move, or that stand where they block more than a lane."""

from __future__ import annotations

from stucksolver_eval.actors.actor_pool import HAZARD_LAMPS
from stucksolver_eval.scenarios.families.reported import register
from stucksolver_eval.scenarios.families.situation_rows import Actor, HeroPose, Move, Situation

CAR, VAN, LORRY = "vehicle.lincoln.mkz_2020", "vehicle.mercedes.sprinter", "vehicle.carlamotors.carlacola"
BUS, POLICE = "vehicle.mitsubishi.fusorosa", "vehicle.dodge.charger_police_2020"
BARRIER = "static.prop.streetbarrier"
BLUE_LAMPS = ("Special1", "Special2")
MUNI = "WIRED, 2023-04, records of robotaxis that held up buses and trains in San Francisco"

register(
    (
        Situation(
            5500,
            "BusPullsOut",
            "A bus at its stop reaches into the lane, signals and pulls out after 12 s: let it go, and follow.",
            MUNI,
            "wait",
            60.0,
            (
                Actor(
                    BUS, 0.0, 0.9, "edge", lamps=("LeftBlinker",), moves=(Move(12.0, 6.0),), merge_m=15.0, yields=False
                ),
            ),
            free_s=14.0,
            past_m=35.0,
        ),
        Situation(
            5510,
            "TrafficWaitsBehind",
            "A car is parked half in the lane that a tram shares, and traffic waits behind the ego: pass.",
            MUNI,
            "recover",
            60.0,
            (Actor(CAR, 0.0, -0.2, "edge"),),
            traffic="behind",
        ),
        Situation(
            5520,
            "OneLaneBridge",
            "Barriers leave only the oncoming lane of a bridge, and three cars come through it first: wait, then pass.",
            "Common report: one-lane bridges and road works, California DMV disengagement reports 2023",
            "wait",
            60.0,
            (
                *(Actor(BARRIER, 1.5 * k, 0.0, "lane", 90.0) for k in range(6)),
                *(Actor(CAR, 45.0 + 12.0 * k, 0.0, "left", 180.0, moves=(Move(0.0, 5.0),)) for k in range(3)),
            ),
            free_s=16.0,
            past_m=22.0,
        ),
        Situation(
            5530,
            "WrongWayDriver",
            "A car comes the wrong way in the ego's lane, stops before it and stays: back up or pass.",
            "The Verge, 2024-07-06, robotaxi in the oncoming lane in Phoenix",
            "recover",
            90.0,
            (Actor(CAR, 30.0, 0.0, "lane", 180.0, moves=(Move(0.0, 3.0),)),),
        ),
        Situation(
            5540,
            "NoseToNose",
            "Each of two vehicles waits behind a van on its own side: one has to go first.",
            "SFist, 2025-12-08, three robotaxis block a street and wait for each other",
            "recover",
            90.0,
            (
                Actor(VAN, lamps=HAZARD_LAMPS),
                Actor(VAN, 17.0, 0.0, "left", 180.0, lamps=HAZARD_LAMPS),
                Actor(CAR, 26.0, 0.0, "left", 180.0),
            ),
            past_m=40.0,
        ),
        Situation(
            5550,
            "ReversingTruck",
            "A truck stands across the lane while it backs into an alley, and is gone after 40 s: wait.",
            "NTSB, accident of 2017-11 in Las Vegas, a truck backs against an autonomous shuttle",
            "wait",
            45.0,
            (Actor(LORRY, 0.0, -1.0, "lane", 90.0, lamps=HAZARD_LAMPS, moves=(Move(40.0, is_gone=True),)),),
            free_s=40.0,
        ),
        Situation(
            5560,
            "Motorcade",
            "A police car blocks the lane while dark cars pass in the other one, and leaves after 40 s: wait.",
            "San Francisco Standard, 2024-09, robotaxi stands in a motorcade's path",
            "wait",
            60.0,
            (
                Actor(POLICE, lamps=BLUE_LAMPS, moves=(Move(40.0, 8.0, lamps=()),)),
                *(Actor(CAR, 40.0 + 14.0 * k, 0.0, "left", 180.0, moves=(Move(2.0, 7.0),)) for k in range(4)),
            ),
            free_s=42.0,
        ),
        Situation(
            5570,
            "FuneralProcession",
            "The last cars of a procession stop with hazard lights for 40 s and drive on slowly: wait behind them.",
            "Common report: processions, guidance of several states for automated vehicles",
            "wait",
            90.0,
            tuple(Actor(CAR, 8.0 * k, lamps=HAZARD_LAMPS, moves=(Move(40.0, 6.0),)) for k in range(4)),
            free_s=40.0,
            past_m=45.0,
        ),
        Situation(
            5580,
            "BlockedDriveway",
            "A van stands across the exit that the ego wants to leave by, with room on its left: pass.",
            "San Francisco Standard, 2024-05-14, robotaxis get stuck at driveways on Telegraph Hill",
            "recover",
            60.0,
            (Actor(VAN, 0.0, 0.6, "edge", 90.0),),
        ),
        Situation(
            5590,
            "LaneChangeInterrupted",
            "The ego stands askew on the line after a lane change that a car ended: go on in its own lane.",
            "Apollo issue 14362 (2022-03-20), an interrupted lane change ends on the line",
            "recover",
            45.0,
            (Actor(CAR, 1.0, 0.0, "left", lamps=HAZARD_LAMPS),),
            site="two lanes",
            near_m=16.0,
            hero_pose=HeroPose(-8.5, -1.75, -9.0),
        ),
        Situation(
            5600,
            "StoppedAskew",
            "The ego stopped at an angle of 45 degrees to its lane, half over the center line, on a free road: rejoin.",
            "SlashGear, 2021-05, robotaxi stops between two lanes in Chandler, Arizona",
            "recover",
            45.0,
            near_m=6.0,
            hero_pose=HeroPose(0.0, -1.2, -45.0),
        ),
    )
)
