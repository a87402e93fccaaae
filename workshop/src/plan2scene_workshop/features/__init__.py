"""Training of the features network."""
