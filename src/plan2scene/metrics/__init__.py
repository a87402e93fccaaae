"""COLOR, FREQ, SUBS, FID, TILE and KID of textures (paper section 6.2)."""
