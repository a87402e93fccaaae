"""The files that a data set has of a house: its plan, photo assignments, object boxes."""
