"""Records drives: the rig's sensor data on the hero, the ground truth, and a crowd of varied objects."""
