"""The texture model: encoder, noise decoder, embeddings, statistics."""
