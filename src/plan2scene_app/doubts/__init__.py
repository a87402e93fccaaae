"""The page of doubts: what a run found in plan and photos, and how certain it is."""
