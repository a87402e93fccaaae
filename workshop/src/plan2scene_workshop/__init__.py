"""The workshop: how synthetic homes, their photos and the shipped weights are made.

It imports the library (plan2scene), never the other way.
"""
