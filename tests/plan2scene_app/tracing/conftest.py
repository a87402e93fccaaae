import numpy as np
import pytest

from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.settings import DOOR, PLAN_LABELS, ROOM, WALL, WINDOW

PPM = 30
#: Rooms of the flat: label and floor in metres (x0, y0, x1, y1); walls are .1 m.
BEDROOM, KITCHEN = 7, 8
FLOORS = {BEDROOM: (1.1, 1.1, 5.0, 4.0), KITCHEN: (5.1, 1.1, 8.0, 4.0)}


def flat_labels():
    """Return labels (150, 270) of two rooms side by side with two doors and a window."""
    labels = np.zeros((150, 270), np.uint8)

    def paint(label, x0, y0, x1, y1):
        labels[slice(round(y0 * PPM), round(y1 * PPM)), round(x0 * PPM) : round(x1 * PPM)] = label

    paint(WALL, 1.0, 1.0, 8.1, 4.1)
    for label, box in FLOORS.items():
        paint(label, *box)
    paint(DOOR, 5.0, 2.0, 5.1, 2.9)
    paint(DOOR, 2.0, 4.0, 2.9, 4.1)
    paint(WINDOW, 6.0, 1.0, 7.5, 1.1)
    return labels


def solid_page(labels):
    page = np.full((*labels.shape, 3), 255, np.uint8)
    page[labels == WALL] = 0
    return page


def line(text, x=0.0, y=0.0, size=(60.0, 12.0)):
    return TextLine(text, (x, y), size, 0.99)


def as_probabilities(labels, sure=0.9):
    count = len(PLAN_LABELS)
    found = np.full((count, *labels.shape), (1 - sure) / (count - 1), np.float32)
    np.put_along_axis(found, labels[None].astype(int), sure, axis=0)
    return found


def rooms_alone():
    """Return the flat's labels, all its rooms alike, and its page."""
    labels = np.where(flat_labels() >= ROOM, ROOM, flat_labels()).astype(np.uint8)
    return labels, solid_page(labels)


@pytest.fixture
def probabilities():
    return as_probabilities(flat_labels())
