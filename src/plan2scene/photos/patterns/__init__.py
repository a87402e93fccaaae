"""Find patterns in photos: planks and tiles of floors, with size and direction."""
