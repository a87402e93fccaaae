"""Exemplar textures: seamless tiles from the photos' own crops (method ``exemplar``)."""
