"""Training of the classifier of rooms: what a photographed room is used for."""
