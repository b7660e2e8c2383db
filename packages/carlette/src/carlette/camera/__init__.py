"""Cameras: streets, actors and weather drawn by a software rasterizer without a display or a graphics card."""
