"""What tracing writes: the plan in metres, the doubts, the picture with the vectors over it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.images import write_png
from plan2scene.io import write_json, write_text
from plan2scene.plans import validate_house
from plan2scene.plans.plan_json import FORMAT, house_of_plan
from plan2scene_app.plan_formats.areas import HEIGHTS
from plan2scene_app.tracing.picture import BUSY
from plan2scene_app.tracing.scale import SURE
from plan2scene_app.tracing.trace import TracedPlan, trace_picture

#: Openings and rooms that are less sure than this are named among the doubts.
DOUBTFUL = 0.6
#: Metres that doors and windows of homes have.
_USUAL = {"door": (0.5, 2.6), "window": (0.3, 6.0), "passage": (0.5, 6.0)}
_COLOURS = {"door": (0, 150, 60), "window": (20, 90, 235), "passage": (240, 140, 0)}
_FILLS = ((230, 90, 80), (90, 160, 230), (110, 190, 110), (230, 180, 70), (170, 120, 210))


def plan_origin(plan: TracedPlan) -> np.ndarray:
    """Return the upper left corner of the rooms (x, y) in pixels of the frame."""
    corners = np.concatenate([np.array(r.polygon.exterior.coords) for r in plan.rooms])
    return np.asarray(corners.min(0))


def plan_document(plan: TracedPlan) -> dict[str, Any]:
    """Return the plan as this program's plan JSON, in metres from its upper left corner."""
    origin = plan_origin(plan)

    def metric(point: Any) -> list[float]:
        return [round(float(v), 3) for v in (np.asarray(point) - origin) * plan.metres]

    rooms = []
    for room in plan.rooms:
        entry: dict[str, Any] = {"id": room.id, "types": list(room.types)}
        entry["polygon"] = [metric(p) for p in room.polygon.exterior.coords[:-1]]
        holes = [[metric(p) for p in ring.coords[:-1]] for ring in room.polygon.interiors]
        rooms.append(entry | ({"holes": holes} if holes else {}))
    openings = []
    for number, opening in enumerate(plan.openings):
        bottom, top = HEIGHTS[opening.kind]
        openings.append(
            {
                "id": f"{opening.kind}_{number}",
                "kind": opening.kind,
                "from": metric(opening.start),
                "to": metric(opening.end),
                "bottom": bottom,
                "top": top,
            }
        )
    depth = round(float(np.clip(plan.wall_px * plan.metres, 0.05, 0.5)), 3)
    return {
        "format": FORMAT,
        "version": 1,
        "wall_depth": depth,
        "rooms": rooms,
        "openings": openings,
    }


def doubts(plan: TracedPlan) -> Iterator[str]:
    """Yield a line for everything that is a guess or unlikely."""
    scale = plan.scale
    if scale.confidence < SURE:
        centimetres = 100 * plan.file_metres
        yield (
            f"the scale is {scale.source} ({centimetres:.3g} cm a pixel, {scale.confidence:.0%} "
            "sure): give --metres-per-pixel"
        )
    if plan.sure < BUSY[0]:
        yield f"the picture as a whole: {plan.sure:.0%} sure of what it shows"
    if not plan.read:
        yield "no text is read: pip install 'plan2scene[trace]'"
    if scale.differ:
        yield f"measures that do not fit the scale: {', '.join(scale.differ)}"
    yield from _doubts_of_rooms(plan)
    yield from _doubts_of_openings(plan)


def _doubts_of_rooms(plan: TracedPlan) -> Iterator[str]:
    """Yield a line for each kind of doubt, with the rooms that have it."""
    ways = {n for o in plan.openings if o.kind != "window" for n in (o.room, o.other)}
    found = {
        "nothing tells what they are": lambda r: r.types == ("Unknown",),
        "their furniture alone tells what they are": lambda r: (
            r.types != ("Unknown",) and not r.named
        ),
        "hardly sure that they are rooms": lambda r: r.confidence < DOUBTFUL,
        "no door or passage found": lambda r: r.number not in ways,
    }
    for what, has in found.items():
        names = [room.id for room in plan.rooms if has(room)]
        if names:
            yield f"rooms {', '.join(names)}: {what}"


def _doubts_of_openings(plan: TracedPlan) -> Iterator[str]:
    """Yield a line for each opening of an odd width, and one for those that are hardly sure."""
    unsure = []
    for number, opening in enumerate(plan.openings):
        width = opening.width * plan.metres
        low, high = _USUAL[opening.kind]
        place = next(room.id for room in plan.rooms if room.number == opening.room)
        if not low <= width <= high:
            yield f"a {opening.kind} of {width:.2f} m in {place}"
        if opening.confidence < DOUBTFUL:
            unsure.append(f"{opening.kind}_{number} ({place})")
    if unsure:
        yield f"hardly sure openings: {', '.join(unsure)}"


def overlay(plan: TracedPlan) -> np.ndarray:
    """Return the picture (h, w, 3) uint8, paled, with rooms, openings and names over it."""
    image = (255 - (255 - plan.picture.astype(np.float32)) * 0.6).astype(np.uint8)
    tint = image.copy()

    def pixels(points: Any) -> np.ndarray:
        there = plan.frame.to_picture(np.asarray(points, float))
        return np.round(there * 8).astype(np.int32)[:, None]

    thick = max(1, round(max(image.shape[:2]) / 600))
    for number, room in enumerate(plan.rooms):
        ring = pixels(room.polygon.exterior.coords[:-1])
        cv2.fillPoly(tint, [ring], _FILLS[number % len(_FILLS)], cv2.LINE_AA, 3)
    image = cv2.addWeighted(tint, 0.25, image, 0.75, 0)
    for room in plan.rooms:
        ring = pixels(room.polygon.exterior.coords[:-1])
        cv2.polylines(image, [ring], True, (200, 0, 0), thick, cv2.LINE_AA, 3)
    for opening in plan.openings:
        ends = pixels([opening.start, opening.end])
        colour = _COLOURS[opening.kind]
        cv2.polylines(image, [ends], False, colour, 3 * thick, cv2.LINE_AA, 3)
    for room in plan.rooms:
        spot = room.polygon.representative_point()
        x, y = plan.frame.to_picture(np.array([[spot.x, spot.y]]))[0]
        area = room.polygon.area * plan.metres**2
        size = 0.4 * thick**0.5
        at = (int(x) - 30 * thick, int(y))
        text = f"{room.id} {area:.1f} m2"
        for colour, weight in (((255, 255, 255), 3), ((120, 0, 120), 1)):
            font = cv2.FONT_HERSHEY_SIMPLEX
            cv2.putText(image, text, at, font, size, colour, weight, cv2.LINE_AA)
    return image


def traced_files(out: Path) -> tuple[Path, Path, Path]:
    """Return what is written for a plan `out`: itself, the overlay, the doubts."""
    return out, out.with_suffix(".overlay.png"), out.with_suffix(".doubts.txt")


def write_trace(
    path: str | Path,
    out: str | Path,
    *,
    metres_per_pixel: float | None = None,
    model: str | Path | None = None,
) -> tuple[TracedPlan, list[str]]:
    """Trace a picture; write what :func:`traced_files` names. Return plan and lines of doubt."""
    plan = trace_picture(path, metres_per_pixel=metres_per_pixel, model=model)
    document = plan_document(plan)
    house = house_of_plan(document, "traced", file=str(path))
    lines = list(dict.fromkeys([*doubts(plan), *validate_house(house, file=path)]))
    target, picture, notes = traced_files(Path(out))
    write_png(picture, overlay(plan))
    write_text(notes, "".join(f"{line}\n" for line in lines))
    write_json(target, document)
    return plan, lines
