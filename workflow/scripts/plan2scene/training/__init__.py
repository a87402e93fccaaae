"""Training of the embedded weights: data in, safetensors and a model card out."""
