"""Doors, passages and windows of a grid plan: which rooms they join, and where they are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import networkx as nx
import numpy as np

from plan2scene_workshop.homes.layouts import OUTSIDE, GridPlan

#: How natural a door between two room types is; for all other pairs it is `_ODD_DOOR`.
DOOR_WEIGHT = {
    frozenset(("Corridor", "Reception")): 1.0,
    frozenset(("Corridor", "Bedroom")): 1.0,
    frozenset(("Corridor", "Bathroom")): 1.0,
    frozenset(("Corridor", "Kitchen")): 0.9,
    frozenset(("Corridor", "Closet")): 0.8,
    frozenset(("Corridor", "Entrance")): 1.2,
    frozenset(("Corridor", "Staircase")): 1.0,
    frozenset(("Corridor", "Unknown")): 0.9,
    frozenset(("Entrance", "Reception")): 1.0,
    frozenset(("Entrance", "Closet")): 0.6,
    frozenset(("Entrance", "Kitchen")): 0.5,
    frozenset(("Reception", "Kitchen")): 0.85,
    frozenset(("Reception", "Bedroom")): 0.7,
    frozenset(("Reception", "Bathroom")): 0.6,
    frozenset(("Reception", "Balcony")): 0.9,
    frozenset(("Reception", "Terrace")): 0.9,
    frozenset(("Reception", "Outdoor")): 0.8,
    frozenset(("Reception", "Unknown")): 0.5,
    frozenset(("Bedroom", "Closet")): 0.9,
    frozenset(("Bedroom", "Bathroom")): 0.55,
    frozenset(("Bedroom", "Balcony")): 0.8,
    frozenset(("Bedroom", "Terrace")): 0.8,
    frozenset(("Kitchen", "Balcony")): 0.7,
    frozenset(("Kitchen", "Terrace")): 0.7,
    frozenset(("Kitchen", "Bathroom")): 0.2,
}
_ODD_DOOR = 0.1
#: Probability of an additional door between two rooms (one that is not needed to reach them).
EXTRA_DOOR = {
    frozenset(("Reception", "Kitchen")): 0.6,
    frozenset(("Corridor", "Reception")): 0.3,
    frozenset(("Bedroom", "Bathroom")): 0.12,
    frozenset(("Reception", "Balcony")): 1.0,
}
#: Probability that two rooms are joined by an open passage instead of a door.
PASSAGE = {
    frozenset(("Reception", "Kitchen")): 0.5,
    frozenset(("Corridor", "Reception")): 0.3,
    frozenset(("Corridor", "Entrance")): 0.5,
    frozenset(("Entrance", "Reception")): 0.4,
}
#: Probability of each possible window in an outer wall, by room type.
WINDOW = {
    "Reception": 0.95,
    "Bedroom": 0.92,
    "Kitchen": 0.85,
    "Bathroom": 0.4,
    "Corridor": 0.2,
    "Entrance": 0.2,
    "Staircase": 0.5,
    "Closet": 0.0,
    "Unknown": 0.5,
    "Balcony": 1.0,
    "Terrace": 1.0,
    "Outdoor": 1.0,
}
OPEN_AIR = ("Balcony", "Terrace", "Outdoor")
_FREE = 0.12  # metres between openings, and from an opening to a corner


@dataclass(frozen=True)
class Border:
    """A straight line between room `a` (on the side of smaller coordinates) and room `b`, metres.

    With `axis` 0 it runs along x at z = `line`, with 1 along z at x = `line`.
    """

    a: int
    b: int
    axis: int
    line: float
    low: float
    high: float

    @property
    def length(self) -> float:
        """Length in metres."""
        return self.high - self.low


@dataclass(frozen=True)
class Hole:
    """An opening in the plan, before it is cut into walls."""

    border: Border
    kind: str
    low: float
    high: float
    bottom: float
    top: float


def draw_doors(
    rng: np.random.Generator, plan: GridPlan, borders: list[Border], height: float
) -> list[Hole] | None:
    """Return doors and passages that connect all rooms; None if that is impossible."""
    graph = nx.Graph()
    graph.add_nodes_from(range(len(plan.types)))
    for border in borders:
        if OUTSIDE in (border.a, border.b) or border.length < 1.0:
            continue
        weight = max(
            _pair_value(DOOR_WEIGHT, plan.types[border.a], plan.types[border.b]), _ODD_DOOR
        )
        if _open_air(plan, border.a) and _open_air(plan, border.b):
            weight = 0.0
        known = graph.get_edge_data(border.a, border.b)
        if known is None or known["border"].length < border.length:
            graph.add_edge(
                border.a, border.b, border=border, weight=weight + rng.uniform(-0.05, 0.05)
            )
    if not nx.is_connected(graph):
        return None
    tree = nx.maximum_spanning_tree(graph)
    if any(data["weight"] < 0.16 for _, _, data in tree.edges(data=True)):
        return None
    chosen = set(tree.edges)
    for a, b in graph.edges:
        if rng.random() < _pair_value(EXTRA_DOOR, plan.types[a], plan.types[b]):
            chosen.add((a, b))
    top = min(round(float(rng.uniform(1.98, 2.12)), 2), height - 0.1)
    holes: list[Hole] = []
    for a, b in sorted(tuple(sorted(edge)) for edge in chosen):
        hole = _inner_door(rng, plan, graph.edges[a, b]["border"], top, height, holes)
        if hole is not None:
            holes.append(hole)
        elif tree.has_edge(a, b):
            return None
    return holes


def _pair_value(table: dict[frozenset[str], float], a: Iterable[str], b: Iterable[str]) -> float:
    """Return the largest entry of a table over all pairs of types."""
    return max(table.get(frozenset((x, y)), 0.0) for x in a for y in b)


def _open_air(plan: GridPlan, index: int) -> bool:
    """Return whether a room is a balcony, terrace or garden."""
    return plan.types[index][0] in OPEN_AIR


def _inner_door(
    rng: np.random.Generator,
    plan: GridPlan,
    border: Border,
    top: float,
    height: float,
    holes: list[Hole],
) -> Hole | None:
    """Return a door, glass door or passage on a border; None if it does not fit."""
    types = plan.types[border.a], plan.types[border.b]
    names = {*types[0], *types[1]}
    longest = border.length - 2 * _FREE
    if rng.random() < _pair_value(PASSAGE, *types):
        width, kind = float(rng.uniform(0.9, 2.4)), "passage"
        top = min(round(top + float(rng.choice([0.0, 0.2, 0.4])), 2), height - 0.1)
    elif names & set(OPEN_AIR):
        width, kind = float(rng.choice([0.8, 0.9, 1.6, 2.0])), "door"
    elif names & {"Closet", "Bathroom"}:
        width, kind = float(rng.uniform(0.65, 0.78)), "door"
    else:
        width, kind = float(rng.uniform(0.75, 0.9)), "door"
    return _place(rng, border, kind, min(width, longest), (0.0, top), holes, corner=0.6)


def _place(
    rng: np.random.Generator,
    border: Border,
    kind: str,
    width: float,
    span: tuple[float, float],
    holes: list[Hole],
    *,
    corner: float,
) -> Hole | None:
    """Return an opening of `width` on a border, clear of the others; None if it does not fit.

    `corner` is the probability that it lies close to an end of the border.
    """
    low, high = border.low + _FREE, border.high - _FREE - width
    if width < 0.4 or high < low - 1e-9:
        return None
    for _ in range(12):
        start = float(rng.uniform(low, max(low, high)))
        if rng.random() < corner:
            slack = min(high - low, float(rng.uniform(0.0, 0.15)))
            start = low + slack if rng.random() < 0.5 else high - slack
        start = round(start, 3)
        end = round(start + width, 3)
        clear = all(
            (other.border.axis, other.border.line) != (border.axis, border.line)
            or end + _FREE <= other.low
            or other.high + _FREE <= start
            for other in holes
        )
        if clear:
            return Hole(border, kind, start, end, *span)
    return None


def draw_entrance(
    rng: np.random.Generator,
    plan: GridPlan,
    borders: list[Border],
    holes: list[Hole],
    height: float,
) -> Hole | None:
    """Return the door from outside into the entrance, or else corridor, reception or kitchen."""
    top = min(2.1, height - 0.1)
    for wanted in ("Entrance", "Corridor", "Reception", "Kitchen"):
        outer = [
            border
            for border in borders
            if OUTSIDE in (border.a, border.b)
            and border.length >= 1.15
            and wanted in plan.types[max(border.a, border.b)]
        ]
        for i in rng.permutation(len(outer)):
            width = float(rng.uniform(0.85, 0.92))
            hole = _place(rng, outer[i], "door", width, (0.0, top), holes, corner=0.4)
            if hole is not None:
                return hole
    return None


def draw_windows(
    rng: np.random.Generator,
    plan: GridPlan,
    borders: list[Border],
    holes: list[Hole],
    height: float,
) -> list[Hole]:
    """Return windows on outer walls; a house has one sill height, head height and spacing."""
    sill, head = float(rng.uniform(0.75, 1.1)), float(rng.uniform(2.0, 2.3))
    pitch = float(rng.uniform(2.2, 3.6))
    taken = list(holes)
    for border in borders:
        if OUTSIDE not in (border.a, border.b) or border.length < 0.9:
            continue
        types = plan.types[max(border.a, border.b)]
        for _ in range(max(1, round(border.length / pitch))):
            if rng.random() >= max(WINDOW[name] for name in types):
                continue
            bottom, top = round(sill, 2), round(min(head, height - 0.12), 2)
            width = float(rng.uniform(0.7, 2.2))
            if types[0] in ("Bathroom", "Closet", "Staircase"):
                bottom, width = round(sill + 0.3, 2), float(rng.uniform(0.45, 0.9))
            elif types[0] in OPEN_AIR:
                bottom, width = 1.0, border.length - 2 * _FREE
            elif types[0] == "Reception" and rng.random() < 0.2:
                bottom = 0.1
            width = min(width, border.length - 2 * _FREE)
            hole = _place(rng, border, "window", width, (bottom, top), taken, corner=0.0)
            if hole is not None:
                taken.append(hole)
    return taken[len(holes) :]
