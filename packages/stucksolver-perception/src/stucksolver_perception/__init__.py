"""Perceives the surroundings with sensors: detections, tracks, the ego's pose, lights, and free space.

Two frames are used. The *vehicle frame* (ISO 8855) has x ahead, y left, z up (m) and counter-clockwise angles (rad).
Its origin is on the ground below the vehicle's reference point. The *local frame* of `stucksolver.scene` is
right-handed and fixed during a run. CARLA's left-handed world frame is used only in `stucksolver_carla` and in the
folder `carla`.
"""
