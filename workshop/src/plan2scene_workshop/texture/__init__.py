"""Training of the texture models."""
