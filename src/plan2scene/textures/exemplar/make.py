"""A seamless tile from the photo crops of one surface.

Highlights are found and light is evened out over all crops together, their colours are brought
to what most of them show, and a torus is quilted from them. The tile covers as many metres as
photo pixels of the crops fill: crops are enlarged photo patches, so it is larger than a crop. A
tile of 256 px or more covers twice as many metres with the same detail and repeats half as often.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.colour import as_uint8, clipped_share, delta_e_2000, median_colour, rgb_to_lab
from plan2scene.textures.exemplar.grain import faintness, grains_of, one_way
from plan2scene.textures.exemplar.lattice import CropLattice
from plan2scene.textures.exemplar.light import flatten, highlights, log_luma
from plan2scene.textures.exemplar.quilt import Source, quilt
from plan2scene.textures.exemplar.straighten import Cut, find_pattern, straightened
from plan2scene.textures.exemplar.things import oddness
from plan2scene.textures.exemplar.tone import consensus, enlarged, toned
from plan2scene.textures.seams import with_calm_border

#: Side of the torus in pixels for tiles of up to this size; larger ones get twice as much.
WORK_PX = 128
#: Crops that take part, the best first.
MAX_CROPS = 10
_LARGEST = 2.0  # side of the tile over the side of a crop
_LEAST_SHARP = 0.2  # photo pixels per crop pixel under which a crop shows no texture
_MOST_SPOILED = 0.5  # share of burned-out or masked pixels from which a crop is useless
_ALIKE_DE = 20.0  # CIEDE2000 beyond which crops are of different things; light gives less
_SMALLEST_PX = 32  # crops that fill less of the tile only make seams
_BLUR = 0.1  # what an octave fewer photo pixels a metre weighs, in log repair of the light
_FAINT = 0.2  # what a pattern e times fainter than the better ones weighs
_ODD = 0.5  # what things e times stronger than a plain surface's pattern weigh
_FEW_OCTAVES = 1.0  # crops blurred by more than this against the better ones are left out
_ENOUGH = 3  # where so many are sharper


@dataclass(frozen=True, eq=False)
class ExemplarCrop:
    """A crop to learn a surface from.

    Attributes
    ----------
    image : (128, 128, 3) uint8
        sRGB.
    size_m : float
        Side of the square that it covers; NaN when unknown.
    sharpness : float
        Photo pixels per crop pixel; NaN when unknown.
    detail : bytes
        JPEG at the photo's own resolution; empty where the crop holds as much.
    plane : str
        Name of the photo's plane that it was cut from; empty when unknown.
    centre : (float, float)
        Its middle on that plane, metres (right, down).
    """

    image: np.ndarray
    size_m: float
    sharpness: float
    detail: bytes = b""
    plane: str = ""
    centre: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Exemplar:
    """A tile made of crops.

    Attributes
    ----------
    image : (s, s, 3) uint8
        sRGB, repeats in both directions.
    size_m : float
        Metres that it covers; NaN when no crop knows its scale.
    crops : tuple of int
        Which of the given crops it was made of.
    periods : (int, int)
        How often its pattern repeats in it along x and y; 0 where it has no period.
    period_m : (float, float)
        Its periods in metres (in sides of the median crop where no scale is known); NaN where it
        has none.
    pattern : Pattern
        What it was quilted from.
    """

    image: np.ndarray
    size_m: float
    crops: tuple[int, ...]
    periods: tuple[int, int]
    period_m: tuple[float, float]
    pattern: Pattern


def usable(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops that show a texture: neither burned out nor enlarged beyond use."""
    return [
        crop
        for crop in crops
        if not crop.sharpness < _LEAST_SHARP and clipped_share(crop.image) < _MOST_SPOILED
    ]


def alike(crops: Sequence[ExemplarCrop], tone: np.ndarray | None = None) -> list[ExemplarCrop]:
    """Return the crops whose colour is near that of the one nearest to `tone`.

    Where masks err, or the walls of a room are of two paints, crops of one surface show different
    things; patches of a rug in a floor are worse than fewer crops. Without a tone (3,), sRGB in
    [0, 1], the crop most like all others decides.
    """
    labs = np.stack([rgb_to_lab(median_colour(crop.image)) for crop in crops])
    apart = delta_e_2000(labs[:, None], labs[None])
    far = apart.sum(axis=1) if tone is None else delta_e_2000(labs, rgb_to_lab(tone)[None])
    middle = int(far.argmin())
    return [crop for crop, far in zip(crops, apart[middle], strict=True) if far <= _ALIKE_DE]


def blur_octaves(crops: Sequence[ExemplarCrop]) -> np.ndarray:
    """Return by how many octaves crops have fewer photo pixels a metre than the best, (n,)."""
    detail = np.array([crop.sharpness / crop.size_m for crop in crops], dtype=np.float64)
    detail = np.where(np.isfinite(detail) & (detail > 0), detail, np.nan)
    if np.isnan(detail).all():
        return np.zeros(len(crops))
    return np.nan_to_num(np.log2(np.nanmax(detail) / detail))


def sharper(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops without those far blurrier than the `_ENOUGH` best: near ones show more."""
    behind = blur_octaves(crops)
    if len(crops) <= _ENOUGH:
        return list(crops)
    limit = float(np.sort(behind)[_ENOUGH - 1]) + _FEW_OCTAVES
    return [crop for crop, octaves in zip(crops, behind, strict=True) if octaves <= limit]


@dataclass(frozen=True, eq=False)
class Pattern:
    """Crops of one surface brought to one light, colour, direction and lattice.

    Attributes
    ----------
    crops : list of ExemplarCrop
        Those that show the surface.
    flat, masks : (n, s, s, 3) float, (n, s, s) bool
        Under even light and turned one way; spoiled pixels.
    turned : (n,) bool
        Which crops were turned by 90 degrees (``np.rot90``).
    colour : (3,) float
        What they agree on, sRGB in [0, 1].
    order : list of int
        The crops that may take part, the best first.
    sides : (n,) float
        Sides of the crops in sides of a tile of `size_m`.
    size_m : float
        NaN when no crop knows its scale.
    lattices : list of CropLattice
    cut : Cut
    """

    crops: list[ExemplarCrop]
    flat: np.ndarray
    masks: np.ndarray
    turned: np.ndarray
    colour: np.ndarray
    order: list[int]
    sides: np.ndarray
    size_m: float
    lattices: list[CropLattice]
    cut: Cut

    @property
    def used(self) -> list[ExemplarCrop]:
        """Return the crops of a tile, the best first."""
        return [self.crops[k] for k in self.order[:MAX_CROPS]]

    @property
    def covered_m(self) -> float:
        """Return the side in metres of a square as large as the cut."""
        return self.size_m * float(np.sqrt(self.cut.wide * self.cut.high))

    def source(self, k: int, work: int) -> Source:
        """Return crop `k` straightened for a tile of `work` px that holds the cut."""
        crop = self.flat[k], self.masks[k], float(self.sides[k])
        return straightened(*crop, self.lattices[k], self.cut, work)


def find_surface(
    crops: Sequence[ExemplarCrop], *, size_px: int, tone: np.ndarray | None = None
) -> tuple[Pattern, int] | None:
    """Return the pattern of the surface that `crops` show, and the side of its torus in pixels.

    None when all crops are too poor. Parameters as of :func:`make_exemplar`.
    """
    good = usable(crops)
    if not good:
        return None
    good = sharper(alike(good, tone))
    work = work_size(size_px, len(good))
    flat, masks, colour, faults = _evened(good)
    luma = log_luma(flat)
    grains = grains_of(luma, masks)
    faults = faults + _FAINT * faintness(luma, masks, grains) + _ODD * oddness(luma, masks)
    flat, masks, turned = one_way(flat, masks, grains)
    sides, size_m = tile_scale(good, work / WORK_PX)
    known = np.isfinite([crop.size_m for crop in good]).all()
    lattices, cut, fits = find_pattern(flat, masks, sides, known=bool(known))
    order = [int(k) for k in np.argsort(faults, kind="stable")]
    large = [k for k in order if fits[k] and sides[k] * work >= _SMALLEST_PX]
    order = large or [int(sides.argmax())]
    return Pattern(good, flat, masks, turned, colour, order, sides, size_m, lattices, cut), work


def make_exemplar(
    crops: Sequence[ExemplarCrop], *, size_px: int, tone: np.ndarray | None = None
) -> Exemplar | None:
    """Return a seamless tile of the surface that `crops` show; None when all are too poor.

    Nothing is drawn: same crops and size, same bytes.

    Parameters
    ----------
    crops : sequence of ExemplarCrop
        Crops of one surface, of any scales; those of unknown scale count as the median one.
    size_px : int
        Side of the tile in pixels.
    tone : (3,) float, optional
        Colour that the surface is known to have, sRGB in [0, 1]: says which crops are of it.
    """
    found = find_surface(crops, size_px=size_px, tone=tone)
    if found is None:
        return None
    pattern, work = found
    cut, size_m = pattern.cut, pattern.size_m
    canvas = quilt([pattern.source(k, work) for k in pattern.order[:MAX_CROPS]], work)
    image = with_calm_border(as_uint8(toned(canvas.solve(), pattern.colour)))
    return Exemplar(
        as_uint8(enlarged(image / 255.0, size_px)),
        pattern.covered_m,
        tuple(i for i, crop in enumerate(crops) if any(crop is own for own in pattern.used)),
        (cut.columns, cut.rows),
        (
            size_m * cut.wide / cut.columns if cut.columns else float("nan"),
            size_m * cut.high / cut.rows if cut.rows else float("nan"),
        ),
        pattern,
    )


def _evened(
    crops: Sequence[ExemplarCrop],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return crops of one colour under even light, spoiled pixels, the colour, faults (n,)."""
    images = np.stack([crop.image for crop in crops]).astype(np.float64) / 255.0
    masks = highlights(images)
    flat = flatten(images, masks)
    tones = np.stack([np.median(i[~m], axis=0) for i, m in zip(flat, masks, strict=True)])
    # Those that needed the least repair of their light are the best, and say how bright it is.
    repair = np.log((images.mean(axis=3) + 0.02) / (flat.mean(axis=3) + 0.02)).std(axis=(1, 2))
    tone = consensus(tones, repair)
    flat = np.clip(flat * (tone / np.maximum(tones, 1 / 255))[:, None, None, :], 0.0, 1.0)
    spoiled = masks.mean(axis=(1, 2))
    return flat, masks, tone, 2.0 * spoiled + repair + _BLUR * blur_octaves(crops)


def work_size(size_px: int, crops: int) -> int:
    """Return the side in pixels of the torus that a tile of `size_px` is quilted on.

    A tile of more pixels than it has is enlarged: crops hold no more detail. One crop alone has
    nothing to cover more metres with than itself.
    """
    return 2 * WORK_PX if size_px > WORK_PX and crops >= 2 else WORK_PX


def tile_scale(crops: Sequence[ExemplarCrop], extent: float = 1.0) -> tuple[np.ndarray, float]:
    """Return each crop's side over the tile's, (n,) at most 1, and the tile's side in metres.

    `extent`: how many times the metres that crops have pixels for it covers.
    """
    sides = np.array([crop.size_m for crop in crops], dtype=np.float64)
    sharp = np.array([crop.sharpness for crop in crops], dtype=np.float64)
    known = np.isfinite(sides)
    usual = float(np.median(sides[known])) if known.any() else 1.0
    sides = np.where(known, sides, usual)
    sharp = np.clip(np.where(np.isfinite(sharp), sharp, 1.0), 1.0 / _LARGEST, 1.0)
    size = max(float(np.median(sides / sharp)), float(sides.max())) * extent
    return sides / size, size if known.any() else float("nan")
