"""From sensors to surroundings: detections, tracks, the ego's pose, lights, and what was seen to be free.

Two frames are used. The *vehicle frame* (ISO 8855): x ahead, y left, z up, meters, radians counter-clockwise, its
origin on the ground below the vehicle's reference point. The *local frame* of `stucksolver.scene`: right-handed, fixed
for the drive. CARLA's left-handed world is used only in `stucksolver_carla`.
"""
