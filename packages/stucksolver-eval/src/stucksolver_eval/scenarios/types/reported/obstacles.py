"""Things and vehicles that stay in the lane: the ego should pass them, or ask where it must not."""

from __future__ import annotations

from stucksolver_eval.actors.actor_pool import HAZARD_LAMPS
from stucksolver_eval.scenarios.families.reported import Move, Situation, Thing, register

VAN, LORRY, CAR = "vehicle.mercedes.sprinter", "vehicle.carlamotors.carlacola", "vehicle.lincoln.mkz_2020"
BIN, GATE = "static.prop.trashcan04", "static.prop.crossinggate"

register(
    (
        Situation(
            5000,
            "BinInGutter",
            "A car has broken down in the only lane, and a bin stands in the gutter of the oncoming lane: pass.",
            "Apollo issue 13228 (2020-12-22), a small obstacle outside the lane ends the pass",
            "recover",
            60.0,
            (Thing(CAR, lamps=HAZARD_LAMPS), Thing(BIN, 6.0, 0.4, "far")),
            past_m=20.0,
        ),
        Situation(
            5010,
            "ChicaneOfVans",
            "Two vans are double-parked on opposite sides, 30 m apart: pass the first, return, pass the second.",
            "Apollo issue 12949 (2020-11-10), a second vehicle ends a pass in a deadlock",
            "recover",
            90.0,
            (Thing(VAN, lamps=HAZARD_LAMPS), Thing(VAN, 30.0, 0.0, "left", turn_deg=180.0, lamps=HAZARD_LAMPS)),
            past_m=45.0,
        ),
        Situation(
            5020,
            "StopAndGoLorry",
            "A collection lorry stops for 20 s, drives 12 m and stops again: pass it, or follow it calmly.",
            "San Francisco Fire Department, report of 2022-04-05 on a collection truck in the lane",
            "recover",
            120.0,
            (Thing(LORRY, lamps=HAZARD_LAMPS, moves=(Move(0.0), Move(20.0, 3.0)), every_s=24.0),),
            past_m=60.0,
        ),
        Situation(
            5030,
            "WetConcrete",
            "The vehicle sinks in and does not move whatever its driver does, and nothing is ahead: ask.",
            "SFGATE, 2023-08-15, robotaxi in wet concrete",
            "ask",
            30.0,
            near_m=8.0,
            is_held=True,
        ),
        Situation(
            5040,
            "GateWithoutTicket",
            "The booms of a car park are down across both lanes and stay down: ask, never drive around.",
            "NHTSA recall 25E-034 (2025-05), collisions with gates and chains",
            "ask",
            60.0,
            (Thing(GATE, 0.0, 0.3, "edge", turn_deg=180.0), Thing(GATE, 0.0, -4.6, "edge", turn_deg=180.0)),
        ),
    )
)
