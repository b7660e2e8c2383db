"""The static environment: roads, markings, signs, houses and trees, read from the map or made up."""
