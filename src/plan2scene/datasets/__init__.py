"""Data sets: the house table, photo assignments, hidden photos, and what is wrong with them.

The workflow reads the table at every start: each module is imported by its own name, so that this
costs no reader of plans.
"""
