"""Plans: readers of scene.json, R2V and our own JSON, the registry of all formats, checks."""
