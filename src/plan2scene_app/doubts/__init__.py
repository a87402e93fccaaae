"""The page of doubts: what a run understood of plan and photos, and how sure it is."""
