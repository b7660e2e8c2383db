"""Runs the solver as a process for a stack that cannot import it: `python -m stucksolver_carla.sidecar --fd N`.

Messages are JSON objects with a length prefix (`stucksolver_bridge.message_socket`). The stack sends `hello` once and
`tick` on each tick. The solver sends one answer to each, and may request data by name before it. `tick`, `given`,
`need` and the answer carry the tick's `number`, which grows by 1. The stack drops an answer with any other number, so
that it renews no directive. A bridge and a solver of different versions of this protocol end at `hello`, with one line.

From the stack:

* `hello`: `version`, `settings` (`SessionSettings`), and either `carla`, the data of a CARLA world, or `sensed`, the
  data of a vehicle with sensor-based perception, or neither.
* `tick`: `status` in its JSON form; for a CARLA world time, frame, the ego's motion and the speed limit instead. With
  sensor-based perception: time, frame, speed limit and the ego's lamps, but no positions. `say`: a passenger's
  utterance. `again`: the last answer was rejected or has expired; send all of it again.
* `given`: the requested data: `surroundings` or `scene` in their JSON forms; for a CARLA world raw data, with their
  tick. Measurements: IMU, GNSS and speed as numbers, image and sweep as positions in shared memory.

From the solver:

* `ready`: the version.
* `need`: `surroundings` or `scene`; for a CARLA world `actors`, `vehicle_lights` or `light_state`; with sensor-based
  perception `sensors` or `sensors_without_picture`.
* `directive` in its JSON form, if it has changed; `orders` for the driver of a CARLA world; `events`. With sensor-based
  perception the driver runs in this process, and one of the orders is this tick's control.
* `error`: the reason; no message follows it.
"""

from stucksolver_carla.session_settings import SessionSettings
from stucksolver_carla.sidecar.session import SidecarSession

__all__ = ["SessionSettings", "SidecarSession"]
