"""Textures: the model, its statistics and selection, seams, retrieval and the methods."""
