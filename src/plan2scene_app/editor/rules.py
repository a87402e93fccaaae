"""What the page must know of the reader of plan.json: its schema, names and limits."""

from __future__ import annotations

from typing import Any

from plan2scene.house import ROOM_TYPES
from plan2scene.plans import openings, parse, plan_json, plausible, storeys, validate
from plan2scene.plans.geometry import SHARED_TOLERANCE
from plan2scene_app.plan_formats.areas import HEIGHTS

#: Width in metres of an opening that a click makes.
WIDTHS = {"door": 0.9, "window": 1.2, "passage": 1.2}
#: Width in metres of a flight of stairs that is drawn.
FLIGHT = 0.9


def page_rules() -> dict[str, Any]:
    """Return the rules that ``rules.js`` follows, as plain JSON.

    Lengths are metres, areas square metres, angles radians. Every value is the reader's own, so
    that the page and ``plan2scene run`` agree.
    """
    return {
        "schema": plan_json.plan_schema(),
        "format": plan_json.FORMAT,
        "room_types": list(ROOM_TYPES),
        "types": dict(parse.TYPE_NAMES),
        "devices": sorted(plausible.DEVICES),
        "openings": {
            kind: {"width": WIDTHS[kind], "bottom": bottom, "top": top}
            for kind, (bottom, top) in HEIGHTS.items()
        },
        "flight_width": FLIGHT,
        "limits": _limits(),
    }


def _limits() -> dict[str, Any]:
    """Return the limits of the reader's checks."""
    return {
        "default_height": plan_json.DEFAULT_HEIGHT,
        "default_depth": plan_json.DEFAULT_DEPTH,
        "snap_tolerance": plan_json.SNAP_TOLERANCE,
        "shared_tolerance": SHARED_TOLERANCE,
        "max_angle": openings.MAX_ANGLE,
        "min_share": openings.MIN_SHARE,
        "max_coordinate": parse.MAX_COORDINATE,
        "max_corners": parse.MAX_CORNERS,
        "same_point": parse.SAME_POINT,
        "min_area": validate.MIN_AREA,
        "overlap_share": validate.OVERLAP_SHARE,
        "rounding": validate.ROUNDING,
        "max_extent": plausible.MAX_EXTENT,
        "max_usual_area": plausible.MAX_USUAL_AREA,
        "heights": plausible.HEIGHTS,
        "usual_heights": plausible.USUAL_HEIGHTS,
        "usual_extent": plausible.USUAL_EXTENT,
        "usual_area": plausible.USUAL_AREA,
        "usual_door": plausible.USUAL_DOOR,
        "narrow": plausible.NARROW,
        "apart": plausible.APART,
        "least_rise": storeys.LEAST_RISE,
        "least_flight": storeys.LEAST_FLIGHT,
        "step_off": storeys.STEP_OFF,
        "riser": storeys.RISER,
        "tread": storeys.TREAD,
        "flight_margin": storeys.MARGIN,
    }
