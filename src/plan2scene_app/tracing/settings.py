"""The labels of the plan network, and the tuned numbers of tracing."""

from __future__ import annotations

from dataclasses import dataclass

#: In the order of the network's logits. Labels from `room` on are kinds of room, by furniture.
PLAN_LABELS = (
    "outside",
    "wall",
    "door",
    "window",
    "passage",
    "room",
    "reception",
    "bedroom",
    "kitchen",
    "bathroom",
    "corridor",
    "closet",
    "outdoor",
    "staircase",
)
OUTSIDE, WALL, DOOR, WINDOW, PASSAGE, ROOM = range(6)
STAIRS = PLAN_LABELS.index("staircase")
#: Kinds of opening, by label.
OPENINGS = {DOOR: "door", WINDOW: "window", PASSAGE: "passage"}
#: Label of each room type; labels above `ROOM` are read back as the first type that has them.
LABEL_OF_TYPE = {
    "Reception": 6,
    "Bedroom": 7,
    "Kitchen": 8,
    "Bathroom": 9,
    "Corridor": 10,
    "Entrance": 10,
    "Closet": 11,
    "Balcony": 12,
    "Terrace": 12,
    "Outdoor": 12,
    "Staircase": 13,
    "Unknown": ROOM,
}
#: Name of the network's weights in the folder of models.
MODEL = "plans"


@dataclass(frozen=True)
class TraceSettings:
    """The tuned numbers of tracing.

    Sizes are metres and square metres as homes usually have them, set by hand; what they give
    together is measured by ``benchmarks/trace.py`` (docs/measurements/trace.md). Those of the whole
    picture were chosen on 49 plans, nine of them real, and 39 photos of rooms: no plan and all
    photos are refused. "Logarithm" is the natural one.
    """

    # The picture.
    long_side_px: int = 2000  #: of the picture that is worked on
    least_side_px: int = 120
    contrast: int = 25  #: grey values that a page spans at least when something is drawn on it
    dark_page: int = 128  #: median grey value below which lines may be light on dark paper, ...
    light_lines: float = 1.5  #: ... if the lightest marks are so many times further from it
    drawn_flat: float = 0.42  #: share of a drawing that is flat (`picture.flat_share`)
    drawn_paper: float = 0.5  #: share of one colour from which a picture is no photo
    page_side_px: int = 384  #: of the pictures in a photo folder that are looked at
    page_paper: float = 0.65  #: share of one colour from which one of them is a drawing or a page
    busy: float = 0.65  #: flat share below which a picture may be a photo
    #: Least mean probability of the rooms in such a picture, with paper around them and without.
    least_sure: tuple[float, float] = (0.78, 0.86)
    fills: float = 0.75  #: of the longer side, from which a drawing is looked at with its paper
    # Drawings on one picture.
    drawing_ink: float = 25.0  #: grey values from paper to what is drawn
    drawing_gap: float = 0.012  #: of the longer side: blank paper between two drawings
    drawing_size: float = 0.05  #: of the largest one's box; what is smaller is no drawing
    most_drawings: int = 6  #: that are looked at
    drawing_opening_px: int = 12  #: of the shortest door or window that tells of a home, ...
    rooms_an_opening: float = 2.0  #: ... and for how many rooms one is enough
    walls_meet: float = 2.0  #: weight of outer walls that meet, where floors have 1
    stairs_meet: float = 8.0  #: weight of stairs that do
    # Straight and at the network's size.
    ppm: float = 32.0  #: pixels a metre at which the network is best
    largest_px: int = 1280  #: of a side that the network sees
    paper: float = 1.2  #: m of paper kept around a plan
    home_size: tuple[float, float] = (11.0, 0.4)  #: m of the longer side, spread of its logarithm
    least_turn: float = 0.25  #: degrees below which a plan is not turned
    first_views: int = 2  #: of the whole picture (`segmenter.PlanSegmenter`)
    views: int = 4  #: of the straight plan
    # Passages that nothing marks.
    facing: tuple[float, float] = (0.6, 4.0)  #: m between two ends of walls
    across: tuple[float, float] = (0.6, 3.6)  #: m between an end and the wall across
    facing_walled: float = 0.15  #: share of the line from wall to wall that walls follow
    across_walled: float = 0.4
    ending_wall: float = 0.5  #: m: a wall that ends is no thicker
    free_end: float = 0.08  #: m that a wall's end is free on both sides
    standing: float = 1.8  #: m: what joins no wall and is shorter is furniture
    parted_floor: float = 3.0  #: m2 on both sides of such a passage
    # Solid walls and what is drawn in their gaps.
    solid: float = 0.6  #: share of the wall's pixels from which walls are drawn solid
    solid_ink: float = 0.3  #: darkness of solid walls, grey ones too
    ink: float = 0.15  #: darkness of thin lines
    thin_wall: float = 0.06  #: m of the thinnest solid wall
    gap: tuple[float, float] = (0.45, 3.0)  #: m of a gap in a solid wall
    door_gap: tuple[float, float] = (0.55, 1.3)  #: m of one between rooms that is a door
    double_door: float = 2.0  #: m of the widest one whose leaves are drawn
    half_door: float = 0.35  #: share of door in a gap with door and window: all of it is a door
    unswung: float = 0.34  #: share of doors without a drawn swing below which they are passages
    gap_faint: float = 0.8  #: share of a wider one in which no line is dark: a passage
    arc_angles: tuple[float, float] = (15.0, 75.0)  #: degrees of an arc that are looked at
    arc_radii: tuple[float, ...] = (0.8, 0.86, 0.92, 0.98, 1.04)  #: shares of the gap
    arc_drawn: float = 0.85  #: share of an arc that is drawn
    arc_beside: float = 0.5  #: share of what is beside it that may be drawn
    slanted: float = 0.35  #: slope of an opening of which swings along an axis are looked for
    swung: float = 0.8  #: confidence of a door whose swing is drawn
    #: From a wall to the end of an open leaf, and to what is behind: shares of the leaf's width.
    leaf_reach: tuple[float, float] = (0.03, 1.3)
    behind_leaf: tuple[float, float] = (1.4, 1.8)
    leaf_seen: float = 0.35  #: share of its width that an open leaf is thick in the network's sight
    dash: float = 0.15  #: m between dashes of a line
    # Walls that are thin lines.
    thin_line: float = 0.45  #: m of the shortest
    thin_seen: float = 0.3  #: share of a line that the network takes for wall at least
    thin_gap: tuple[float, float] = (0.4, 2.0)  #: m of a gap in line, the scale a first guess
    thin_wall_beside: float = 1.0  #: m of the longer of these two
    thin_scales: tuple[float, ...] = (0.8, 0.9, 1.0, 1.2, 1.5)  #: tried, of the first guess
    thin_rounds: int = 6  #: in which furniture is joined with its room
    floors_a_name: float = 0.34  #: fewer floors than this for each name: thin walls are not seen
    thin_names: int = 2  #: names more that such lines part
    # Rooms.
    pocket: float = 0.15  #: share of the border of an enclosed area that is floor: a floor, too
    neck: float = 0.5  #: m: a narrower neck parts two rooms
    strip: float = 0.3  #: m of the narrowest part of a room behind a line, a counter's or shelf's
    strip_beside: float = 0.2  #: share of its border that a floor lies along to which it belongs
    strip_thinner: float = 0.75  #: thickness of the line to it, of that to the next floor
    room_floor: float = 0.6  #: m2 of the smallest room
    room_width: float = 0.5  #: m of the narrowest room
    shared_wall: float = 0.55  #: m: a gap up to this between rooms is a wall that both share
    closed: float = 0.7  #: share of a room's border with a wall, an opening or a room behind it
    island: float = 3.0  #: m2 up to which a room without an opening is part of another
    counter: float = 0.35  #: of a kitchen's floor: its largest counter
    counter_front: float = 0.3  #: share of its border that is open to the kitchen
    furniture_share: float = 0.55  #: share of a room's pixels of one kind from which it is the type
    # Stairs; by usual sizes, looked at on two real plans of two storeys and six of one.
    tread_line: float = 0.06  #: m of the thickest line of a tread
    tread_length: tuple[float, float] = (0.55, 1.8)  #: m
    tread_depth: tuple[float, float] = (0.14, 0.42)  #: m from one to the next
    tread_alike: float = 0.75  #: share of its length that a tread has in common with the next
    least_treads: int = 5
    # Unnamed rooms of a plan with names; edges were looked at on two real plans.
    mark_slope: float = 60.0  #: grey values of an edge (Sobel)
    askew: tuple[float, float] = (20.0, 70.0)  #: degrees from the axes, of arcs and slants
    swing_share: float = 0.4  #: of the edges: above, doors swing there; baths are mostly straight
    stairs: float = 0.2  #: share of a room that treads take from which it is a staircase
    fixtures: float = 1.5  #: m of edge for a m2 from which lines are fixtures of a bath, ...
    fixtures_by_swings: float = 6.0  #: ... where doors swing, too: three in a small room give 4
    bath: tuple[float, float] = (1.0, 14.0)  #: m2; counters of kitchens have no door
    largest_closet: float = 3.0  #: m2
    ways_of_hall: int = 3  #: doors and passages from which a room is one
    # Open rooms with several names.
    faint: float = 0.06  #: darkness of the faintest line that divides a floor
    line_drawn: float = 0.7  #: share of a dividing line that is drawn
    neck_parts: float = 0.35  #: share by which a dividing neck is narrower than both parts
    size_beside: float = 4.0  #: heights of a name from it to its printed size
    size_off: float = 0.4  #: m from where a printed size ends to the dividing line
    # Outlines.
    tolerance: float = 0.13  #: m between pixels and the straight pieces of an outline
    shortest: float = 0.3  #: m of a piece that gives a line
    along_axis: float = 12.0  #: degrees up to which a piece runs along the picture
    merged: float = 0.1  #: m within which lines are one
    spike: float = 0.15  #: m: a narrower part of an outline is none
    # Openings.
    opening: float = 0.4  #: m of the narrowest one that is looked for
    joined: float = 0.2  #: m within which two on a wall are one
    off_wall: float = 0.3  #: m from an outline to an opening's middle, beyond the wall's thickness
    open_floor: float = 0.4  #: m of floor between two rooms that are a passage
    open_beside: float = 0.4  #: m of floor on both sides of such a passage
    open_room: float = 1.5  #: m of its width from which on it has no lintel
    open_blank: float = 0.8  #: share of it without a passage's symbol: else it has one
    alike_lines: float = 0.12  #: darkness by which lines across one window differ
    pier: float = 0.3  #: m of the narrowest wall between two windows
    as_thick: float = 0.6  #: of an edge's thickest line: its wall; panes are thinner
    slid_beside: float = 0.8  #: m to windows that are of one door with sliding panes
    slid_open: float = 0.7  #: share of a gap with sliding panes that is blank at most
    least_door: float = 0.4  #: m
    least_window: float = 0.3  #: m
    least_passage: float = 0.5  #: m
    widest_door: float = 1.2  #: m: a wider gap between rooms is a passage
    garage_door: float = 2.0  #: m of the narrowest one
    rail: float = 0.85  #: share of a terrace's side from which on a window is its rail
    terrace_door: float = 1.5  #: m of the narrowest window that is one
    # Text and scale.
    text_px: tuple[int, int] = (1300, 2000)  #: longer side that text is read at
    printed_edge: float = 0.02  #: of the longer side: paper left around what is printed
    text_score: float = 0.6  #: of the reader, below which text is not used
    #: Letters and score: upright text of so many read less surely is read again. With no dilation
    #: of the reader: chosen on one real listing (development).
    reread: tuple[int, float] = (3, 0.9)
    #: Least words of which most stand upright that make a picture one whose text is turned.
    turned: int = 3
    door_width: tuple[float, float] = (0.85, 0.18)  #: m, spread of its logarithm between homes
    floor: tuple[float, float] = (12.0, 0.35)  #: m2 of a room, spread of the scale's logarithm
    agrees: float = 2.5  #: deviations within which evidence agrees
    sure: float = 0.6  #: confidence below which the scale is a guess
    doubtful: float = 0.6  #: probability below which rooms and openings are doubts


SETTINGS = TraceSettings()
