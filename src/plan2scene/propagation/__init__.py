"""Propagation of texture embeddings to the surfaces that no photo shows (paper section 5.4)."""
