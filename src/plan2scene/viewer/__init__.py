"""The offline viewer: one HTML file with the house in it."""

from plan2scene.viewer.build import build_viewer

__all__ = ["build_viewer"]
