"""What each pixel of a plan's picture shows: the labels of the plan network."""

from __future__ import annotations

#: In the order of the network's logits. What is a room says which kind, as furniture tells it.
PLAN_LABELS = (
    "outside",
    "wall",
    "door",
    "window",
    "passage",
    "room",
    "reception",
    "bedroom",
    "kitchen",
    "bathroom",
    "corridor",
    "closet",
    "outdoor",
    "staircase",
)
OUTSIDE, WALL, DOOR, WINDOW, PASSAGE, ROOM = range(6)
#: Kinds of opening, by label.
OPENINGS = {DOOR: "door", WINDOW: "window", PASSAGE: "passage"}
#: Label of each room type; labels above `ROOM` are read back as the first type that has them.
LABEL_OF_TYPE = {
    "Reception": 6,
    "Bedroom": 7,
    "Kitchen": 8,
    "Bathroom": 9,
    "Corridor": 10,
    "Entrance": 10,
    "Closet": 11,
    "Balcony": 12,
    "Terrace": 12,
    "Outdoor": 12,
    "Staircase": 13,
    "Unknown": ROOM,
}
#: Name of the network's weights in the folder of models.
MODEL = "plans"
