"""Meshes: a house's floors, ceilings, walls with openings, doors and windows, and their files."""
