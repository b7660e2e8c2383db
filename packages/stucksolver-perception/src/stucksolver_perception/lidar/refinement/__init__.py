"""Corrects the boxes of the LiDAR network with rules on the returns near the vehicle."""
