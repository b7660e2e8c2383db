"""The solver as a process beside a stack that cannot import it: `python -m stucksolver_carla.sidecar --fd N`.

Messages are JSON objects, length-prefixed (`stucksolver_bridge.message_socket`). The stack says `hello` once and
`tick` each tick; the solver answers each with one message, before which it may ask for things by name. `tick`,
`given`, `need` and the answer carry the tick's `number`, which grows by 1. The stack drops an answer with any other
number, so that it renews no order. A bridge and a solver of different versions of this protocol end at `hello`, with
one line.

From the stack:

* `hello`: `version`, `settings` (`SessionSettings`), and either `carla`, the facts of a CARLA world, or `sensed`,
  those of a vehicle with its own perception, or neither.
* `tick`: `status` in its JSON form; for a CARLA world time, frame, the ego's motion and the speed limit instead. For a
  vehicle with its own perception: time, frame, speed limit and its own lamps, but no positions. `say`: a passenger's
  words. `again`: the last answer was lost or has expired; send it all again.
* `given`: what was requested: `surroundings` or `scene` in their JSON forms; for a CARLA world raw facts, with the tick
  to which they belong. Measurements: IMU, GNSS and speed as numbers, image and sweep as places in shared memory.

From the solver:

* `ready`: the version.
* `need`: `surroundings` or `scene`; for a CARLA world `actors`, `vehicle_lights` or `light_state`; for a vehicle with
  its own perception `sensors` or `sensors_without_picture`.
* `directive` in its JSON form, if it has changed; `orders` for the driver of a CARLA world; `events`. The driver of a
  vehicle with its own perception runs here: one of its orders is this tick's control.
* `error`: what is wrong; no message follows it.
"""

from stucksolver_carla.session_settings import SessionSettings
from stucksolver_carla.sidecar.session import SidecarSession

__all__ = ["SessionSettings", "SidecarSession"]
