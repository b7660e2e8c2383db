"""From a world to pictures: the parts of actors, light and weather, the rasterizer, and the view of a camera."""
