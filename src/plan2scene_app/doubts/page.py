"""doubts.html: the plan, the photos sorted by room, and a list of everything uncertain."""

from __future__ import annotations

import base64
import csv
import html
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import FROM_PHOTOS, House, Room
from plan2scene.images import read_image, read_reduced_image
from plan2scene.io import atomic_path, read_text
from plan2scene.photos.locate.pose import read_poses
from plan2scene.photos.locate.which_room import Likely, used_photos
from plan2scene.plans.geometry import room_polygon
from plan2scene.stage_json import read_stage_json
from plan2scene_app.html_page import html_page, inline_json, source_hash

_FOLDER = Path(__file__).parent
#: Longer side in pixels of photos and of the traced picture on the page.
_PHOTO_SIDE, _PICTURE_SIDE = 300, 1100
#: Height in metres of the letters of a room's name in the plan; less in a narrow room.
_LETTERS = 0.32
#: A photo whose room is less probable than this is a doubt.
SURE = 0.8
#: A room with at least this share of the best one's probability is named beside it.
_RIVAL = 0.5
#: More probable rooms than this stand first in the choice of a photo's room.
_POSSIBLE = 0.05


@dataclass(frozen=True)
class PlacedPhoto:
    """A row of photos.csv."""

    name: str
    room_id: str  #: empty if the photo is in no room
    probability: float | None  #: of the room; None if the photo table gives the room
    unused: bool = False  #: whether the room is only a guess and the photo is not used
    #: Other rooms that it may show, the most probable first, with their probability.
    others: Mapping[str, float] = field(default_factory=dict)
    number: int = 0  #: number of the row; the header has 0


@dataclass(frozen=True)
class DoubtFiles:
    """The files of one house that the page shows (docs/conventions.md)."""

    table: str | Path
    masks: str | Path | None = None
    cameras: str | Path | None = None
    #: Only for a plan that is a picture.
    overlay: str | Path | None = None
    doubts: str | Path | None = None


def read_placed(path: str | Path, cameras: str | Path | None = None) -> list[PlacedPhoto]:
    """Return the rows of the photos.csv that the places stage wrote beside its `cameras`.json."""
    entries = read_stage_json(cameras, "cameras") if cameras else {}
    rows = list(csv.DictReader(read_text(path).splitlines()))
    likely = {
        row["photo"]: Likely(row["room_id"], float(row["probability"]), float(row["of_kind"]))
        for row in rows
        if row["probability"]
    }
    used = used_photos(likely, {row["room_id"] for row in rows if row["photo"] not in likely})
    placed = []
    for number, row in enumerate(rows, start=1):
        name, room, guess = row["photo"], row["room_id"], likely.get(row["photo"])
        item = PlacedPhoto(name, room, None, number=number)
        if guess is not None:
            rooms = entries.get(name, {}).get("rooms", {})
            others = sorted(rooms.keys() - {room, ""}, key=lambda other: (-rooms[other], other))
            item = replace(
                item,
                probability=guess.probability,
                unused=name not in used,
                others={other: rooms[other] for other in others},
            )
        placed.append(item)
    return placed


def write_doubts(
    output: str | Path, photo_folder: str | Path, files: DoubtFiles, *, house: House
) -> list[str]:
    """Write the page, which needs no network; return its lines of doubt.

    On the page, the user can choose rooms of photos that the photo table leaves open, and save the
    table.

    Parameters
    ----------
    output : path
        The page.
    photo_folder : path
        Folder of the photos in the table; a photo that is missing is named without a picture.
    files : DoubtFiles
        Outputs of the stages.
    house : House
        The plan.
    """
    placed = read_placed(files.table, files.cameras)
    warned = files.masks and Path(files.masks) / "warnings.json"
    left_out = read_stage_json(warned, "warnings") if warned else []
    traced = read_text(files.doubts).splitlines() if files.doubts else []
    lines = list(doubt_lines(house, placed, left_out, traced))
    poses = read_poses(files.cameras) if files.cameras else {}
    eyes = {name: (pose.room_id, pose.eye[0], pose.eye[2]) for name, pose in poses.items()}
    folder = Path(photo_folder)
    shown = {row.room_id for row in placed}
    groups = [
        _room_section(house, room, placed, folder) for room in house.rooms if room.id in shown
    ]
    bare = [room.id for room in house.rooms if room.id not in shown]
    style, program = (
        (_FOLDER / f"doubts.{kind}").read_text(encoding="utf-8") for kind in ("css", "js")
    )
    picture = "" if files.overlay is None else _picture(files.overlay)
    page = html_page(
        _FOLDER / "doubts.html",
        title=house.title,
        style=style,
        policy=f"default-src 'none'; script-src {source_hash(program)}; "
        f"style-src {source_hash(style)}; img-src data:",
        program=program,
        table=inline_json(list(csv.reader(read_text(files.table).splitlines()))),
        doubts="\n".join(f"<li>{_linked(line, house)}</li>" for line in lines),
        count=f"{len(lines) or 'No'} doubts" if len(lines) != 1 else "1 doubt",
        plans="\n".join(_plan(storey, level.name, eyes) for level, storey in house.storeys()),
        picture=picture,
        rooms="\n".join(groups),
        bare=", ".join(
            f'<a id="room-{html.escape(room)}" href="#plan-{html.escape(room)}">'
            f"{html.escape(house.labels[room])}</a>"
            for room in bare
        ),
        unplaced=_cards([row for row in placed if not row.room_id], folder, house),
    )
    with atomic_path(output) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return lines


def doubt_lines(
    house: House,
    placed: Sequence[PlacedPhoto],
    left_out: Sequence[str],
    traced: Sequence[str],
) -> Iterator[str]:
    """Yield a line for each doubt, the most serious first.

    `left_out` are the warnings of the masks stage, `traced` the doubts of tracing the plan.
    """
    labels = house.labels
    lost = [row.name for row in placed if not row.room_id]
    used = {row.room_id for row in placed if row.room_id and not row.unused}
    idle = sum(row.unused or not row.room_id for row in placed)
    if placed and not used:
        yield f"no photo finds its place in the plan: the house is made without {idle} photos"
    elif 2 * idle > len(placed):
        yield f"the house is made without {idle} of {len(placed)} photos: their rooms are not sure"
    yield from (f"plan: {line}" for line in traced)
    if house.heights:
        why = "as photos show" if house.heights == FROM_PHOTOS else "as usual: no photo shows them"
        yield f"the plan tells no heights: ceilings at {house.rooms[0].height:.2f} m, {why}"
    guessed = {o.id for wall in house.walls for o in wall.openings if o.guessed}
    if guessed:
        yield f"the plan draws no windows: {len(guessed)} are guesses, drawn ones replace them"
    yield from left_out
    if lost and used:
        yield f"no room is found for {', '.join(lost)}"
    yield from _doubts_of_rooms(placed, labels)
    bare = [labels[room.id] for room in house.rooms if room.id not in used and not room.open_air]
    if used and bare:
        yield f"no photo shows {', '.join(bare)}: made like the other rooms"


def _doubts_of_rooms(placed: Sequence[PlacedPhoto], labels: Mapping[str, str]) -> Iterator[str]:
    """Yield a line for all photos whose room is equally doubtful, those that are not used last."""
    groups: dict[tuple[bool, str], list[PlacedPhoto]] = {}
    for row in placed:
        if row.probability is not None and row.probability < SURE:
            rivals = [room for room, p in row.others.items() if p >= _RIVAL * row.probability]
            candidates = [labels.get(room, room) for room in (row.room_id, *rivals[:2])]
            groups.setdefault((row.unused, " or ".join(candidates)), []).append(row)
    for (unused, rooms), rows in sorted(groups.items(), key=lambda group: group[0][0]):
        percents = [round(100 * (row.probability or 0.0)) for row in rows]
        low, high = min(percents), max(percents)
        sure = f"{high}% sure" if low == high else f"{low} to {high}% sure"
        names = ", ".join(row.name for row in rows)
        yield f"{rooms}? {sure}{', not used' if unused else ''}: {names}"


def _linked(line: str, house: House) -> str:
    """Return a line as HTML; names of rooms become links to the rooms in the plan."""
    labels = house.labels
    rooms = {label: room for room, label in labels.items()} | {room: room for room in labels}
    longest = "|".join(re.escape(word) for word in sorted(rooms, key=len, reverse=True))
    parts = re.split(rf"(?<![\w.-])({longest})(?![\w.-])", line)
    return "".join(
        f'<a href="#plan-{html.escape(rooms[part])}">{html.escape(labels[rooms[part]])}</a>'
        if number % 2
        else html.escape(part)
        for number, part in enumerate(parts)
    )


def _room_section(house: House, room: Room, placed: Sequence[PlacedPhoto], folder: Path) -> str:
    """Return the HTML of a room and its photos."""
    name, label = html.escape(room.id), html.escape(house.labels[room.id])
    title = html.escape(" / ".join(room.types))
    area = room_polygon(room).area
    cards = _cards([row for row in placed if row.room_id == room.id], folder, house)
    return (
        f'<section id="room-{name}"><h3><a href="#plan-{name}">{label}</a> '
        f"<small>{title}, {area:.1f} m²</small></h3>{cards}</section>"
    )


def _cards(rows: Sequence[PlacedPhoto], folder: Path, house: House) -> str:
    """Return the HTML of photos, side by side."""
    return "".join(
        f"<figure>{_thumbnail(folder / row.name)}<figcaption>{html.escape(row.name)}"
        f"{_sure(row)}{_choice(row, house)}</figcaption></figure>"
        for row in rows
    )


def _sure(row: PlacedPhoto) -> str:
    if not row.room_id:
        return ""
    if row.probability is None:
        return " <small>as told</small>"
    kind = "" if row.probability >= SURE else ' class="doubt"'
    return f" <small{kind}>{row.probability:.0%} sure</small>"


def _choice(row: PlacedPhoto, house: House) -> str:
    """Return the HTML of a choice of rooms for a photo; empty if the photo table gives the room."""
    if row.room_id and row.probability is None:
        return ""
    first = "" if row.unused else row.room_id
    possible = [room for room, p in row.others.items() if p > _POSSIBLE]
    likely = [room for room in (row.room_id, *possible) if room in house.labels]
    rooms = {room: house.labels[room] for room in (*likely, *house.labels)}
    options = {"": "not sure", **rooms, "-": "no room of this home"}
    if first:
        del options[""]
    listed = "".join(
        f'<option value="{html.escape(value)}"{" selected" * (value == first)}>'
        f"{html.escape(text)}</option>"
        for value, text in options.items()
    )
    return (
        f'<select data-row="{row.number}" data-first="{html.escape(first)}" '
        f'aria-label="Room of {html.escape(row.name)}">{listed}</select>'
    )


def _thumbnail(path: Path) -> str:
    """Return a photo as an HTML image; empty if it can't be read."""
    try:
        image, _ = read_reduced_image(path, _PHOTO_SIDE)
    except InputError:
        return ""
    return f'<img src="{_jpeg(image, _PHOTO_SIDE, 80)}" alt="">'


def _picture(path: str | Path) -> str:
    """Return the HTML of the overlay: the traced plan drawn over the picture of the plan."""
    source = _jpeg(read_image(path), _PICTURE_SIDE, 85)
    return f'<details open><summary>As traced</summary><img src="{source}" alt="Plan"></details>'


def _jpeg(image: np.ndarray, side: int, quality: int) -> str:
    """Return (h, w, 3) uint8 sRGB as a data URL, its longer side at most `side` pixels."""
    zoom = min(1.0, side / max(image.shape[:2]))
    if zoom < 1:
        image = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    _, data = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)
    return f"data:image/jpeg;base64,{base64.b64encode(data.tobytes()).decode('ascii')}"


def _plan(house: House, level: str, eyes: Mapping[str, tuple[str, float, float]]) -> str:
    """Return a storey as SVG: its rooms, and the camera positions `eyes`, (room, x, z) by photo."""
    points = np.array([point for room in house.rooms for point in room.rings[0]])
    low, high = points.min(axis=0) - 0.3, points.max(axis=0) + 0.3
    shapes, labels = [], []
    for room in house.rooms:
        name = html.escape(room.id)
        path = " ".join(
            "M" + " ".join(f"{x:.2f},{z:.2f}" for x, z in ring) + "Z" for ring in room.rings
        )
        polygon, title = room_polygon(room), room.name or room.id
        spot = polygon.representative_point()
        left, _, right, _ = polygon.bounds
        letters = min(_LETTERS, 1.6 * (right - left) / len(title))  # a letter's width is .6 of it
        shapes.append(
            f'<a href="#room-{name}" aria-label="{html.escape(title)}">'
            f'<path id="plan-{name}" d="{path}"/></a>'
        )
        labels.append(
            f'<text x="{spot.x:.2f}" y="{spot.y:.2f}" font-size="{letters:.2f}">'
            f"{html.escape(title)}</text>"
        )
    ids = {room.id for room in house.rooms}
    dots = [
        f'<circle cx="{x:.2f}" cy="{z:.2f}" r=".12"><title>{html.escape(name)}</title></circle>'
        for name, (room_id, x, z) in eyes.items()
        if room_id in ids
    ]
    size = high - low
    box = f"{low[0]:.2f} {low[1]:.2f} {size[0]:.2f} {size[1]:.2f}"
    caption = f"<figcaption>{html.escape(level)}</figcaption>" if level else ""
    return (
        f'<figure class="plan">{caption}<svg viewBox="{box}" role="group" aria-label="Plan">'
        f"{''.join(shapes + labels + dots)}</svg></figure>"
    )
