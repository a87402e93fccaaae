"""Photos of synthetic houses by path tracing, with labels, planes and cameras as truth.

Mitsuba 3 (the extra `workshop`) is imported only when something is rendered.
"""

from __future__ import annotations

from plan2scene_workshop.rendering.camera_effects import encode_jpeg
from plan2scene_workshop.rendering.photos import RenderedPhoto, render_house
from plan2scene_workshop.rendering.views import View, plan_views

__all__ = ["RenderedPhoto", "View", "encode_jpeg", "plan_views", "render_house"]
