"""COLOR, FREQ, TILE, SUBS and FID of textures, and the paper's table (paper section 5)."""
