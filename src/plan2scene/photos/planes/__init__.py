"""Floor, wall and ceiling planes of a photo, and their rectified views."""
