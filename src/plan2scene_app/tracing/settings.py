"""The labels of the plan network, and the tuned numbers of tracing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

#: In the order of the network's logits. The labels from `room` on are kinds of room: the network
#: tells them apart by their furniture.
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
#: Label of each room type. Back from label to type (labels above `ROOM`): the first entry counts.
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
#: Name of the weights of the network that finds fixtures; its labels in the order of its logits.
FIXTURE_MODEL = "fixtures"
FIXTURE_LABELS = ("none", "toilet", "sink", "bath", "shower", "stove", "counter")
FIXTURE_PPM = 40.0  #: Scale at which that network sees a drawing, pixels per metre


@dataclass(frozen=True)
class TraceSettings:
    """The tuned numbers of tracing.

    Sizes are metres and square metres that are usual in homes, set by hand. ``benchmarks/trace.py``
    measures the whole tracing with them (docs/measurements/trace.md). Those of the whole picture
    were chosen on 49 plans, nine of them real, and 39 photos of rooms: with them no plan is
    refused and every photo is. "Logarithm" is the natural one.
    """

    # The picture.
    long_side_px: int = 2000  #: longest side; a larger picture is reduced to it
    least_side_px: int = 120  #: shortest side; a smaller picture is refused
    contrast: int = 25  #: least range of grey values; a page with less is empty
    dark_page: int = 128  #: a page of a lower median grey value may be light lines on dark, ...
    light_lines: float = 1.5  #: ... if its lightest grey is this times further off than the darkest
    drawn_flat: float = 0.42  #: least flat share of such a page (`picture.flat_share`)
    drawn_paper: float = 0.5  #: least share of its main colour that makes a picture a drawing
    page_side_px: int = 384  #: side to which pictures of a photo folder are reduced for this test:
    page_paper: float = 0.65  #: least share of its main colour that makes one a drawing or a page
    busy: float = 0.65  #: flat share below which a picture may be a photo
    #: Least mean probability of the rooms in such a picture, if it has `drawn_paper`, and if not.
    least_sure: tuple[float, float] = (0.78, 0.86)
    fills: float = 0.75  #: share of the longer side: from it on, a drawing is not cut out
    # Drawings on one picture.
    drawing_ink: float = 25.0  #: least difference in grey value between paper and ink
    drawing_gap: float = 0.012  #: blank paper between two drawings, share of the longer side
    most_pages: int = 12  #: largest number of pages of a PDF that the network looks at
    photo_flat: float = 0.55  #: a page of a PDF with a lower flat share is a photo
    #: A drawing in which the network sees a home, but of which less is paper, is a photo. Chosen on
    #: four real plans, each in five copies (.47 at least), and 45 photos (.25 at most).
    home_paper: float = 0.4
    same_words: float = 0.7  #: least share of words in the home that pages of one plan share
    page_gap: float = 0.08  #: blank paper between pictures of storeys, share of the longest side
    drawing_size: float = 0.05  #: least area of a drawing's box, share of the largest one's
    most_drawings: int = 6  #: largest number of drawings that are looked at
    drawing_opening_px: int = 12  #: shorter doors and windows do not count for a home, ...
    rooms_an_opening: float = 2.0  #: ... which has at most this many rooms for each one
    walls_meet: float = 2.0  #: weight of outer walls that lie on one another; floors have 1
    stairs_meet: float = 8.0  #: weight of stairs that lie on one another
    # Straight and at the network's size.
    ppm: float = 32.0  #: pixels a metre at which the network is best
    largest_px: int = 1280  #: longest side of a picture for the network
    paper: float = 1.2  #: m of paper kept around a plan
    home_size: tuple[float, float] = (11.0, 0.4)  #: m of the longer side, spread of its logarithm
    least_turn: float = 0.25  #: degrees below which a plan is not turned
    first_views: int = 2  #: views of the whole picture (`segmenter.PlanSegmenter`)
    views: int = 4  #: views of the straight plan
    # Passages that nothing marks.
    facing: tuple[float, float] = (0.6, 4.0)  #: m between two ends of walls
    across: tuple[float, float] = (0.6, 3.6)  #: m between an end and the wall across
    facing_walled: float = 0.15  #: least share of walls on the line along walls and gap (`facing`)
    across_walled: float = 0.4  #: the same for `across`
    ending_wall: float = 0.5  #: m: largest thickness of a wall that ends in a floor
    free_end: float = 0.08  #: m: shortest piece of wall at its end with floor on both sides
    standing: float = 1.8  #: m: what joins no wall and is shorter is furniture
    parted_floor: float = 3.0  #: m2: least floor on either side of such a passage
    # Solid walls and what is drawn in their gaps.
    solid: float = 0.6  #: least share of solid pixels in the walls of a plan with solid walls
    solid_ink: float = 0.3  #: darkness of solid walls, grey ones too
    ink: float = 0.15  #: darkness of thin lines
    thin_wall: float = 0.06  #: m of the thinnest solid wall
    gap: tuple[float, float] = (0.45, 3.0)  #: m of a gap in a solid wall
    door_gap: tuple[float, float] = (0.55, 1.3)  #: m of a gap between rooms that is a door
    double_door: float = 2.0  #: m of the widest door with drawn leaves
    half_door: float = 0.35  #: share of door in a gap of door and window that makes all of it door
    unswung: float = 0.34  #: if fewer doors (a share) lack a drawn swing, these are passages
    gap_faint: float = 0.8  #: share of a passage's gap in which no line is as dark as `solid_ink`
    arc_angles: tuple[float, float] = (15.0, 75.0)  #: degrees: part of an arc that is looked at
    arc_radii: tuple[float, ...] = (0.8, 0.86, 0.92, 0.98, 1.04)  #: shares of the leaf's width
    arc_drawn: float = 0.85  #: least share of an arc that is drawn
    arc_beside: float = 0.5  #: largest share of the points beside the arc that is drawn
    slanted: float = 0.35  #: largest slope of an opening for which a swing is looked for
    swung: float = 0.8  #: confidence of a door whose swing is drawn
    #: Bands across the wall, from its face, in leaf widths: an open leaf, and what is behind it.
    leaf_reach: tuple[float, float] = (0.03, 1.3)
    behind_leaf: tuple[float, float] = (1.4, 1.8)
    leaf_seen: float = 0.35  #: thickness of an open leaf as the network sees it, in leaf widths
    dash: float = 0.15  #: m between dashes of a line
    #: Least share of the walls that are paper between two lines, in a plan with such walls.
    double_walls: float = 0.3
    slanted_cell: float = 0.75  #: a slanted cell of a hatch fills at most this share of its box
    # Walls that are thin lines.
    thin_line: float = 0.45  #: m of the shortest line
    thin_seen: float = 0.3  #: least share of such a line that the network labels as wall
    thin_gap: tuple[float, float] = (0.4, 2.0)  #: m of a gap between two lines, at the tried scale
    thin_wall_beside: float = 1.0  #: m: least length of the longer of the two
    thin_scales: tuple[float, ...] = (0.8, 0.9, 1.0, 1.2, 1.5)  #: scales tried, of the first guess
    thin_rounds: int = 6  #: most rounds in which furniture is joined with its room
    floors_a_name: float = 0.34  #: with fewer floors for each name, thin walls are looked for
    thin_names: int = 2  #: such lines must part this many more named rooms, or have as many gaps
    # Rooms.
    pocket: float = 0.15  #: share of room in its border that makes an enclosed outside a room
    neck: float = 0.5  #: m: a narrower neck parts two rooms
    strip: float = 0.3  #: m: least width of a strip behind a line (counter, shelf) kept as floor
    strip_beside: float = 0.2  #: least share of the strip's border along a floor that it may join
    strip_thinner: float = 0.75  #: the line to that floor is thinner than this times the next one
    room_floor: float = 0.6  #: m2 of the smallest room
    room_width: float = 0.5  #: m of the narrowest room
    shared_wall: float = 0.55  #: m: a gap up to this between rooms is a wall that both share
    closed: float = 0.7  #: least share of a room's border before a wall, opening or other room
    island: float = 3.0  #: m2: a smaller room without an opening is part of the room around it
    counter: float = 0.35  #: largest area of a kitchen's counter, share of the kitchen's floor
    counter_front: float = 0.3  #: least share of the counter's border that faces the kitchen
    furniture_share: float = 0.55  #: least share of one kind in a room that gives the room's type
    # Stairs; by usual sizes, looked at on two real plans of two storeys and six of one.
    tread_line: float = 0.06  #: m of the thickest line of a tread
    tread_length: tuple[float, float] = (0.55, 1.8)  #: m
    tread_depth: tuple[float, float] = (0.14, 0.42)  #: m from one to the next
    tread_alike: float = 0.75  #: least share of its length that a tread shares with the next
    least_treads: int = 5  #: fewest lines of a flight
    # Unnamed rooms of a plan with names; edges were looked at on two real plans.
    mark_slope: float = 60.0  #: least gradient of an edge, grey values (Sobel)
    askew: tuple[float, float] = (20.0, 70.0)  #: degrees from the axes, of arcs and slants
    swing_share: float = 0.4  #: with a larger share of `askew` edges, doors swing into the room
    stairs: float = 0.2  #: a room with a larger share of treads is a staircase
    fixtures: float = 1.5  #: m of edge a m2: a room with more has fixtures of a bath, ...
    fixtures_by_swings: float = 6.0  #: ... if doors swing there: three in a small room give 4
    bath: tuple[float, float] = (1.0, 14.0)  #: m2 of a bath; it has a door, a counter has none
    largest_closet: float = 3.0  #: m2
    ways_of_hall: int = 3  #: least number of doors and passages of a hall
    # Open rooms with several names.
    faint: float = 0.06  #: darkness of the faintest line that divides a floor
    line_drawn: float = 0.7  #: least share of a dividing line that is drawn
    neck_parts: float = 0.35  #: a dividing neck is narrower than the wider part by this share of it
    size_beside: float = 4.0  #: largest distance from a name to its printed size, in text heights
    size_off: float = 0.4  #: m off the dividing line at which a printed size has no vote any more
    # Outlines.
    tolerance: float = 0.13  #: m: largest distance of pixels from an outline's straight pieces
    shortest: float = 0.3  #: m of the shortest piece that gives a line
    along_axis: float = 12.0  #: largest angle to the picture's axis, degrees, of a piece along it
    merged: float = 0.1  #: m within which lines are one
    spike: float = 0.15  #: m: a narrower part of an outline is cut off
    # Openings.
    opening: float = 0.4  #: m of the narrowest opening that is looked for
    joined: float = 0.2  #: m: two openings on a wall that are nearer are one
    overhang: float = 0.25  #: an opening that ends at most so far beyond its wall is shortened
    off_wall: float = 0.3  #: m: an opening is no further from an outline than this plus the wall
    open_floor: float = 0.4  #: m: least width of a passage without a wall or symbol
    open_beside: float = 0.4  #: m of floor on both sides of such a passage
    open_room: float = 1.5  #: m: a passage this wide reaches the ceiling, ...
    open_blank: float = 0.8  #: ... if at least this share of it has no passage symbol
    alike_lines: float = 0.12  #: largest difference in darkness of the lines across one window
    pier: float = 0.3  #: m of the narrowest wall between two windows
    as_thick: float = 0.6  #: least thickness of wall, share of the edge's thickest; panes have less
    slid_beside: float = 0.8  #: m: windows this near are panes of the same sliding door
    slid_open: float = 0.7  #: largest blank share of a gap with sliding panes
    least_door: float = 0.4  #: m
    least_window: float = 0.3  #: m
    least_passage: float = 0.5  #: m
    widest_door: float = 1.2  #: m: a wider gap between rooms is a passage
    garage_door: float = 2.0  #: m of the narrowest garage door
    rail: float = 0.85  #: a window along this share of a terrace's side is its rail
    terrace_door: float = 1.5  #: m of the narrowest window that is a door to a terrace
    # Fixtures of baths and kitchens.
    fixture_views: int = 4  #: turned and mirrored views whose mean is taken
    fixture_score: float = 0.5  #: least mean probability of a fixture's pixels
    #: m: least shorter and largest longer side of a fixture
    fixture_sides: Mapping[str, tuple[float, float]] = field(
        default_factory=lambda: {
            "toilet": (0.25, 1.0),
            "sink": (0.2, 1.3),
            "bath": (0.5, 2.2),
            "shower": (0.5, 2.0),
            "stove": (0.35, 1.2),
        }
    )
    before_door: float = 0.3  #: m in front of a door where no fixture stands
    least_worktop: float = 0.9  #: m of the shortest worktop
    worktop_depth: tuple[float, float] = (0.3, 1.3)  #: m
    worktop_filled: float = 0.7  #: least share of a worktop's box that is worktop
    least_counter: float = 0.15  #: m of a counter between or beside sinks and stoves

    # Text and scale.
    text_px: tuple[int, int] = (1300, 2000)  #: bounds of the longer side for reading text
    printed_edge: float = 0.02  #: paper left around what is printed, share of the longer side
    text_score: float = 0.6  #: score of the reader below which text is not used
    #: Letters and score: upright text of so many letters or more with a lower score is read again.
    #: Level text of so many or fewer is, too, and its new reading needs the score. Chosen, with no
    #: dilation in the reader, on one real listing (development).
    reread: tuple[int, float] = (3, 0.9)
    #: Least number of words: if more than half of them are upright, the whole picture is turned.
    turned: int = 3
    door_width: tuple[float, float] = (0.85, 0.18)  #: m, spread of its logarithm between homes
    floor: tuple[float, float] = (12.0, 0.35)  #: m2 of a room, spread of the scale's logarithm
    agrees: float = 2.5  #: standard deviations within which evidence agrees
    sure: float = 0.6  #: confidence below which the scale is listed as a doubt
    doubtful: float = 0.6  #: probability below which rooms and openings are listed as doubts


SETTINGS = TraceSettings()
