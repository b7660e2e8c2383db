"""Cameras: streets, actors and weather drawn by a software rasteriser that needs no display and no graphics card."""
