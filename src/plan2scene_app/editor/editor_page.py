"""The editor's page: program, style, rules and the opened plan in one file without requests."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES
from plan2scene.images import decode_image, png_bytes, to_small_srgb
from plan2scene.io import atomic_path
from plan2scene.plans import openings, parse, plan_json, validate
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import SHARED_TOLERANCE
from plan2scene.plans.levels import STAIRS
from plan2scene.plans.plan_file import PlanFile
from plan2scene.plans.validate import validate_house
from plan2scene_app.html_page import html_page, inline_json, source_hash
from plan2scene_app.pdf import page_picture
from plan2scene_app.plan_formats.axes import HEIGHTS
from plan2scene_app.plan_writer import house_to_plan
from plan2scene_app.tracing.picture import read_plan_picture

FOLDER = Path(__file__).parent
#: Longer side, in pixels, to which pictures of plans are reduced.
PICTURE_SIDE = 2400
#: Advice shown when the scale is only a guess.
_BY_HAND = "press S and click two points whose distance you know"
#: Name of this command in the head of its pages; no file without it is overwritten.
_MAKER = "plan2scene edit"
_IMPORT = re.compile(r'^import (?:\{[^}]*\} from )?"\./(\w+)\.js";\n', re.MULTILINE)


def write_editor(
    source: Path | None,
    output: Path,
    *,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
    trace: bool = True,
) -> None:
    """Write the editor's page: with a plan of any format, a picture to draw over, or empty.

    Parameters
    ----------
    source : path or None
        A plan that :func:`plan2scene.plans.read_plan` reads, or a picture of one.
    output : path
        An HTML file; it opens from the disk in any browser.
    house_id : str
        Shown as the title.
    metres_per_pixel : float, optional
        Scale of a picture, or of a plan in pixels.
    dxf_layers : mapping of str to str, optional
        Layers of a DXF drawing (docs/floorplans.md).
    trace : bool
        Whether a picture is traced: the page then shows the traced plan over it, to be corrected.
    """
    if output.is_file() and f'content="{_MAKER}"'.encode() not in output.read_bytes()[:2000]:
        raise InputError("a new file, or a page of the editor", "a file of yours", file=output)
    start: dict[str, Any] = {"house": house_id}
    if source is not None:
        start |= opened(source, house_id, metres_per_pixel, dxf_layers, trace=trace)
    with atomic_path(output) as temporary:
        temporary.write_text(editor_page(start), encoding="utf-8")


def opened(
    source: Path,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
    *,
    trace: bool = True,
) -> dict[str, Any]:
    """Return what the page starts with: ``plan``, ``picture``, ``notes`` (warnings, doubts).

    For a picture there is also ``scale``: the ``size`` of the traced plan in pixels of the file
    (width, depth), ``doubt`` (not empty if the scale is a guess), and ``shown``, the number of
    pixels of the file for each pixel on the page.
    """
    if not source.is_file():
        raise InputError("a plan or a picture of one", "no such file", file=source)
    if not PlanFile(source, house_id).is_picture:
        house = read_plan(source, house_id, metres_per_pixel, dxf_layers)
        return {"plan": house_to_plan(house), "notes": validate_house(house, file=source.name)}
    if trace:
        try:
            return _traced(source, metres_per_pixel)
        except InputError as error:
            note = f"not traced: expected {error.expected}, found {error.found}"
            return _untraced(source, metres_per_pixel) | {"notes": [note]}
    return _untraced(source, metres_per_pixel)


def _traced(source: Path, metres_per_pixel: float | None) -> dict[str, Any]:
    """Return the plan traced from a picture, and the picture, straightened, to lie under it."""
    import cv2

    read_plan_picture(source)  # refuses an empty page before torch is imported
    from plan2scene_app.tracing.settings import SETTINGS
    from plan2scene_app.tracing.trace import doubts, plan_document, plan_origin, trace_picture

    traced = trace_picture(source, metres_per_pixel=metres_per_pixel)
    # Keep the picture's resolution, up to `PICTURE_SIDE`.
    zoom = min(1 / traced.frame.zoom, PICTURE_SIDE / max(traced.frame.image.shape[:2]))
    height, width = (round(zoom * side) for side in traced.frame.image.shape[:2])
    pixels = cv2.warpAffine(
        traced.picture,
        traced.frame.matrix * zoom,
        (width, height),
        flags=cv2.INTER_AREA,
        borderValue=(255, 255, 255),
    )
    x, z = -plan_origin(traced) * traced.metres
    told = dict.fromkeys(doubts(traced))
    lines = [line.replace("give --metres-per-pixel", _BY_HAND) for line in told]
    place = {"x": float(x), "z": float(z), "metres_per_pixel": traced.metres / zoom}
    return {
        "plan": (plan := plan_document(traced)),
        "picture": _page_picture(pixels) | place,
        "notes": lines,
        "scale": {
            "size": _size(plan, traced.file_metres),
            "doubt": lines[0] if traced.scale.confidence < SETTINGS.sure else "",
            "shown": place["metres_per_pixel"] / traced.file_metres,
        },
    }


def _size(plan: Mapping[str, Any], metres: float) -> list[float]:
    """Return the width and depth of a plan's rooms in pixels of `metres` each."""
    points = np.concatenate([np.asarray(room["polygon"]) for room in plan["rooms"]])
    return [float(side) / metres for side in np.ptp(points, axis=0)]


def _untraced(path: Path, metres_per_pixel: float | None) -> dict[str, Any]:
    """Return a picture that is not traced, in the form of :func:`opened`."""
    sizes: list[int] = []

    def reduced(image: Any) -> Any:
        sizes.append(max(image.size))
        return to_small_srgb(image, PICTURE_SIDE)

    pixels = decode_image(path, reduced, page_of=page_picture())
    file_pixels = sizes[0] / max(pixels.shape[:2])
    scale = {"metres_per_pixel": metres_per_pixel * file_pixels} if metres_per_pixel else {}
    return {
        "picture": _page_picture(pixels) | scale,
        "scale": {"size": None, "doubt": "", "shown": file_pixels},
    }


def _page_picture(pixels: np.ndarray) -> dict[str, Any]:
    """Return (h, w, 3) uint8 sRGB in the page's form: data URL, and width and height in pixels."""
    data = base64.b64encode(png_bytes(pixels)).decode("ascii")
    height, width = pixels.shape[:2]
    return {"url": f"data:image/png;base64,{data}", "width": width, "height": height}


def picture_bytes(picture: dict[str, Any]) -> bytes:
    """Return the PNG bytes of a picture in the form of :func:`opened`."""
    return base64.b64decode(picture["url"].partition(",")[2])


def editor_page(start: dict[str, Any]) -> str:
    """Return the page's HTML; `start` is ``{house, plan, photos, picture, notes}``."""
    program, style = joined_program("files_page"), (FOLDER / "editor.css").read_text("utf-8")
    policy = (
        f"default-src 'none'; script-src {source_hash(program)}; style-src {source_hash(style)}; "
        "img-src data: blob:; form-action 'none'; base-uri 'none'"
    )
    return html_page(
        FOLDER / "editor.html",
        title=str(start["house"]),
        style=style,
        policy=policy,
        maker=_MAKER,
        rules=inline_json(page_rules()),
        start=inline_json(start),
        program=program,
    )


def joined_program(entry: str, folders: Sequence[Path] = (FOLDER,)) -> str:
    """Join a JavaScript module and everything it imports, found in `folders`, into one module.

    Imports and the word ``export`` are removed. No two modules may define the same name; a browser
    would report that as an error of the joined module.
    """
    texts: dict[str, str] = {}
    needs: dict[str, list[str]] = {}
    queue = [entry]
    while queue:
        name = queue.pop()
        if name not in texts:
            candidates = (folder / f"{name}.js" for folder in folders)
            text = next(path for path in candidates if path.is_file()).read_text(encoding="utf-8")
            needs[name] = _IMPORT.findall(text)
            texts[name] = re.sub(r"^export (?=\w)", "", _IMPORT.sub("", text), flags=re.MULTILINE)
            queue += needs[name]
    return "\n".join(texts[name] for name in TopologicalSorter(needs).static_order())


#: Default width in metres of an opening that a click makes.
WIDTHS = {"door": 0.9, "window": 1.2, "passage": 1.2}
#: Default width in metres of a flight of stairs that is drawn in the editor.
FLIGHT = 0.9


def page_rules() -> dict[str, Any]:
    """Return the rules that ``rules.js`` follows, as plain JSON.

    Lengths are metres, areas square metres, angles radians. Every limit is taken from the reader of
    plans, so that the page and ``plan2scene run`` agree.
    """
    return {
        "schema": plan_json.plan_schema(),
        "format": plan_json.FORMAT,
        "room_types": list(ROOM_TYPES),
        "types": dict(parse.TYPE_NAMES),
        "devices": sorted(validate.DEVICES),
        "openings": {
            kind: {"width": WIDTHS[kind], "bottom": bottom, "top": top}
            for kind, (bottom, top) in HEIGHTS.items()
        },
        "flight_width": FLIGHT,
        "limits": _limits(),
    }


def _limits() -> dict[str, Any]:
    """Return the limits that the reader of plans checks."""
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
        "max_extent": validate.MAX_EXTENT,
        "max_usual_area": validate.MAX_USUAL_AREA,
        "heights": validate.HEIGHTS,
        "usual_heights": validate.USUAL_HEIGHTS,
        "usual_extent": validate.USUAL_EXTENT,
        "usual_area": validate.USUAL_AREA,
        "usual_door": validate.USUAL_DOOR,
        "narrow": validate.NARROW,
        "apart": validate.APART,
        "least_rise": STAIRS.least_rise,
        "least_flight": STAIRS.least_flight,
        "step_off": STAIRS.step_off,
        "riser": STAIRS.riser,
        "tread": STAIRS.tread,
        "flight_margin": STAIRS.margin,
    }
