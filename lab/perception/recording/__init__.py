"""Records drives: the sensor data of the ego's rig, the ground truth, and a crowd of varied objects."""
