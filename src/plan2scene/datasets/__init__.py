"""Data sets: the house table, photo assignments, hidden photos, and what is wrong with them."""

from plan2scene.datasets.assignments import PhotoAssignment as PhotoAssignment
from plan2scene.datasets.assignments import check_assignment as check_assignment
from plan2scene.datasets.assignments import read_assignment as read_assignment
from plan2scene.datasets.assignments import rooms_of_photos as rooms_of_photos
from plan2scene.datasets.check import Problem as Problem
from plan2scene.datasets.check import check_dataset as check_dataset
from plan2scene.datasets.check import check_plan as check_plan
from plan2scene.datasets.check import photo_problem as photo_problem
from plan2scene.datasets.import_plan import import_plan as import_plan
from plan2scene.datasets.table import make_house_table as make_house_table
from plan2scene.datasets.table import read_house_table as read_house_table
from plan2scene.datasets.table import read_unobserved as read_unobserved
