"""Patterns of floors: planks and tiles, their size and direction, from located photos."""
