"""Limits of the ego's own actions: speeds, tracking of a path, turns, stops and the hand-back."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class TurningPolicy(FrozenModel):
    """Turn in several legs. Read by `turn_around`."""

    edge_m: NonNegativeFloat = 0.15
    """Distance of every corner of the body from the edges of the road (m): `LanePolicy.drivable_tolerance_m`, but
    inward, since the corners swing out in a turn.
    """
    error_m: PositiveFloat = 0.35
    """Distance from the proven leg above which the turn stops (m). The gaps cover this error and `error_rad`."""
    error_rad: PositiveFloat = 0.2
    """Heading error above which the turn stops (rad)."""
    shifts_s: NonNegativeFloat = 1.5
    """Time between two legs, to change gear and to check the next leg (s). Ours."""
    slowest_mps: PositiveFloat = 0.6
    """Lowest average speed of a leg, including stops and starts (m/s). Measured on carlette: 0.65 to 0.8 m/s if
    1.4 m/s was requested.
    """


class SpeedPolicy(FrozenModel):
    """Caps on the speed of a plan. Read by `speed_caps`, `collision_mitigation`, `guard` and checks along a path."""

    recovery_mps: PositiveFloat = 20 / 3.6
    """Cap for a plan without a passenger's request (m/s). The design's."""
    passing_mps: PositiveFloat = 40 / 3.6
    """Cap for a pass through the oncoming lane within the limits of its lanes (m/s): the same as `guided_mps`."""
    people_aside_m: NonNegativeFloat = 3.0
    """Distance to people and two-wheelers below which the cap is `recovery_mps` (m): two seconds of walking."""
    doors_aside_m: NonNegativeFloat = 1.1
    """Distance to stationary vehicles with doors below which the cap is `recovery_mps` (m): `DoorPolicy.reach_m`, plus
    0.2 m to the open door.
    """
    guided_mps: PositiveFloat = 40 / 3.6
    """Cap for overtaking at a passenger's request, within the limits of the lanes (m/s). The design's."""
    creep_mps: PositiveFloat = 8 / 3.6
    """Highest speed that counts as walking pace (m/s). The design's."""
    tolerance_mps: NonNegativeFloat = 1.0
    """Excess over the cap at which a plan is aborted (m/s): more than a speed controller overshoots."""


class TrackingPolicy(FrozenModel):
    """Tracking of a path from the ego's real position and heading.

    Read by `path_tracking`, `early_return`, `path_checks`, `speed_caps` and `guard`.
    """

    error_m: NonNegativeFloat = 0.9
    """Distance from the path above which a plan is aborted (m): half a car's width."""
    askew_rad: NonNegativeFloat = 0.1
    """Heading error below which the vehicle counts as aligned, without steering onto its path first (rad). Ours."""
    parallel_rad: NonNegativeFloat = 0.01
    """Angle to the road below which a path counts as parallel to the passed objects (rad): 1 cm on each meter."""
    beside_m: NonNegativeFloat = 0.05
    """Lateral error below which the vehicle counts as on its path (m): the accuracy of localization."""
    drift_mps: NonNegativeFloat = 0.25
    """Highest sideways speed in a tracking fault (m/s). Ours: 3 degrees off the path at 20 km/h. A plan begins only if
    its gaps allow for such a fault until the vehicle has stopped. At walking pace `ClearancePolicy` suffices.
    """
    kept_s: NonNegativeFloat = 1.0
    """Time, added to the braking time, for which a tracking error is assumed to persist (s), as its cause may. Ours."""
    worked_off_m: PositiveFloat = 6.0
    """Distance over which the error is then corrected (m): about two wheelbases."""
    settles_m: PositiveFloat = 20.0
    """Longest distance for which an askew start is simulated (m). Ours."""
    lock_m: PositiveFloat = 1.5
    """Distance over which the wheels turn from straight ahead to full lock (m): a second at a creep."""
    straightens_m: PositiveFloat = 3.0
    """Distance over which a heading error decays while backing up (m): about a wheelbase."""
    reach_m: PositiveFloat = 2.0
    """Distance over which the body's center returns to the path (m). Ours."""
    approach_rad: NonNegativeFloat = 0.45
    """Steepest angle at which the body approaches the path (rad). Ours."""


class StoppingPolicy(FrozenModel):
    """Stops that abort a plan or let other traffic pass.

    Read by `abort_stops`, `collision_mitigation`, `yielding` and others; `rests_mps` also by `path_checks`.
    """

    every_m: PositiveFloat = 3.0
    """Distance between the stops that are checked (m): less than a car's length, so that no car fits between two."""
    lag_s: NonNegativeFloat = 0.3
    """Time from the command to brake until the brakes act (s). Ours: a hydraulic brake, and one or two ticks."""
    gives_way_s: NonNegativeFloat = 2.5
    """Time, added to the braking time, within which a predicted contact makes the ego yield (s). Ours: deliberately
    late, since many vehicles turn off before.
    """
    goes_on_s: NonNegativeFloat = 6.0
    """Time without a predicted contact after which a yielding ego resumes (s): the gap in which drivers cross a road.
    """
    yields_ahead_m: NonNegativeFloat = 2.0
    """Least distance to the next conflict path for a yielding ego to resume (m). It is less than half a car's length,
    so that the ego does not set off and stop again before that path.
    """
    place_every_m: PositiveFloat = 0.5
    """Distance between the possible stops that are compared with the paths of others (m): a station of the path."""
    places_ahead_m: PositiveFloat = 25.0
    """Distance over which such stops are compared (m): the width of a large junction, a bound on the work."""
    nose_in_junction_m: NonNegativeFloat = 3.5
    """Greatest reach of the front into a junction for the ego to yield as early as possible (m): a lane's width."""
    stands_s: NonNegativeFloat = 3.0
    """Time after the stop that this check covers (s); later checks cover the rest. Ours."""
    past_end_m: NonNegativeFloat = 0.5
    """Distance beyond the stop that this check covers (m): one station of the path."""
    rests_mps: NonNegativeFloat = 0.3
    """Speed below which the ego counts as stopped (m/s): it can decide to set off, and has stopped at a line. Ours."""
    return_least_mps: PositiveFloat = 3.0
    """Least speed for which a return into the lane is planned (m/s). Ours."""
    return_s: NonNegativeFloat = 2.0
    """Duration of that return (s): a brisk lane change."""
    return_least_m: PositiveFloat = 4.0
    """Least length of that return (m): a car's length."""


class HarmPolicy(FrozenModel):
    """Choice of the least harm after the commit point. Read by `collision_mitigation`; `touch_m` also by others."""

    touch_m: NonNegativeFloat = 0.1
    """Gap below which objects count as in contact (m): the accuracy of perception."""
    gentler_mps: NonNegativeFloat = 1.0
    """Least decrease of the impact speed for which a stop is preferred (m/s). A smaller gain is uncertain, and driving
    on clears the road sooner. Ours.
    """


class HandBackPolicy(FrozenModel):
    """Conditions for a hand-back where a plan or a stop has ended. Read by `hand_back`."""

    askew_rad: NonNegativeFloat = 0.2
    """Heading error below which the ego may count as in its lane (rad): the stack then detects what is ahead. Ours."""
    aside_m: NonNegativeFloat = 0.4
    """Lateral offset below which the ego may count as in its lane (m); both conditions must hold. Ours."""
    kept_m: NonNegativeFloat = 0.1
    """Gap to stationary objects on the tightest path back (m): `HarmPolicy.touch_m`, since stacks keep more."""
    most_turn_rad: PositiveFloat = 1.3
    """Cap on the heading error for the path back (rad): beyond it no arc runs along the road."""
    speed_mps: PositiveFloat = 2.0
    """Speed on the path back (m/s). Ours."""
    own_s: PositiveFloat = 1.0
    """Time for which the motion of the driver must be free of contact before a hand-back (s). Ours: a reaction time."""
    check_s: PositiveFloat = 0.2
    """Delay that a hard stop must tolerate after a hand-back (s): otherwise the guard brakes now. Ours: a few ticks of
    a slow stack, so that a late tick does not matter.
    """
    step_s: PositiveFloat = 0.05
    """Time between the instants that are compared (s): 0.2 m at 4 m/s. Ours."""
