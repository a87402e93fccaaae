"""Surface textures: embedding, decoding, selection, seams, retrieval."""
