"""Finds objects in LiDAR sweeps: sweeps are gathered, cut into pillars, and read by a CenterPoint network."""
