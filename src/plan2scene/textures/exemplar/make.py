"""A seamless tile from the photo crops of one surface.

Highlights are found and light is evened out over all crops together, their colours are brought
to what most of them show, and a torus is quilted from them. The tile covers as many metres as
photo pixels of the crops fill: crops are enlarged photo patches, so it is larger than a crop. A
tile of 256 px or more covers twice as many metres with the same detail and repeats half as often.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.colour import as_uint8
from plan2scene.paint.shading import consensus, flatten, highlights, log_luma
from plan2scene.textures.exemplar.choice import ExemplarCrop, alike, blur_octaves, sharper, usable
from plan2scene.textures.exemplar.corner import SQUARES, as_detail, completed
from plan2scene.textures.exemplar.grain import faintness, grains_of, one_way
from plan2scene.textures.exemplar.lattice import CropLattice, whole_periods
from plan2scene.textures.exemplar.straighten import Cut, find_pattern, straightened
from plan2scene.textures.exemplar.things import oddness, things
from plan2scene.textures.exemplar.tone import enlarged, toned
from plan2scene.textures.quilting import Source, quilt
from plan2scene.textures.seams import with_calm_border

#: Side of the torus in pixels for tiles of up to this size; larger ones get twice as much.
WORK_PX = 128
#: Crops that take part, the best first.
MAX_CROPS = 10
_LARGEST = 2.0  # side of the tile over the side of a crop
_SMALLEST_PX = 32  # crops that fill less of the tile only make seams
_BLUR = 0.1  # what an octave fewer photo pixels a metre weighs, in log repair of the light
_FAINT = 0.2  # what a pattern e times fainter than the better ones weighs
_ODD = 0.5  # what things e times stronger than a plain surface's pattern weigh


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
    completed : ExemplarCrop, optional
        The crop that the only one of the pattern was made of: it showed no whole period.
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
    completed: ExemplarCrop | None = None

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
    crops: Sequence[ExemplarCrop],
    *,
    size_px: int,
    tone: np.ndarray | None = None,
    plain: bool = False,
) -> tuple[Pattern, int] | None:
    """Return the pattern of the surface that `crops` show, and the side of its torus in pixels.

    None when all crops are too poor. Parameters as of :func:`make_exemplar`.
    """
    good = usable(crops)
    if not good:
        return None
    good = sharper(alike(good, tone))
    pattern, work = _pattern(good, size_px, plain=plain)
    turned = zip(pattern.crops, pattern.turned, strict=True)
    images = [np.rot90(crop.image) if turn else crop.image for crop, turn in turned]
    corner = completed(images, pattern.flat, pattern.lattices, pattern.order, pattern.sides)
    if corner is None or not np.isfinite(pattern.size_m):
        return pattern, work
    own = pattern.crops[corner.crop]
    size_m = corner.side * pattern.size_m
    image = cv2.resize(corner.image, own.image.shape[1::-1], interpolation=cv2.INTER_AREA)
    sharpness = own.sharpness * size_m / own.size_m
    whole = ExemplarCrop(image, size_m, sharpness, as_detail(corner.image))
    pattern, work = _pattern([whole], size_px)
    period = 2.0 / SQUARES
    lattice = CropLattice(0.0, True, (period * image.shape[1],) * 2, (1.0, 1.0))
    cut = Cut(*whole_periods((period * float(pattern.sides[0]),) * 2))
    return replace(pattern, completed=own, lattices=[lattice], cut=cut), work


def _pattern(
    good: Sequence[ExemplarCrop], size_px: int, *, plain: bool = False
) -> tuple[Pattern, int]:
    """Return the pattern of good crops, and the side of its torus in pixels."""
    work = work_size(size_px, len(good))
    flat, masks, colour, faults = _evened(good)
    luma = log_luma(flat)
    grains = grains_of(luma, masks)
    faults = faults + _FAINT * faintness(luma, masks, grains) + _ODD * oddness(luma, masks)
    flat, masks, turned = one_way(flat, masks, grains)
    sides, size_m = tile_scale(good, work / WORK_PX)
    known = np.isfinite([crop.size_m for crop in good]).all()
    lattices, cut, fits = find_pattern(flat, masks, sides, known=bool(known))
    if plain and not (cut.columns or cut.rows):
        masks = masks | things(log_luma(flat), masks)
    order = [int(k) for k in np.argsort(faults, kind="stable")]
    large = [k for k in order if fits[k] and sides[k] * work >= _SMALLEST_PX]
    order = large or [int(sides.argmax())]
    return Pattern(
        list(good), flat, masks, turned, colour, order, sides, size_m, lattices, cut
    ), work


def make_exemplar(
    crops: Sequence[ExemplarCrop],
    *,
    size_px: int,
    tone: np.ndarray | None = None,
    plain: bool = False,
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
    plain : bool
        Whether the surface is known to have no spots of its own, as plaster: small things on it,
        outlets and switches, are left out.
    """
    found = find_surface(crops, size_px=size_px, tone=tone, plain=plain)
    if found is None:
        return None
    pattern, work = found
    cut, size_m = pattern.cut, pattern.size_m
    used = pattern.used if pattern.completed is None else [pattern.completed]
    sources = [pattern.source(k, work) for k in pattern.order[:MAX_CROPS]]
    canvas = quilt(sources, work, (cut.columns, cut.rows))
    image = with_calm_border(as_uint8(toned(canvas.solve(), pattern.colour)))
    return Exemplar(
        as_uint8(enlarged(image / 255.0, size_px)),
        pattern.covered_m,
        tuple(i for i, crop in enumerate(crops) if any(crop is own for own in used)),
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
