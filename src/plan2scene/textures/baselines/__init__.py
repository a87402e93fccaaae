"""Textures that are copied: reference crops and retrieved tiles."""
