"""Pictures of a house, to look at."""
