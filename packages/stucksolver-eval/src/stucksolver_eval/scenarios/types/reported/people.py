"""People and animals on the road or beside it, and what they bring there."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.reported import register
from stucksolver_eval.scenarios.families.situation_rows import Actor, Move, Situation, actors_across

ADULTS = tuple(f"walker.pedestrian.{number:04d}" for number in range(1, 9))
CHILD, WORKER = "walker.pedestrian.0009", "walker.flagger.0001"
DOG, HORSE, GOOSE = "animal.dog", "animal.horse", "animal.goose"
BUS, ROBOT, COUCH = "vehicle.carlette.schoolbus", "static.prop.trashcan01", "static.prop.bench01"
BARRIER = "static.prop.streetbarrier"
LEFT, RIGHT = -90.0, 90.0


def _parade() -> tuple[Actor, ...]:
    """Return twelve people who walk ahead over both lanes for 60 s, and then leave to both sides."""
    actors = []
    for k in range(12):
        share = 0.1 + 0.8 * (k % 4) / 3.0
        leave = Move(60.0, 1.3, 6.0, LEFT if share < 0.5 else RIGHT)
        actors.append(Actor(ADULTS[k % 8], 1.8 * (k // 4), share, "road", moves=(Move(0.0, 0.7), leave)))
    return tuple(actors)


register(
    (
        Situation(
            5300,
            "PedestrianNotCrossing",
            "A person stands 0.3 m inside the lane's edge, faces the road and does not want to cross: pass with room.",
            "Autoware pull request 9988 (2025-01-20), pedestrians who do not start to cross",
            "recover",
            45.0,
            (Actor(ADULTS[0], 0.0, -0.3, "edge", LEFT),),
        ),
        Situation(
            5310,
            "PedestrianCrossesLate",
            "Control: the same person hesitates for 15 s and then crosses slowly: wait.",
            "Control of PedestrianNotCrossing",
            "wait",
            40.0,
            (Actor(ADULTS[0], 0.0, -0.3, "edge", LEFT, moves=(Move(15.0, 0.8, 9.5, LEFT),)),),
            free_s=19.0,
        ),
        Situation(
            5320,
            "PersonBehindFence",
            "A person stands behind barriers beside the lane and never moves: drive on.",
            "InterFuser issue 76 (2023-10-19), a person behind a fence stops the agent",
            "recover",
            30.0,
            (
                Actor(ADULTS[2], 0.0, 0.75, "edge", LEFT),
                *(Actor(BARRIER, ahead_m, 0.25, "edge", 90.0) for ahead_m in (-1.3, 0.0, 1.3)),
            ),
        ),
        Situation(
            5330,
            "TwoMenBeforeCar",
            "Two men step before the stopped ego for a minute and leave: wait.",
            "404 Media, 2024-10, two men stand before a robotaxi and its passenger",
            "wait",
            60.0,
            tuple(
                Actor(ADULTS[k], 0.5 * k, -0.8 - 0.9 * k, "edge", moves=(Move(60.0, 1.2, 4.0, RIGHT),)) for k in (1, 2)
            ),
            free_s=61.0,
        ),
        Situation(
            5340,
            "SitIn",
            "Five people stand across both lanes and stay: ask.",
            "Common report: protests on the road, news of several cities",
            "ask",
            60.0,
            actors_across(ADULTS[3], (0.08, 0.29, 0.5, 0.71, 0.92), turn_deg=180.0),
        ),
        Situation(
            5350,
            "Parade",
            "Twelve people walk along both lanes for a minute, and then leave the road: wait.",
            "Business Insider on a robotaxi before a parade in Phoenix, Arizona",
            "wait",
            60.0,
            _parade(),
            free_s=62.0,
            past_m=55.0,
        ),
        Situation(
            5360,
            "DogOnLeash",
            "A dog on a leash stands in the lane and its owner beside it; they walk off after 25 s: wait.",
            "SFist, 2025-12-08, robotaxi runs over a dog in San Francisco",
            "wait",
            45.0,
            (
                Actor(ADULTS[5], 0.0, 0.5, "edge", LEFT, moves=(Move(25.0, 1.2, 4.0, RIGHT),)),
                Actor(DOG, 0.0, -1.1, "edge", LEFT, moves=(Move(25.0, 1.2, 4.0, RIGHT),)),
            ),
            free_s=26.0,
        ),
        Situation(
            5370,
            "HorseOnRoad",
            "A horse is led along the lane for 30 s and then off it: follow, and pass only when it has left.",
            "FOX 10 Phoenix, horses and robotaxis in Tempe, Arizona",
            "wait",
            60.0,
            (
                Actor(HORSE, moves=(Move(0.0, 0.8), Move(30.0, 1.0, 4.0, RIGHT))),
                Actor(ADULTS[6], 0.6, 0.9, moves=(Move(0.0, 0.8), Move(30.0, 1.0, 4.0, RIGHT))),
            ),
            free_s=32.0,
            past_m=45.0,
        ),
        Situation(
            5380,
            "GeeseCrossing",
            "Five geese cross the road one behind the other: wait.",
            "Common report: animals on the road, California DMV disengagement reports 2023",
            "wait",
            45.0,
            tuple(Actor(GOOSE, 0.2 * k, 0.8 * k - 1.5, moves=(Move(8.0, 0.4, 20.0, LEFT),)) for k in range(5)),
            free_s=16.0,
        ),
        Situation(
            5390,
            "PersonAtBumper",
            "A person walks up to the stopped ego and stays directly before its bumper: ask, never move forward.",
            "California DMV, order of suspension of 2023-10-24, a robotaxi moves with a person under it",
            "ask",
            45.0,
            (Actor(ADULTS[7], 0.0, 0.0, "lane", 180.0, moves=(Move(6.0, 1.0, 2.5, 180.0),)),),
        ),
        Situation(
            5400,
            "JumpingInAndOut",
            "A person steps into the lane and back out five times, and then leaves: pass when the lane is free.",
            "breakinglatest.news, 2023-04-28, people jump before a robotaxi on Fillmore Street, San Francisco",
            "recover",
            60.0,
            (
                Actor(
                    ADULTS[4],
                    0.0,
                    0.3,
                    "edge",
                    LEFT,
                    moves=(
                        *(
                            Move(8.0 * k + 4.0 * back, 1.2, 1.5, RIGHT if back else LEFT)
                            for k in range(5)
                            for back in (0, 1)
                        ),
                        Move(40.0, 1.3, 4.0, RIGHT),
                    ),
                ),
            ),
        ),
        Situation(
            5410,
            "FurnitureCarriers",
            "Two people carry a bench slowly across the road: wait.",
            "Common report: people in the lane, California DMV disengagement reports 2023",
            "wait",
            45.0,
            (
                Actor(COUCH, 0.0, -0.6, "edge", 0.0, lift_m=0.5, moves=(Move(8.0, 0.35, 24.0, LEFT),)),
                *(
                    Actor(ADULTS[k], ahead_m, -0.6, "edge", LEFT, moves=(Move(8.0, 0.35, 24.0, LEFT),))
                    for k, ahead_m in ((0, -1.8), (1, 1.8))
                ),
            ),
            free_s=17.0,
        ),
        Situation(
            5420,
            "DeliveryRobot",
            "A delivery robot stops in the middle of the lane for half a minute and goes on: wait, or pass with room.",
            "TechCrunch, 2024-12, robotaxi and delivery robot collide in Los Angeles",
            "recover",
            90.0,
            (Actor(ROBOT, 0.0, -0.5, "edge", LEFT, moves=(Move(0.0, 0.8, 1.5, LEFT), Move(35.0, 0.8, 6.0, LEFT))),),
        ),
        Situation(
            5430,
            "WorkerWavesOn",
            "A worker beside the lane shows go, and barriers leave the left half of the lane free: drive on.",
            "Drive (Australia), workers herd a robotaxi through a construction site in Los Angeles",
            "recover",
            60.0,
            (
                Actor(WORKER, -3.0, 0.6, "edge", 180.0, gesture="go"),
                *(Actor(BARRIER, 1.5 * k, -0.6, "edge", 90.0) for k in range(3)),
            ),
        ),
        Situation(
            5440,
            "WorkerHoldsTraffic",
            "A crew holds the traffic for 40 s for its work on the road, then shows go: wait.",
            "Common report: crews that hold the traffic; no single report is meant",
            "wait",
            60.0,
            (
                Actor(WORKER, 0.0, 0.5, "lane", 180.0, gesture="stop", moves=(Move(40.0, is_gone=True),)),
                Actor(WORKER, 0.0, 0.7, "edge", 180.0, gesture="go", from_s=40.5),
                *(
                    Actor(BARRIER, 4.0, right_m, "lane", 90.0, moves=(Move(40.0, is_gone=True),))
                    for right_m in (-0.8, 0.8)
                ),
            ),
            free_s=41.0,
        ),
        Situation(
            5450,
            "SchoolBusStopArm",
            "A school bus stands with its stop arm out, and children cross; it drives on after 30 s: wait.",
            "NHTSA recall of 2025-12 (3,067 vehicles), robotaxis pass school buses",
            "wait",
            60.0,
            (
                Actor(BUS, lamps=("Special1",), moves=(Move(32.0, 7.0, lamps=()),)),
                *(
                    Actor(CHILD, 7.0 + k, 0.8, "edge", LEFT, moves=(Move(12.0 + 2.0 * k, 1.0, 9.0, LEFT),))
                    for k in range(2)
                ),
            ),
            free_s=32.0,
        ),
    )
)
