"""What never moves: roads, paint, signs at roads, houses and trees, read from the map or made up."""
