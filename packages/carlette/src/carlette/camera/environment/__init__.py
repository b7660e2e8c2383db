"""The static environment: roads, markings, signs, houses and trees, from the map or generated."""
