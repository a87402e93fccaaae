"""The classifier of rooms: what a photographed room is used for."""
