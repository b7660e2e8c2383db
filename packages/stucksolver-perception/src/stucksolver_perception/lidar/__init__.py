"""Detects objects in LiDAR sweeps: sweeps are gathered, divided into pillars, and read by a CenterPoint network."""
