"""Detects objects in LiDAR sweeps with a CenterPoint network on pillars."""
