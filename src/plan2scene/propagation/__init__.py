"""Propagation of texture embeddings to the surfaces that no photo shows (paper section 4.3)."""
