"""Surface maps: one image for a whole surface, quilted from crops without repeating."""
