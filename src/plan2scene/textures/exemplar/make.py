"""A seamless tile from the photo crops of one surface.

Highlights are found and light is evened out over all crops together, their colours are brought
to what most of them show, and a torus is quilted from them. Crops are enlarged photo patches; the
tile undoes the enlargement, so it covers more metres than a crop. A tile of more than 128 px, made
of two crops or more, covers twice as many metres with the same detail and repeats half as often.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.colour import as_uint8, clipped_share, delta_e_2000, median_colour, rgb_to_lab
from plan2scene.paint.shading import consensus, flatten, highlights, log_luma, unrest
from plan2scene.textures.exemplar.lattice import (
    CropLattice,
    Cut,
    faintness,
    find_pattern,
    grains_of,
    one_way,
    straightened,
)
from plan2scene.textures.exemplar.settings import EXEMPLAR
from plan2scene.textures.exemplar.things import oddness, things
from plan2scene.textures.quilting import Source, quilt
from plan2scene.textures.seams import with_calm_border


@dataclass(frozen=True, eq=False)
class ExemplarCrop:
    """A crop to learn a surface from."""

    image: np.ndarray  #: (128, 128, 3) uint8 sRGB
    size_m: float  #: side of the square that it covers; NaN when unknown
    sharpness: float  #: photo pixels per crop pixel; NaN when unknown
    detail: bytes = b""  #: JPEG at the photo's own resolution; empty where the crop holds as much
    plane: str = ""  #: name of the photo's plane that it was cut from; empty when unknown
    centre: tuple[float, float] = (0.0, 0.0)  #: its middle on that plane, metres (right, down)


def usable(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops that show a texture: neither burned out nor enlarged beyond use."""
    return [
        crop
        for crop in crops
        if not crop.sharpness < EXEMPLAR.least_sharp
        and clipped_share(crop.image) < EXEMPLAR.most_spoiled
    ]


def alike(crops: Sequence[ExemplarCrop], tone: np.ndarray | None = None) -> list[ExemplarCrop]:
    """Return the crops that have nearly the colour of the crop nearest to `tone` (3,), sRGB.

    Crops of one surface may show different things: masks err, and a room may have two paints. A
    tile of fewer crops is better than one with a rug in its floor. Without a tone, crops are
    compared with the crop that is most like all others.
    """
    labs = np.stack([rgb_to_lab(median_colour(crop.image)) for crop in crops])
    apart = delta_e_2000(labs[:, None], labs[None])
    distance = apart.sum(axis=1) if tone is None else delta_e_2000(labs, rgb_to_lab(tone)[None])
    middle = int(distance.argmin())
    return [
        crop
        for crop, distance in zip(crops, apart[middle], strict=True)
        if distance <= EXEMPLAR.alike_de
    ]


def calm(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops except those that vary far more than the median crop (rugs, sun)."""
    unrests = np.array([unrest(crop.image) for crop in crops])
    restless, calm_share = EXEMPLAR.restless
    kept = (unrests < restless) | (np.median(unrests) > calm_share * unrests)
    return [crop for crop, is_so in zip(crops, kept, strict=True) if is_so]


def blur_octaves(crops: Sequence[ExemplarCrop]) -> np.ndarray:
    """Return how many octaves (n,) fewer photo pixels per metre each crop has than the best one."""
    detail = np.array([crop.sharpness / crop.size_m for crop in crops], dtype=np.float64)
    detail = np.where(np.isfinite(detail) & (detail > 0), detail, np.nan)
    if np.isnan(detail).all():
        return np.zeros(len(crops))
    return np.nan_to_num(np.log2(np.nanmax(detail) / detail))


def sharper(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops except those that are far blurrier than the best few."""
    behind = blur_octaves(crops)
    if len(crops) <= EXEMPLAR.enough_sharp:
        return list(crops)
    limit = float(np.sort(behind)[EXEMPLAR.enough_sharp - 1]) + EXEMPLAR.few_octaves
    return [crop for crop, octaves in zip(crops, behind, strict=True) if octaves <= limit]


def enlarged(image: np.ndarray, size_px: int) -> np.ndarray:
    """Return a periodic (s, s, 3) image at `size_px`, still periodic (cubic interpolation)."""
    if image.shape[0] == size_px:
        return image
    pad = 8
    side = image.shape[0]
    wide = np.pad(image, ((pad, pad), (pad, pad), (0, 0)), mode="wrap").astype(np.float32)
    position = (np.arange(size_px) + 0.5) * side / size_px - 0.5 + pad
    across, down = np.meshgrid(position.astype(np.float32), position.astype(np.float32))
    if size_px < side:
        wide = cv2.GaussianBlur(wide, (0, 0), 0.45 * side / size_px)
    return cv2.remap(wide, across, down, cv2.INTER_CUBIC)


def toned(image: np.ndarray, tone: np.ndarray) -> np.ndarray:
    """Return an sRGB image in [0, 1] scaled so that its median colour is `tone`, (3,)."""
    median = np.median(image.reshape(-1, 3), axis=0)
    return np.clip(image * (tone / np.maximum(median, 1 / 255)), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Exemplar:
    """A tile made of crops."""

    image: np.ndarray  #: (s, s, 3) uint8 sRGB, repeats in both directions
    size_m: float  #: metres that its side covers; NaN when no crop has a known scale
    crops: tuple[int, ...]  #: indices of the crops that it was made of
    pattern: Pattern  #: what it was quilted from


@dataclass(frozen=True, eq=False)
class Pattern:
    """Crops of one surface brought to one light, colour, direction and lattice."""

    crops: list[ExemplarCrop]  #: those that show the surface
    flat: np.ndarray  #: (n, s, s, 3) float, under even light and turned one way
    masks: np.ndarray  #: (n, s, s) bool, spoiled pixels
    turned: np.ndarray  #: (n,) bool, which crops were turned by 90 degrees (``np.rot90``)
    colour: np.ndarray  #: (3,) float, the colour that they agree on, sRGB in [0, 1]
    order: list[int]  #: indices of the crops that may be used, the best first
    sides: np.ndarray  #: (n,) float, sides of the crops over the side of a tile of `size_m`
    size_m: float  #: side of that tile, metres; NaN when no crop has a known scale
    lattices: list[CropLattice]
    cut: Cut
    work_px: int  #: side of the torus that its tile is quilted on

    def source(self, k: int, work: int) -> Source:
        """Return crop `k` straightened for a tile of `work` px that shows the cut."""
        crop = self.flat[k], self.masks[k], float(self.sides[k])
        return straightened(*crop, self.lattices[k], self.cut, work)


def find_surface(
    crops: Sequence[ExemplarCrop],
    *,
    size_px: int,
    tone: np.ndarray | None = None,
    plain: bool = False,
) -> Pattern | None:
    """Return the pattern of the surface that `crops` show.

    None when all crops are too poor. Parameters as in :func:`make_exemplar`.
    """
    good = usable(crops)
    if not good:
        return None
    good = sharper(calm(alike(good, tone)))
    work = work_size(size_px, len(good))
    flat, masks, colour, faults = _evened(good)
    luma = log_luma(flat)
    grains = grains_of(luma, masks)
    faults = (
        faults
        + EXEMPLAR.faint * faintness(luma, masks, grains)
        + EXEMPLAR.odd * oddness(luma, masks)
    )
    flat, masks, turned = one_way(flat, masks, grains)
    sides, size_m = tile_scale(good, work / EXEMPLAR.work_px)
    known = np.isfinite([crop.size_m for crop in good]).all()
    lattices, cut, fits = find_pattern(flat, masks, sides, known=bool(known))
    if plain and not (cut.columns or cut.rows):
        masks = masks | things(log_luma(flat), masks)
    order = [int(k) for k in np.argsort(faults, kind="stable")]
    large = [k for k in order if fits[k] and sides[k] * work >= EXEMPLAR.smallest_px]
    order = large or [int(sides.argmax())]
    return Pattern(
        list(good), flat, masks, turned, colour, order, sides, size_m, lattices, cut, work
    )


def make_exemplar(
    crops: Sequence[ExemplarCrop],
    *,
    size_px: int,
    tone: np.ndarray | None = None,
    plain: bool = False,
) -> Exemplar | None:
    """Return a seamless tile of the surface that `crops` show; None when all are too poor.

    Crops may have any scale; those of unknown scale get the median one. `tone` (3,) is the colour
    that the surface is known to have, sRGB in [0, 1]: it tells which crops show the surface.
    `plain`: the surface is known to have no spots of its own (plaster), so small things on it,
    such as outlets and switches, are left out. The same crops and size give the same bytes.
    """
    pattern = find_surface(crops, size_px=size_px, tone=tone, plain=plain)
    if pattern is None:
        return None
    cut, best = pattern.cut, pattern.order[: EXEMPLAR.max_crops]
    used = [pattern.crops[k] for k in best]
    sources = [pattern.source(k, pattern.work_px) for k in best]
    canvas = quilt(sources, pattern.work_px, (cut.columns, cut.rows))
    image = with_calm_border(as_uint8(toned(canvas.solve(), pattern.colour)))
    return Exemplar(
        as_uint8(enlarged(image / 255.0, size_px)),
        pattern.size_m * float(np.sqrt(cut.wide * cut.high)),  # a square as large as the cut
        tuple(i for i, crop in enumerate(crops) if any(crop is own for own in used)),
        pattern,
    )


def _evened(crops: Sequence[ExemplarCrop]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return evened crops (n, s, s, 3), spoiled pixels (n, s, s), colour (3,) and faults (n,)."""
    images = np.stack([crop.image for crop in crops]).astype(np.float64) / 255.0
    masks = highlights(images)
    flat = flatten(images, masks)
    tones = np.stack([np.median(i[~m], axis=0) for i, m in zip(flat, masks, strict=True)])
    # Crops whose light needed the least repair are the best: they decide the brightness.
    repair = np.log((images.mean(axis=3) + 0.02) / (flat.mean(axis=3) + 0.02)).std(axis=(1, 2))
    tone = consensus(tones, repair)
    flat = np.clip(flat * (tone / np.maximum(tones, 1 / 255))[:, None, None, :], 0.0, 1.0)
    spoiled = masks.mean(axis=(1, 2))
    return flat, masks, tone, 2.0 * spoiled + repair + EXEMPLAR.blur * blur_octaves(crops)


def work_size(size_px: int, crops: int) -> int:
    """Return the side in pixels of the torus that a tile of `size_px` is quilted on.

    Larger tiles are enlarged from it, because crops hold no more detail. One crop alone cannot
    cover a larger torus.
    """
    return 2 * EXEMPLAR.work_px if size_px > EXEMPLAR.work_px and crops >= 2 else EXEMPLAR.work_px


def tile_scale(crops: Sequence[ExemplarCrop], extent: float = 1.0) -> tuple[np.ndarray, float]:
    """Return each crop's side over the tile's, (n,) at most 1, and the tile's side in metres.

    `extent` multiplies the metres that the crops have photo pixels for.
    """
    sides = np.array([crop.size_m for crop in crops], dtype=np.float64)
    sharp = np.array([crop.sharpness for crop in crops], dtype=np.float64)
    known = np.isfinite(sides)
    usual = float(np.median(sides[known])) if known.any() else 1.0
    sides = np.where(known, sides, usual)
    sharp = np.clip(np.where(np.isfinite(sharp), sharp, 1.0), 1.0 / EXEMPLAR.largest, 1.0)
    size = max(float(np.median(sides / sharp)), float(sides.max())) * extent
    return sides / size, size if known.any() else float("nan")
