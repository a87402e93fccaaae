"""Photos: label masks, camera, rectification, surface crops."""
