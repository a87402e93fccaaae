"""The page of doubts: what a run read of a plan and photos, and what of it is not sure."""
