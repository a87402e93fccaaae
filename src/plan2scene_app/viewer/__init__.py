"""The offline viewer: one HTML file with the house in it."""

from plan2scene_app.viewer.build import build_viewer
from plan2scene_app.viewer.facts import read_facts

__all__ = ["build_viewer", "read_facts"]
