"""Find where in the plan a photo was taken: the pose at which the plan's room fits its labels."""
