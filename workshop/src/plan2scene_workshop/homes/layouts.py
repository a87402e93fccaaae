"""Layouts of apartments on a decimetre grid that gives the room of every square.

Two families: *corridor* (two strips of rooms along a corridor, often with the reception across
its end) and *hub* (rooms around a reception). Rooms become L-shaped where one turns around the
end of the corridor or where a closet, entrance or bathroom is cut from its corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

OUTSIDE = -1
#: Free squares around the footprint: balconies and gardens grow into them.
MARGIN = 40
#: Areas in square metres that rooms are drawn from, before they are fitted to their strip.
AREA_M2 = {
    "Reception": (16.0, 34.0),
    "Kitchen": (6.0, 14.0),
    "Bedroom": (8.5, 18.0),
    "Bathroom": (3.5, 8.0),
    "Staircase": (4.0, 8.0),
    "Unknown": (5.0, 12.0),
}
#: Least side of a room in decimetres.
LEAST_SIDE = {"Reception": 30, "Bedroom": 24, "Kitchen": 18, "Bathroom": 15}
#: Types of the rooms that are added to the basic ones: (relative probability, largest number).
EXTRAS = {
    "Bedroom": (4.0, 3),
    "Closet": (2.2, 2),
    "Bathroom": (2.0, 1),
    "Entrance": (1.6, 1),
    "Balcony": (1.6, 1),
    "Terrace": (0.5, 1),
    "Staircase": (0.6, 1),
    "Outdoor": (0.3, 1),
    "Unknown": (0.4, 1),
}
#: Share of homes whose kitchen is part of the reception.
OPEN_PLAN_SHARE = 0.35


@dataclass(frozen=True)
class GridPlan:
    """Rooms on a grid."""

    #: (rows, columns) int16: room index of each square decimetre, `OUTSIDE` elsewhere; row along
    #: z, column along x.
    labels: np.ndarray
    types: tuple[tuple[str, ...], ...]  #: of each room


def draw_layout(rng: np.random.Generator, rooms: int) -> GridPlan | None:
    """Return a random layout of about `rooms` rooms; None if a closet or balcony does not fit."""
    program = _program(rng, rooms)
    corridor = len(program) >= 6 or (len(program) == 5 and rng.random() < 0.5)
    canvas = _corridor(rng, program) if corridor else _hub(rng, program)
    for kind in ("Closet", "Balcony", "Terrace", "Outdoor"):
        for _ in range(program.count(kind)):
            grown = canvas.cut_corner(rng, kind) if kind == "Closet" else canvas.attach(rng, kind)
            if not grown:
                return None
    return canvas.finish(rng)


def _program(rng: np.random.Generator, rooms: int) -> list[str]:
    """Return the room types of a home; an open-plan kitchen is "Reception+Kitchen"."""
    program = ["Reception", "Bathroom", "Bedroom"]
    if rng.random() < OPEN_PLAN_SHARE:
        program[0] = "Reception+Kitchen"
    else:
        program.append("Kitchen")
    if rooms >= 6 or (rooms == 5 and rng.random() < 0.5):
        program.append("Corridor")
    added = dict.fromkeys(EXTRAS, 0)
    while len(program) < rooms:
        names = [name for name, (_, most) in EXTRAS.items() if added[name] < most]
        weights = np.array([EXTRAS[name][0] for name in names])
        name = str(rng.choice(names, p=weights / weights.sum()))
        added[name] += 1
        program.append(name)
    return program


class _Canvas:
    """A grid of labels that rooms are painted on."""

    def __init__(self, rows: int, columns: int) -> None:
        self.labels = np.full((rows + 2 * MARGIN, columns + 2 * MARGIN), OUTSIDE, np.int16)
        self.types: list[tuple[str, ...]] = []

    def paint(self, name: str, z0: int, z1: int, x0: int, x1: int) -> int:
        """Give rows z0..z1 and columns x0..x1 (ends excluded) to a new room; return its index."""
        self.types.append(tuple(name.split("+")))
        self.extend(len(self.types) - 1, z0, z1, x0, x1)
        return len(self.types) - 1

    def extend(self, index: int, z0: int, z1: int, x0: int, x1: int) -> None:
        """Give a rectangle to an existing room."""
        self.labels[z0 + MARGIN : z1 + MARGIN, x0 + MARGIN : x1 + MARGIN] = index

    def cut_corner(self, rng: np.random.Generator, kind: str) -> bool:
        """Cut a new room from a corner of a bedroom, else of a reception; False if none fits."""
        hosts = [i for i, t in enumerate(self.types) if t[0] in ("Bedroom", "Reception")]
        hosts.sort(key=lambda i: (self.types[i][0] != "Bedroom", rng.random()))
        depth, width = int(rng.integers(8, 15)), int(rng.integers(9, 18))
        for host in hosts:
            zs, xs = np.nonzero(self.labels == host)
            for top, left in rng.permutation([(a, b) for a in (0, 1) for b in (0, 1)]):
                z0 = zs.min() if top else zs.max() + 1 - depth
                x0 = xs.min() if left else xs.max() + 1 - width
                square = self.labels[z0 : z0 + depth, x0 : x0 + width]
                roomy = np.ptp(zs) > depth + 20 and np.ptp(xs) > width + 16
                if not roomy or (square != host).any() or not self._inside(z0, x0, depth, width):
                    continue
                self.types.append((kind,))
                square[:] = len(self.types) - 1
                return True
        return False

    def _inside(self, z0: int, x0: int, depth: int, width: int) -> bool:
        """Return whether a rectangle borders another room (closets are not in outer corners)."""
        rim = self.labels[z0 - 1 : z0 + depth + 1, x0 - 1 : x0 + width + 1]
        labels, counts = np.unique(
            np.r_[rim[0], rim[-1], rim[:, 0], rim[:, -1]], return_counts=True
        )
        return int(np.sum(counts[labels != OUTSIDE] > 7)) >= 2

    def attach(self, rng: np.random.Generator, kind: str) -> bool:
        """Add a balcony, terrace or garden to a reception, bedroom or kitchen; False on failure."""
        depth = int(rng.integers(11, 19) if kind == "Balcony" else rng.integers(18, 36))
        want = int(rng.integers(20, 46))
        for _ in range(40):
            turns = int(rng.integers(0, 4))
            view = np.rot90(self.labels, turns)
            host = int(rng.choice(len(self.types), p=_host_weights(self.types)))
            zs, xs = np.nonzero(view == host)
            row = int(zs.min())
            columns = np.sort(xs[zs == row])
            free = (view[row - depth - 1 : row, columns] == OUTSIDE).all(0)
            columns = columns[free]
            if len(columns) < 18 or columns[-1] - columns[0] != len(columns) - 1:
                continue
            width = min(want, len(columns))
            start = int(columns[0] + rng.integers(0, len(columns) - width + 1))
            self.types.append((kind,))
            view[row - depth : row, start : start + width] = len(self.types) - 1
            return True
        return False

    def finish(self, rng: np.random.Generator) -> GridPlan:
        """Return the plan, turned and mirrored at random, with one free square on each side."""
        labels = np.rot90(self.labels, int(rng.integers(0, 4)))
        if rng.random() < 0.5:
            labels = labels[:, ::-1]
        zs, xs = np.nonzero(labels != OUTSIDE)
        labels = labels[zs.min() - 1 : zs.max() + 2, xs.min() - 1 : xs.max() + 2]
        return GridPlan(np.ascontiguousarray(labels), tuple(self.types))


def _host_weights(types: list[tuple[str, ...]]) -> np.ndarray:
    """Return the probability of each room to get the balcony."""
    weight = {"Reception": 4.0, "Bedroom": 1.5, "Kitchen": 0.8}
    weights = np.array([weight.get(names[0], 0.0) for names in types])
    return weights / weights.sum()


def _width(rng: np.random.Generator, name: str, depth: int) -> int:
    """Return the width in decimetres of a room in a strip of `depth` decimetres."""
    first = name.split("+")[0]
    area = rng.uniform(*AREA_M2[first]) + (6.0 if "+" in name else 0.0)
    return max(round(area * 100 / depth), LEAST_SIDE.get(first, 14))


def _corridor(rng: np.random.Generator, program: list[str]) -> _Canvas:
    """Paint two strips of rooms along a corridor."""
    upper, lower = int(rng.integers(28, 44)), int(rng.integers(26, 42))
    aisle = int(rng.integers(10, 17))
    names = [n for n in program if n.split("+")[0] in AREA_M2]
    reception = next(n for n in names if n.startswith("Reception"))
    across = bool(rng.random() < 0.45)
    if across:
        names.remove(reception)
    strips = _strips(rng, names, (upper, lower))
    lengths = [sum(w for _, w in strip) for strip in strips]
    length = max(lengths)
    notched = length - min(lengths) >= 14 and rng.random() < 0.4
    end = _width(rng, reception, upper + aisle + lower) if across else 0
    end = max(end, 30) if across else 0
    canvas = _Canvas(upper + aisle + lower, length + end)
    last = []
    rows = ((0, upper), (upper + aisle, upper + aisle + lower))
    for strip, (z0, z1) in zip(strips, rows, strict=True):
        parts = [strip[i] for i in rng.permutation(len(strip))]
        edges = _edges(parts, None if notched else length)
        offset = length - edges[-1] if across or rng.random() < 0.5 else 0
        painted = [
            canvas.paint(name, z0, z1, a + offset, b + offset)
            for (name, _), a, b in zip(parts, edges[:-1], edges[1:], strict=True)
        ]
        last.append((painted[0], offset, edges[1] + offset))
    if across:
        canvas.paint(reception, 0, upper + aisle + lower, length, length + end)
    _paint_aisle(rng, canvas, program, (upper, upper + aisle, length), last)
    return canvas


def _strips(
    rng: np.random.Generator, names: list[str], depths: tuple[int, int]
) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """Return (room, width) of both strips, filled to similar lengths, large rooms first."""
    order = sorted(names, key=lambda n: -AREA_M2[n.split("+")[0]][1] + rng.uniform(-6, 6))
    strips: tuple[list[tuple[str, int]], list[tuple[str, int]]] = ([], [])
    for name in order:
        side = int(sum(w for _, w in strips[0]) > sum(w for _, w in strips[1]))
        strips[side].append((name, _width(rng, name, depths[side])))
    return strips


def _edges(parts: list[tuple[str, int]], length: int | None) -> list[int]:
    """Return the borders of rooms side by side, stretched to `length` (bathrooms least)."""
    widths = np.array([w for _, w in parts], dtype=float)
    if length is not None:
        stretch = np.array([1.0 if n.split("+")[0] != "Bathroom" else 0.25 for n, _ in parts])
        share = widths * stretch
        widths = widths + (length - widths.sum()) * share / share.sum()
    edges = [0, *np.round(np.cumsum(widths)).astype(int).tolist()]
    if length is not None:
        edges[-1] = length
    return edges


def _paint_aisle(
    rng: np.random.Generator,
    canvas: _Canvas,
    program: list[str],
    place: tuple[int, int, int],
    ends: list[tuple[int, int, int]],
) -> None:
    """Paint the corridor; its left end may be an entrance or belong to an L-shaped room."""
    z0, z1, length = place
    start = 0
    index, left, right = ends[int(rng.integers(0, 2))]
    if "Entrance" in program:
        start = int(rng.integers(14, 26))
        canvas.paint("Entrance", z0, z1, 0, start)
    elif rng.random() < 0.6 and left == 0 and right >= 26:
        start = min(int(rng.integers(11, 22)), right - 12)
        canvas.extend(index, z0, z1, 0, start)
    name = "Corridor"
    if "Entrance" not in program and rng.random() < 0.25:
        name = "Corridor+Entrance"
    canvas.paint(name, z0, z1, start, length)


def _hub(rng: np.random.Generator, program: list[str]) -> _Canvas:
    """Paint a reception with a column of rooms beside it, and other rooms cut from its corners."""
    reception = next(n for n in program if n.startswith("Reception"))
    column = [n for n in program if n in AREA_M2 and not n.startswith("Reception")]
    corner = ["Entrance"] if "Entrance" in program else []
    if "Corridor" in program:
        corner.append("Corridor")
    if len(column) > 2 and rng.random() < 0.5:
        corner.append(column.pop(column.index("Bathroom")))
    width = int(rng.integers(26, 40))
    heights = [max(_width(rng, n, width), LEAST_SIDE.get(n, 14)) for n in column]
    total = max(sum(heights), int(rng.integers(44, 70)))
    order = [int(i) for i in rng.permutation(len(column))]
    edges = _edges([(column[i], heights[i]) for i in order], total)
    depth = max(round(rng.uniform(*AREA_M2["Reception"]) * 100 / total), 34)
    canvas = _Canvas(total, depth + width)
    canvas.paint(reception, 0, total, 0, depth)
    for k, i in enumerate(order):
        canvas.paint(column[i], edges[k], edges[k + 1], depth, depth + width)
    corners = rng.permutation(2)
    for k, name in enumerate(corner[:2]):
        high, wide = int(rng.integers(15, 21)), int(rng.integers(16, 24))
        z0 = 0 if corners[k] else total - high
        canvas.paint(name, z0, z0 + high, 0, wide)
    if len(corner) > 2:  # a third one lies in the middle of the outer side
        canvas.paint(corner[2], total // 2 - 8, total // 2 + 8, 0, 16)
    return canvas
