"""The solver as a process beside a stack that cannot import it: `python -m stucksolver.stacks.sidecar --fd N`.

Messages are JSON objects, length-prefixed (`stucksolver_bridge.wire`). The stack says `hello` once and `tick` each
tick; the solver answers each with one message, before which it may ask for things by name.

From the stack:

* `hello`: `version`, `settings` (`Settings`), and `carla`, the facts of a CARLA world, or `sensed`, those of a vehicle
  that sees by its own sensors, or nothing.
* `tick`: `status` in its JSON form; of a CARLA world, time, frame, the ego's motion and the speed limit instead.
  Of a vehicle that sees by its own sensors: time, frame, speed limit and its own lamps, but nobody's place.
  `say`: a passenger's words. `again`: what was said last is lost or expired; say all of it again.
* `given`: what was asked for: `surroundings` or `scene` in their JSON forms; of a CARLA world, raw facts, with the tick
  that they are of. Measurements: IMU, GNSS and speed as numbers, picture and sweep as places in shared memory.

From the solver:

* `ready`: the version.
* `need`: `surroundings` or `scene`; of a CARLA world `actors`, `vehicle_lights` or `light_state`; of a vehicle
  that sees by its own sensors `sensors` or `sensors_without_picture`.
* `directive` in its JSON form, when it is another than before; `orders` for the driver of a CARLA world; `events`.
  The driver of a vehicle that sees by its own sensors runs here: one of the orders is this tick's control.
* `error`: what is wrong; nothing more follows.
"""

from stucksolver.stacks.sidecar.session import Session
from stucksolver.stacks.sidecar.settings import Settings

__all__ = ["Session", "Settings"]
