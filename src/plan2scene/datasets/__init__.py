"""Data sets: the house table, photo assignments, hidden photos, and what is wrong with them."""

from plan2scene.datasets.assignments import (
    PhotoAssignment,
    check_assignment,
    read_assignment,
    rooms_of_photos,
)
from plan2scene.datasets.check import Problem, check_dataset, check_plan, photo_problem
from plan2scene.datasets.import_plan import import_plan
from plan2scene.datasets.table import make_house_table, read_house_table, read_unobserved

__all__ = [
    "PhotoAssignment",
    "Problem",
    "check_assignment",
    "check_dataset",
    "check_plan",
    "import_plan",
    "make_house_table",
    "photo_problem",
    "read_assignment",
    "read_house_table",
    "read_unobserved",
    "rooms_of_photos",
]
