"""Data sets: the house table, photo assignments, and their checks.

The workflow reads the house table at every start. Import each module by its own name, so that this
does not also import the readers of plans.
"""
