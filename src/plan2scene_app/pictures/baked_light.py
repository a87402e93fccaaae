"""Light baked into texels of a house's surfaces: radiosity by rays (Cohen and Wallace 1993).

Light comes from the sky through the windows, from a lamp in every room, and from some bounces.
Every texel casts a few rays about its normal. What the rays hit (the sky or another texel) is
computed once; then each bounce is a sum over the rays. The texels of a block cast rays in different
directions, and their results are averaged (interleaved sampling, Keller and Heidrich 2001), because
hardly any ray of a single texel reaches a far window. Values are factors on a surface's colour,
about 1 where a room is lit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from plan2scene.colour import srgb_to_linear
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.mesh.baking import LAMP, Chart, lamp_position, packed
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.rays import Rays, hemisphere
from plan2scene.mesh.texture_files import TileTexture

#: Linear RGB of sky and ground outside, 1 for a white surface in full light.
SKY = np.array([1.55, 1.7, 1.9])
GROUND = np.array([0.55, 0.53, 0.5])


@dataclass(frozen=True)
class LightSettings:
    """How light is baked. Values are factors on a surface's colour."""

    rays: int = 64  #: rays of each texel
    block: int = 5  #: side of the block of texels that cast rays in different directions; odd
    bounces: int = 4
    most_px: int = 2048  #: largest width and height of the image
    plain: float = 0.6  #: linear reflectance of parts without texels, such as doors and frames
    lamp_share: float = 0.3  #: mean direct light of a lamp in its room, if `lamp_most` allows it
    lamp_most: float = 0.8  #: largest direct light of a lamp in its room
    lamp_glow_m: float = 1.1  #: added (squared) to the squared distance, so that light stays finite
    middle: float = 0.9  #: median light of a house after exposure
    before_m: float = 0.1  #: parts without texels get the light near a point this far before them,
    near_texels: int = 24  #: as a weighted mean of this many nearest wall texels
    #: Ratio of the mean light of floors to that of walls, in rooms that are open to each other. A
    #: floor's paint is estimated from its ratio to the walls in photos, so it already contains the
    #: difference of their light there. With this value floors are as bright beside walls as in
    #: photos, in the mean of 32 photos of four real listings (development).
    floor: float = 1.1
    brightest: float = 1.3  #: largest mean light of a room or a balcony
    knee: float = 0.75  #: linear value from which highlights of pictures are compressed


LIGHT = LightSettings()


@dataclass(frozen=True)
class Light:
    """Baked light as an image, and the place of each part in it.

    Attributes
    ----------
    image : (h, w, 3) float32
        Linear factors on surface colours.
    charts : mapping of part name to Chart
    walls : (tree, (n, 3) float64, (n,) str) or None
        Points of the wall texels, their light and their rooms: parts without texels get the light
        of walls near them.
    """

    image: np.ndarray
    charts: Mapping[str, Chart]
    walls: tuple[cKDTree, np.ndarray, np.ndarray] | None = None

    def uv(self, part: MeshPart) -> np.ndarray:
        """Return texture coordinates (n, 2) of a part's vertices in the image, v down."""
        height, width = self.image.shape[:2]
        return self.charts[part.name].texels(np.asarray(part.uv)) / [width, height]

    def of_plain(self, part: MeshPart) -> np.ndarray:
        """Return the light (n, 3) at the vertices of a part without texels: that of walls near it.

        Without walls the light is even, a little brighter on faces that look up.
        """
        normals = part.mesh.vertex_normals
        if self.walls is None:
            return np.asarray(1.0 + 0.15 * normals[:, [1, 1, 1]])
        tree, lights, owner = self.walls
        before = part.mesh.vertices + LIGHT.before_m * normals
        away, near = tree.query(before, k=min(LIGHT.near_texels, len(lights)))
        shape = len(before), -1
        near = near.reshape(shape)
        same = owner[near] == owner[near[:, :1]]  # not the wall of the room behind
        weights = same / (away.reshape(shape) + LIGHT.before_m)
        light = (lights[near] * weights[..., None]).sum(axis=1)
        return np.asarray(light / weights.sum(axis=1, keepdims=True))


@dataclass(eq=False)
class _Texels:
    """All texels on parts, in one list: points, numbers of their charts, colours."""

    points: np.ndarray
    charts: np.ndarray
    colours: np.ndarray
    index: np.ndarray  # (h, w) int: number of the texel of a pixel, -1 off the parts


def bake_light(
    house: House,
    parts: Sequence[MeshPart],
    colours: Mapping[SurfaceKey, np.ndarray],
    texel_m: float,
) -> Light | None:
    """Return the light of a house's textured parts; None without a ray tracer. Deterministic.

    Parameters
    ----------
    house : House
    parts : sequence of MeshPart
    colours : mapping of SurfaceKey to (3,) float
        Mean linear RGB of the surfaces; parts of other surfaces get no texels.
    texel_m : float
        Side of a texel, metres.
    """
    flat = [part for part in parts if part.surface in colours]
    rays = Rays.of([part for part in parts if part.extras.get("kind") != "skirting"])
    if rays is None or not flat:
        return None
    charts, shape = packed(flat, texel_m, LIGHT.most_px)
    grids = [chart.grid() for chart in charts]
    texels = _texels(charts, grids, colours, shape)
    direct = _lamps(house, charts, texels, rays)
    hit_texels, sky = _seen(charts, grids, texels, rays)
    reflected = np.vstack([texels.colours, np.full((1, 3), LIGHT.plain)])
    light = direct + sky
    for _ in range(LIGHT.bounces):
        outgoing = np.vstack([light, np.median(light, axis=0)]) * reflected
        light = direct + sky + _gathered(outgoing, hit_texels)
    names = np.array([str(chart.part.extras.get("room_id", "")) for chart in charts])
    kinds = np.array([str(chart.part.extras.get("kind", "")) for chart in charts])
    owner, upright = names[texels.charts], kinds[texels.charts] == "wall"
    under = np.isin(kinds[texels.charts], ("floor", "threshold"))
    for rooms in _open_to_each_other(house):
        floor, wall = (np.isin(owner, rooms) & those for those in (under, upright))
        if floor.any() and wall.any():
            light[floor] *= LIGHT.floor * light[wall].mean() / max(light[floor].mean(), 1e-6)
    light *= LIGHT.middle / max(float(np.median(light.mean(axis=1))), 1e-6)
    for room in np.unique(owner):  # limit bright rooms such as terraces: eyes adapt to them
        in_room = owner == room
        light[in_room] *= min(1.0, LIGHT.brightest / max(float(light[in_room].mean()), 1e-6))
    image = np.zeros((*shape, 3), np.float32)
    start = 0
    for chart, (_, inside) in zip(charts, grids, strict=True):
        values = np.zeros((*inside.shape, 3))
        count = int(inside.sum())
        values[inside] = light[start : start + count]
        if not count:  # a strip that is too narrow to contain the centre of a texel
            values[:] = np.median(light, axis=0)
        chart.paste(image, *_continued(_smooth(values, inside), inside))
        start += count
    walls = None
    if upright.any():
        walls = cKDTree(texels.points[upright]), light[upright], owner[upright]
    return Light(image, {chart.part.name: chart for chart in charts}, walls)


def even_light() -> Light:
    """Return even light, for a house whose light cannot be baked."""
    return Light(np.ones((1, 1, 3), np.float32), {})


def compressed(linear: np.ndarray) -> np.ndarray:
    """Return linear values; those above `LIGHT.knee` are compressed so that they stay below 1."""
    over = np.maximum(linear - LIGHT.knee, 0.0)
    return np.minimum(linear, LIGHT.knee) + (1 - LIGHT.knee) * over / (over + 1 - LIGHT.knee)


def mean_colours(textures: Mapping[SurfaceKey, TileTexture]) -> dict[SurfaceKey, np.ndarray]:
    """Return the mean linear RGB (3,) of each surface's tile."""
    colour_by_png: dict[bytes, np.ndarray] = {}
    for tile in textures.values():
        if tile.png not in colour_by_png:
            colour_by_png[tile.png] = srgb_to_linear(image_from_bytes(tile.png)).mean(axis=(0, 1))
    return {key: colour_by_png[tile.png] for key, tile in textures.items()}


def _open_to_each_other(house: House) -> list[list[str]]:
    """Return the ids of all rooms, grouped into connected components that passages join."""
    index = {room.id: k for k, room in enumerate(house.rooms)}
    joined = np.zeros((len(index), len(index)), bool)
    for one, other, _ in house.passages():
        joined[index[one], index[other]] = True
    count, labels = connected_components(joined, directed=False)
    return [[room for room, k in index.items() if labels[k] == group] for group in range(count)]


def _texels(
    charts: Sequence[Chart],
    grids: Sequence[tuple[np.ndarray, np.ndarray]],
    colours: Mapping[SurfaceKey, np.ndarray],
    shape: tuple[int, int],
) -> _Texels:
    """Return the texels of all charts."""
    index = np.full(shape, -1)
    points, numbers, looks, start = [], [], [], 0
    for number, (chart, (uv, inside)) in enumerate(zip(charts, grids, strict=True)):
        count = int(inside.sum())
        points.append(chart.world(uv[inside]))
        numbers.append(np.full(count, number))
        look = np.zeros(3) if chart.part.surface is None else colours[chart.part.surface]
        looks.append(np.tile(look, (count, 1)))
        order = np.full(inside.shape, -1)
        order[inside] = np.arange(start, start + count)
        chart.paste(index, order, inside)
        start += count
    return _Texels(np.concatenate(points), np.concatenate(numbers), np.concatenate(looks), index)


def _seen(
    charts: Sequence[Chart],
    grids: Sequence[tuple[np.ndarray, np.ndarray]],
    texels: _Texels,
    rays: Rays,
) -> tuple[np.ndarray, np.ndarray]:
    """Return what the rays of n texels hit, and the mean light (n, 3) from outside over the rays.

    Hits are (n, `LIGHT.rays`) int: number of a texel, n for a part without texels, n + 1 outside.
    """
    count = len(texels.points)
    hit_texels = np.full((count, LIGHT.rays), count + 1)
    sky = np.zeros((count, 3))
    by_name = {chart.part.name: chart for chart in charts}
    chart_by_part = [by_name.get(part.name) for part in rays.parts]
    for number, (chart, (_, inside)) in enumerate(zip(charts, grids, strict=True)):
        chart_texels = np.flatnonzero(texels.charts == number)
        if not len(chart_texels):
            continue
        row, column = np.nonzero(inside)
        place = row % LIGHT.block * LIGHT.block + column % LIGHT.block
        shifts = (np.arange(LIGHT.block**2) + 0.5) / LIGHT.block**2 - 0.5
        sets = np.stack([hemisphere(chart.normal, LIGHT.rays, shift) for shift in shifts])
        # Neighbours get different sets of directions: 7 and the number of sets are coprime.
        directions = sets[place * 7 % len(sets)].reshape(-1, 3)
        origins = np.repeat(texels.points[chart_texels], LIGHT.rays, axis=0)
        hit = rays.hits(origins, directions)
        out = (hit < 0).reshape(-1, LIGHT.rays)
        up = directions[:, 1].reshape(-1, LIGHT.rays) > 0
        for part, colour in ((out & up, SKY), (out & ~up, GROUND)):
            sky[chart_texels] += part.mean(axis=1)[:, None] * colour
        numbers = np.full(len(hit), count + 1)
        numbers[hit >= 0] = count
        for part_number in np.unique(rays.part[hit[hit >= 0]]):
            target = chart_by_part[part_number]
            if target is not None:
                part_hits = np.flatnonzero((hit >= 0) & (rays.part[hit] == part_number))
                points, _ = rays.points(hit[part_hits], origins[part_hits], directions[part_hits])
                numbers[part_hits] = _texel_at(target, points, texels.index, count)
        hit_texels[chart_texels] = numbers.reshape(-1, LIGHT.rays)
    return hit_texels, sky


def _texel_at(chart: Chart, points: np.ndarray, index: np.ndarray, plain: int) -> np.ndarray:
    """Return the numbers of a chart's texels at world points (n, 3); `plain` if there is none."""
    homogeneous_vertices = np.column_stack(
        [chart.part.mesh.vertices, np.ones(len(chart.part.mesh.vertices))]
    )
    to_uv, *_ = np.linalg.lstsq(homogeneous_vertices, np.asarray(chart.part.uv), rcond=None)
    column, row = np.floor(chart.texels(np.column_stack([points, np.ones(len(points))]) @ to_uv)).T
    place = (
        np.clip(n, 0, m - 1).astype(int) for n, m in zip((row, column), index.shape, strict=True)
    )
    numbers = index[tuple(place)]
    return np.where(numbers < 0, plain, numbers)


def _gathered(known: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the mean reflected light (n, 3) over all rays, without the light from outside."""
    padded = np.vstack([known, np.zeros((1, 3))]).astype(np.float32)
    return np.stack([padded[:, k][seen].mean(axis=1) for k in range(3)], axis=1)


def _lamps(house: House, charts: Sequence[Chart], texels: _Texels, rays: Rays) -> np.ndarray:
    """Return the direct light of one lamp below each room's ceiling, (n, 3)."""
    light = np.zeros((len(texels.points), 3))
    normals = np.stack([chart.normal for chart in charts])[texels.charts]
    names = np.array([str(chart.part.extras.get("room_id", "")) for chart in charts])
    for room in house.rooms:
        lamp = lamp_position(house, room.id)
        away = lamp - texels.points
        distance = np.linalg.norm(away, axis=1)
        facing = np.einsum("ij,ij->i", away, normals) / np.maximum(distance, 1e-6)
        strength = np.maximum(facing, 0.0) / (distance**2 + LIGHT.lamp_glow_m**2)
        in_room = names[texels.charts] == room.id
        if not strength[in_room].any():
            continue
        share = min(
            LIGHT.lamp_share / strength[in_room].mean(), LIGHT.lamp_most / strength[in_room].max()
        )
        lit = np.flatnonzero(strength > 0.02 * strength[in_room].max())
        free = rays.distances(texels.points[lit], away[lit] / distance[lit, None])
        lit = lit[free > distance[lit]]
        light[lit] += (share * strength[lit])[:, None] * LAMP
    return light


def _smooth(values: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return values (h, w, 3) averaged along rows and columns over a block about each texel.

    Near an edge of the part the block is narrower, so that it stays symmetric about the texel.
    """
    for axis in (0, 1):
        mean, total, whole = values, values, inside
        for step in range(1, LIGHT.block // 2 + 1):
            whole = whole & np.roll(inside, step, axis) & np.roll(inside, -step, axis)
            total = total + np.roll(values, step, axis) + np.roll(values, -step, axis)
            mean = np.where(whole[..., None], total / (2 * step + 1), mean)
        values = mean
    return values


def _continued(values: np.ndarray, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values (h, w, 3) and a mask of the known ones, with one more texel beyond each edge.

    The new values are extrapolated linearly, so that light is continuous across the parts of a
    plane.
    """
    total, count = np.zeros_like(values), np.zeros(inside.shape)
    for axis in (0, 1):
        for step in (1, -1):
            near, far = (np.roll(inside, n * step, axis) for n in (1, 2))
            usable = ~inside & near & far
            one, two = (np.roll(values, n * step, axis) for n in (1, 2))
            total[usable] += np.clip(2 * one - two, 0.5 * one, 2 * one)[usable]
            count += usable
    beyond = count > 0
    values = np.where(beyond[..., None], total / np.maximum(count, 1)[..., None], values)
    return values, inside | beyond
