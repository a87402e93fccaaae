"""Where in the plan a photo was taken: the pose whose rendered room agrees with its labels."""
