"""The offline viewer: one HTML file with the house in it, and the index of all houses."""
