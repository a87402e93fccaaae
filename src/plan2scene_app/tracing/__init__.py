"""A picture of a plan in, a plan in metres out."""
