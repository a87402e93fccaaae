"""Filter of windows: which of them show their surface and nothing else.

The paper draws windows anywhere inside a mask. But masks of real photos have uncertain borders, and
their surfaces have highlights, shadows and things in front. Each test here is a pure function of
the window, its plane or its photo. A window that fails gets a reason, and crops.parquet leaves it
out if the surface has better ones. Colours are CIE L*a*b* (D65), luminance is linear.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.colour import (
    CLIPPED_LEVELS,
    LUMINANCE,
    clipped_share,
    linear_to_srgb,
    median_colour,
    rgb_to_lab,
    srgb_to_linear,
)
from plan2scene.paint.shading import smooth_field, unrest
from plan2scene.photos.crops.sampling import CROP_PX, Candidate, Crop, Judge, Reason, Verdict
from plan2scene.photos.planes.rectification import RectifiedPlane


@dataclass(frozen=True)
class FilterSettings:
    """Constants of the filter of windows.

    Source, where a field names no other: 208 windows of real photos that were judged by eye
    (``benchmarks/windows.py``).
    """

    # Borders.
    #: Margin between windows and the mask's border, share of the photo's width.
    margin_share: float = 0.01
    #: The same where the photo shows no edge at the border, so that its position is uncertain.
    blind_margin_share: float = 0.025
    #: Least gradient of an edge, grey levels per pixel (Sobel on a photo blurred by 1 px).
    edge_gradient: float = 6.0

    # Highlights.
    #: Largest share of overexposed or black pixels of a good window.
    clipped_share: float = 0.001

    # Things that stand out among the mean colours of a crop's blocks.
    #: Small blocks, then large ones, which mainly compare chroma, since light changes it little.
    #: Each: blocks along a side; weight of L*; least distance of an outlier (L*a*b*); multiple of
    #: the blocks' spread that is added to it; least sum, over the blocks of a thing, of distance
    #: divided by this outlier distance.
    block_scales: tuple[tuple[int, float, float, float, float], ...] = (
        (32, 1.0, 3.0, 5.0, 2.5),
        (8, 0.3, 2.0, 3.0, 3.0),
    )
    #: Least share of the outliers (by distance) in the largest piece; patterns are scattered.
    one_piece: float = 0.6
    #: Least width of a thing on a floor, in small blocks: joints are thinner.
    thing_blocks: int = 3
    #: A window is unlike its plane where its mean colour is farther from the median over all
    #: windows than this distance (L*a*b*, L* halved) plus this multiple of their spread.
    window_limit: float = 8.0
    window_spread: float = 5.0

    # Shadows.
    #: Least range of log luminance in a crop with a shadow's edge, after removing smooth shading.
    shadow_step: float = 0.2
    #: Least change of log luminance over an eighth of a crop for an edge; less is shading.
    edge_step: float = 0.12
    shadow_chroma: float = 6.0  #: difference in a*b* above which a step is a thing, not a shadow
    step_pieces: int = 3  #: largest number of pieces of a window with one step; patterns have more
    #: A step counts if it explains this share of the variance of the crop's log luminance, or is
    #: this many times the fine texture's standard deviation; planks of two shades do neither.
    step_share: float = 0.75
    step_textures: float = 5.0

    # Sharpness.
    #: A crop is sharp with this many photo pixels per crop pixel, or (for any size of the window)
    #: with this many photo pixels per metre along the view, the direction with the fewest.
    min_sharpness: float = 0.5
    min_density: float = 100.0
    #: Least angle between view and plane, degrees. Flatter views down to the second angle are good,
    #: too, if they have this many photo pixels per crop pixel along the view.
    min_grazing_deg: float = 20.0
    least_grazing_deg: float = 16.0
    flat_sharpness: float = 0.45

    # The photos of a surface against each other.
    #: Groups of a surface's windows farther than this (L*a*b*, L* halved) from the colour of the
    #: majority show something else.
    group_limit: float = 10.0
    majority: float = 0.6  #: least share of a surface's windows that can outvote the rest
    #: (least variation, share): windows that vary by at least the first (L*a*b*, :func:`unrest`)
    #: show pictures or shelves on a wall, a patterned rug on a floor, if another group of the
    #: surface varies by at most the second times that. Rendered walls of the demo vary by 2 at
    #: most, real panelling by 2 to 7, framed pictures by 14; floors of six real homes by 5 at most,
    #: two rugs there by 9 and 12.
    restless_wall: tuple[float, float] = (10.0, 0.4)
    restless_floor: tuple[float, float] = (7.0, 0.5)
    looked_at: int = 5  #: largest number of windows of a group whose variation is measured


FILTER = FilterSettings()


def unclipped(image: np.ndarray) -> np.ndarray:
    """Return the pixels (h, w) bool of a (h, w, 3) uint8 sRGB image that are not clipped."""
    low, high = CLIPPED_LEVELS
    red, green, blue = cv2.split(image)
    brightest = np.maximum(np.maximum(red, green), blue)  # thirty times as fast as max(axis=2)
    return np.asarray((brightest > low) & (brightest < high))


def strong_edges(image: np.ndarray) -> np.ndarray:
    """Return which pixels (h, w) bool of a photo (h, w, 3) uint8 sRGB lie near an edge.

    Near is within half of `FILTER.margin_share`: a mask's border may be so far from its edge.
    """
    grey = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), (0, 0), 1.0)
    slope = [cv2.Sobel(grey, cv2.CV_32F, dx, 1 - dx, scale=0.125) for dx in (1, 0)]
    reach = 2 * round(FILTER.margin_share * image.shape[1] / 2) + 1
    near = cv2.dilate(np.hypot(*slope), np.ones((reach, reach), np.uint8))
    return np.asarray(near >= FILTER.edge_gradient)


def inner_mask(mask: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the pixels (h, w) bool of a mask that are far enough from its border.

    The margin is smaller where the border lies on `edges`, the photo's :func:`strong_edges`. The
    photo's frame does not count as a border.
    """
    margin, blind_margin = (
        share * mask.shape[1] for share in (FILTER.margin_share, FILTER.blind_margin_share)
    )
    padded = cv2.copyMakeBorder(mask.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    border = (cv2.erode(padded, np.ones((3, 3), np.uint8)) == 0)[1:-1, 1:-1] & mask
    blind = border & ~edges
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1]
    inner = mask & (distance > margin)
    if blind.any():
        to_blind = cv2.distanceTransform((~blind).astype(np.uint8), cv2.DIST_L2, 5)
        inner &= to_blind > blind_margin
    return inner


def judge_of(surface: str, *, inside: bool) -> Judge:
    """Return the judge of the windows of one plane of a surface (floor, wall, ceiling).

    `inside` tells whether the windows keep off the plane's border.
    """
    typical: dict[tuple[int, int, int], tuple[np.ndarray, float]] = {}

    def judge(rectified: RectifiedPlane, row: int, column: int, side: int, crop: Crop) -> Verdict:
        key = (*rectified.mask.shape, side)
        if key not in typical:
            typical[key] = window_colours(rectified, side)
        patch = rectified.image[row : row + side, column : column + side]
        against = {
            Reason.CLUTTER: is_unlike(patch, *typical[key]),
            Reason.BORDER: not inside,
            # Pictures may hang as regularly as a pattern: smaller windows show the wall between.
            Reason.RESTLESS: surface == "wall" and unrest(crop.image) >= FILTER.restless_wall[0],
            Reason.BLURRED: is_blurred(crop),
            Reason.OBLIQUE: is_oblique(crop),
        }
        own = (reason for reason, holds in against.items() if holds)
        seen = image_reasons(crop.image, joints=surface == "floor")
        return Verdict.of([*seen, *own], crop.sharpness)

    return judge


def with_reason(candidate: Candidate, reason: Reason) -> Candidate:
    """Return a candidate with one more reason against it."""
    reasons = (*candidate.verdict.reasons, reason)
    return replace(candidate, verdict=Verdict.of(reasons, candidate.crop.sharpness))


def is_blurred(crop: Crop) -> bool:
    """Tell whether a crop has too few photo pixels, both per crop pixel and per metre."""
    along = crop.sharpness * CROP_PX / crop.size_m * flattening(crop)
    return crop.sharpness < FILTER.min_sharpness and along < FILTER.min_density


def is_oblique(crop: Crop) -> bool:
    """Tell whether a crop is seen at so flat an angle that it is smeared along the view."""
    if crop.grazing_deg >= FILTER.min_grazing_deg:
        return False
    return (
        crop.grazing_deg < FILTER.least_grazing_deg
        or crop.sharpness * flattening(crop) < FILTER.flat_sharpness
    )


def flattening(crop: Crop) -> float:
    """Return a crop's density of photo pixels along the view over the mean of both directions."""
    return float(np.sqrt(np.sin(np.radians(crop.grazing_deg))))


def image_reasons(image: np.ndarray, *, joints: bool = False) -> list[Reason]:
    """Return what is wrong with a crop (n, n, 3) uint8 sRGB by itself: highlight, clutter, ...

    `joints` is passed to :func:`has_object`.
    """
    reasons = []
    if clipped_share(image, CLIPPED_LEVELS) > FILTER.clipped_share:
        reasons.append(Reason.HIGHLIGHT)
    if has_object(image, joints=joints):
        reasons.append(Reason.CLUTTER)
    step = step_of(image)
    if step is not None and step not in reasons:
        reasons.append(step)
    return reasons


def has_object(image: np.ndarray, *, joints: bool = False) -> bool:
    """Tell whether connected blocks of a crop differ from the rest.

    Smooth shading is removed first. Patterns are no objects: they raise the spread of all blocks,
    or their outliers are in many pieces. With `joints` thin outliers count as a pattern, too.
    """
    for blocks, weight, limit, multiple, thing in FILTER.block_scales:
        small = cv2.resize(image, (blocks, blocks), interpolation=cv2.INTER_AREA)
        lab = rgb_to_lab(small / 255.0)
        lab[..., 0] = weight * (lab[..., 0] - smooth_field(lab[..., 0]))
        away = np.linalg.norm(lab - np.median(lab, axis=(0, 1)), axis=-1)
        beyond = away / (limit + multiple * float(np.median(away)))
        beyond[beyond <= 1.0] = 0.0
        if joints and blocks == FILTER.block_scales[0][0]:
            thick = np.ones((FILTER.thing_blocks, FILTER.thing_blocks), np.uint8)
            beyond *= cv2.morphologyEx((beyond > 0).astype(np.uint8), cv2.MORPH_OPEN, thick)
        _, pieces = cv2.connectedComponents((beyond > 0).astype(np.uint8), connectivity=8)
        sums = np.bincount(pieces.ravel(), weights=beyond.ravel())
        if sums.max() >= max(thing, FILTER.one_piece * sums.sum()):
            return True
    return False


def step_of(image: np.ndarray) -> Reason | None:
    """Return `SHADOW` or `CLUTTER` if one step of luminance divides a crop, else None."""
    small = cv2.resize(image, (64, 64), interpolation=cv2.INTER_AREA)
    smooth = cv2.GaussianBlur(small, (0, 0), 2.0)
    fine, log = (np.log(np.maximum(srgb_to_linear(i) @ LUMINANCE, 1e-3)) for i in (small, smooth))
    rest = log - smooth_field(log)
    if np.percentile(rest, 97) - np.percentile(rest, 3) < FILTER.shadow_step:
        return None
    slopes = [log[:, 8:] - log[:, :-8], log[8:] - log[:-8]]
    if max(np.percentile(np.abs(slope), 98) for slope in slopes) < FILTER.edge_step:
        return None
    scaled = cv2.normalize(log, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    _, bright = cv2.threshold(scaled, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    areas = []
    for side in (bright, 1 - bright):
        stats = cv2.connectedComponentsWithStats(side, connectivity=4)[2]
        areas += [area for area in stats[1:, cv2.CC_STAT_AREA] if area >= 0.02 * side.size]
    if len(areas) > FILTER.step_pieces or sum(areas) < 0.9 * bright.size or bright.std() == 0:
        return None
    share = bright.mean()
    step = log[bright > 0].mean() - log[bright == 0].mean()
    texture = (fine - cv2.GaussianBlur(fine, (0, 0), 4.0)).std()
    explained = share * (1 - share) * step**2 / log.var()
    if explained < FILTER.step_share and step < FILTER.step_textures * texture:
        return None
    lab = rgb_to_lab(smooth / 255.0)
    ab = [np.median(lab[side > 0][:, 1:], axis=0) for side in (bright, 1 - bright)]
    return Reason.CLUTTER if np.linalg.norm(ab[0] - ab[1]) > FILTER.shadow_chroma else Reason.SHADOW


def window_colours(rectified: RectifiedPlane, side: int) -> tuple[np.ndarray, float]:
    """Return the median (3,), with L* halved, of the colours of a plane's windows, and the spread.

    A window's colour is its mean colour. The spread is the median distance from the median.
    """
    rows, columns = np.nonzero(rectified.places(side))
    pick = slice(None, None, max(1, len(rows) // 400))
    sums = cv2.integral(rectified.image, sdepth=cv2.CV_64F)
    r, c = rows[pick], columns[pick]
    mean = (sums[r + side, c + side] - sums[r, c + side] - sums[r + side, c] + sums[r, c]) / side**2
    lab = rgb_to_lab(mean / 255.0) * np.array([0.5, 1.0, 1.0])
    middle = np.median(lab, axis=0)
    return middle, float(np.median(np.linalg.norm(lab - middle, axis=1)))


def is_unlike(patch: np.ndarray, middle: np.ndarray, spread: float) -> bool:
    """Tell whether a window's mean colour is far from the result of :func:`window_colours`."""
    lab = rgb_to_lab(patch.reshape(-1, 3).mean(axis=0) / 255.0) * np.array([0.5, 1.0, 1.0])
    return bool(np.linalg.norm(lab - middle) > FILTER.window_limit + FILTER.window_spread * spread)


def outvoted(colours: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Tell which groups of windows of one surface look unlike most of the others.

    `colours` (n, 3) are the L*a*b* of each group (a plane of a photo) without the photo's light,
    `weights` (n,) the number of its windows. Returns (n,) bool, all False where no colour has a
    clear majority. This finds, for example, a wardrobe that was labelled as a wall.
    """
    points = colours * np.array([0.5, 1.0, 1.0])
    distance = np.linalg.norm(points[:, None] - points[None], axis=-1)
    support = (distance <= FILTER.group_limit) @ weights
    best = int(np.argmax(support))
    if support[best] < FILTER.majority * weights.sum():
        return np.zeros(len(colours), dtype=bool)
    return np.asarray(distance[best] > FILTER.group_limit)


def restless(unrests: np.ndarray, least: float, share: float) -> np.ndarray:
    """Tell which groups of windows of a room's walls or floor show things, (n,) bool.

    `unrests` (n,) is how much each group varies. A group shows things if it varies by at least
    `least` and the calmest group by at most `share` of that: wallpaper or tiles are on the room's
    other walls, too, but framed pictures hang on one.
    """
    return np.asarray((unrests.min() <= share * unrests) & (unrests >= least))


def mark_outvoted(
    candidates: Sequence[Candidate], lights: Mapping[str, np.ndarray]
) -> list[Candidate]:
    """Return the candidates of a house; those that their surface outvotes get `UNLIKE`.

    Windows without grave reasons vote, one group per plane of a photo. Each photo's light in
    `lights`, (3,) linear RGB, is divided out before colours are compared. Groups that show things
    in front of a wall or on a floor get `CLUTTER`.
    """
    groups: dict[tuple[str, str], dict[tuple[str, int], list[int]]] = {}
    for number, candidate in enumerate(candidates):
        if not candidate.verdict.grave:
            for room in candidate.rooms:
                planes = groups.setdefault((room, candidate.surface), {})
                planes.setdefault((candidate.photo, candidate.plane), []).append(number)
    result = list(candidates)
    for (_, surface), planes in groups.items():
        members = list(planes.values())
        colours = [
            np.median([_colour(candidates[number], lights) for number in group], axis=0)
            for group in members
        ]
        weights = np.array([len(group) for group in members], dtype=float)
        flags_by_reason = {Reason.UNLIKE: outvoted(np.stack(colours), weights)}
        limits = {"wall": FILTER.restless_wall, "floor": FILTER.restless_floor}.get(surface)
        if limits is not None:
            looks = [[candidates[n].crop.image for n in g[: FILTER.looked_at]] for g in members]
            flags_by_reason[Reason.CLUTTER] = restless(
                np.array([np.median([unrest(image) for image in images]) for images in looks]),
                *limits,
            )
        for reason, these in flags_by_reason.items():
            for number in (
                n for group, is_so in zip(members, these, strict=True) if is_so for n in group
            ):
                result[number] = with_reason(result[number], reason)
    return result


def _colour(candidate: Candidate, lights: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the L*a*b* (3,) of a crop's median colour without its photo's light."""
    linear = srgb_to_linear(median_colour(candidate.crop.image))
    linear = linear / lights.get(candidate.photo, np.ones(3))
    return rgb_to_lab(linear_to_srgb(np.minimum(linear, 1.0)))
