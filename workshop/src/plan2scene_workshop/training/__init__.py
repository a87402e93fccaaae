"""Code that the training of every model shares: the loop, its schedules, and the model card."""
