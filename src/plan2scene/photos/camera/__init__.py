"""The camera of a photo: focal length and rotation from its lines, file and labels."""
