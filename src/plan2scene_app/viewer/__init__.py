"""The offline viewer: one HTML file that contains the house, and the index of all houses."""
