"""Filter of windows: which of them show their surface and nothing else.

The paper draws windows anywhere inside a mask. Masks of real photos have uncertain borders, and
what they cover has highlights, shadows and things in front. Each test here is a pure function of
the window, its plane or its photo; a window that fails gets a reason, and crops.parquet leaves it
out where the surface has better ones. Colours are CIE L*a*b* (D65), luminance is linear.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.colour import (
    CLIPPED_LEVELS,
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
    #: Margin to the mask's border, share of the photo's width.
    margin_share: float = 0.01
    #: The same where the photo shows no edge at the border, so that it may run anywhere.
    blind_margin_share: float = 0.025
    #: Grey levels per pixel (Sobel on a photo blurred by 1 px) that make an edge.
    edge_gradient: float = 6.0

    # Highlights.
    #: Largest share of burned out or black pixels of a window.
    clipped_share: float = 0.001

    # Things that stand out among the mean colours of a crop's blocks.
    #: Small blocks, then large ones, which look for colours, since light leaves those alone: blocks
    #: along a side, weight of L*, least distance of an outlier (L*a*b*), multiple of the blocks'
    #: own spread that is added to it, and the sum of distances (in those of an outlier) of a thing.
    block_scales: tuple[tuple[int, float, float, float, float], ...] = (
        (32, 1.0, 3.0, 5.0, 2.5),
        (8, 0.3, 2.0, 3.0, 3.0),
    )
    #: Share of all that stands out that a thing has in one piece; what patterns have is scattered.
    one_piece: float = 0.6
    #: Sides in small blocks of what is a thing on a floor: joints are thinner.
    thing_blocks: int = 3
    #: A window's mean colour is unlike those of all windows of the plane beyond this distance
    #: (L*a*b*, L* halved), plus this multiple of their spread.
    window_limit: float = 8.0
    window_spread: float = 5.0

    # Shadows.
    #: Step of log luminance, after smooth shading is taken away, that is a shadow's edge.
    shadow_step: float = 0.2
    #: Least change of log luminance over an eighth of a crop that is an edge, not shading.
    edge_step: float = 0.12
    shadow_chroma: float = 6.0  #: difference in a*b* above which a step is a thing, not a shadow
    step_pieces: int = 3  #: most pieces into which a step divides a window; patterns have more
    #: A shadow's edge explains this share of what a crop's log luminance varies by, or is this many
    #: times the fine texture's standard deviation; planks of two shades do neither.
    step_share: float = 0.75
    step_textures: float = 5.0

    # Sharpness.
    #: Least photo pixels per crop pixel of a good crop; or, since a window is the smaller the
    #: nearer its edge is, photo pixels per metre along the view, where they are fewest.
    min_sharpness: float = 0.5
    min_density: float = 100.0
    #: Least angle between view and plane, degrees; flatter views down to the second angle are as
    #: good while they have this many photo pixels along the view per crop pixel.
    min_grazing_deg: float = 20.0
    least_grazing_deg: float = 16.0
    flat_sharpness: float = 0.45

    # The photos of a surface against each other.
    #: Groups of a surface's windows farther than this from most of the others (L*a*b*, L* halved)
    #: are of something else.
    group_limit: float = 10.0
    majority: float = 0.6  #: least share of a surface's windows that can outvote the rest
    #: Windows of a wall that vary by at least this much (L*a*b*, :func:`unrest`) show pictures or
    #: shelves, those of a floor a patterned rug, where others of the room vary by less than this
    #: share of it. Rendered walls of the demo vary by 2 at most, real panelling by 2 to 7, framed
    #: pictures by 14; floors of six real homes by 5 at most, two rugs there by 9 and 12.
    restless_wall: tuple[float, float] = (10.0, 0.4)
    restless_floor: tuple[float, float] = (7.0, 0.5)
    looked_at: int = 5  #: windows of a group that are looked at


FILTER = FilterSettings()


def unclipped(image: np.ndarray) -> np.ndarray:
    """Return which pixels (h, w) bool of (h, w, 3) uint8 sRGB are neither black nor too bright."""
    low, high = CLIPPED_LEVELS
    red, green, blue = cv2.split(image)
    brightest = np.maximum(np.maximum(red, green), blue)  # thirty times as fast as max(axis=2)
    return np.asarray((brightest > low) & (brightest < high))


def strong_edges(image: np.ndarray) -> np.ndarray:
    """Return which pixels (h, w) bool of a photo (h, w, 3) uint8 sRGB lie by an edge.

    As near as the border of a mask may be to the edge that it follows.
    """
    grey = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), (0, 0), 1.0)
    slope = [cv2.Sobel(grey, cv2.CV_32F, dx, 1 - dx, scale=0.125) for dx in (1, 0)]
    reach = 2 * round(FILTER.margin_share * image.shape[1] / 2) + 1
    near = cv2.dilate(np.hypot(*slope), np.ones((reach, reach), np.uint8))
    return np.asarray(near >= FILTER.edge_gradient)


def inner_mask(mask: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the pixels (h, w) bool of a mask far enough from its border.

    The margin is less where `edges`, the photo's :func:`strong_edges`, are at the border. The
    photo's frame is no border.
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

    `inside` tells that they keep off its border.
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
            # Pictures may hang as regularly as a pattern: smaller windows show what is between.
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
    """Tell whether a crop has few photo pixels both for its own pixels and for a metre."""
    along = crop.sharpness * CROP_PX / crop.size_m * flattening(crop)
    return crop.sharpness < FILTER.min_sharpness and along < FILTER.min_density


def is_oblique(crop: Crop) -> bool:
    """Tell whether a crop is seen so flat that it is smeared along the view."""
    if crop.grazing_deg >= FILTER.min_grazing_deg:
        return False
    return (
        crop.grazing_deg < FILTER.least_grazing_deg
        or crop.sharpness * flattening(crop) < FILTER.flat_sharpness
    )


def flattening(crop: Crop) -> float:
    """Return a crop's photo pixels along the view over the mean of both directions."""
    return float(np.sqrt(np.sin(np.radians(crop.grazing_deg))))


def image_reasons(image: np.ndarray, *, joints: bool = False) -> list[Reason]:
    """Return what is wrong with a crop (n, n, 3) uint8 sRGB by itself: highlight, clutter, ...

    `joints` as of :func:`has_object`.
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
    """Tell whether blocks in one piece stand out from the rest of a crop.

    Smooth shading is taken away first. Patterns raise the blocks' own spread, or stand out in
    many pieces; with `joints` what is thin belongs to a pattern, too.
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
    """Return `SHADOW` or `CLUTTER` when one step of luminance divides a crop, else None."""
    small = cv2.resize(image, (64, 64), interpolation=cv2.INTER_AREA)
    smooth = cv2.GaussianBlur(small, (0, 0), 2.0)
    fine, log = (
        np.log(np.maximum(srgb_to_linear(i) @ np.array([0.2126, 0.7152, 0.0722]), 1e-3))
        for i in (small, smooth)
    )
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
    """Return the median mean colour (3,), L* counted half, of a plane's windows and its spread.

    The spread is the median distance from it.
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
    """Tell whether a window's mean colour is far from those of its plane."""
    lab = rgb_to_lab(patch.reshape(-1, 3).mean(axis=0) / 255.0) * np.array([0.5, 1.0, 1.0])
    return bool(np.linalg.norm(lab - middle) > FILTER.window_limit + FILTER.window_spread * spread)


def outvoted(colours: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Tell which groups of windows of one surface look unlike most of the others.

    `colours` (n, 3) are the L*a*b* of each group (a plane of a photo) under the common light,
    `weights` (n,) the windows of each. Returns (n,) bool, all False where no colour has a clear
    majority: a wardrobe taken for a wall can be told by the room's other walls only.
    """
    points = colours * np.array([0.5, 1.0, 1.0])
    distance = np.linalg.norm(points[:, None] - points[None], axis=-1)
    support = (distance <= FILTER.group_limit) @ weights
    best = int(np.argmax(support))
    if support[best] < FILTER.majority * weights.sum():
        return np.zeros(len(colours), dtype=bool)
    return np.asarray(distance[best] > FILTER.group_limit)


def restless(unrests: np.ndarray, least: float, share: float) -> np.ndarray:
    """Tell which groups (n,) of windows of a room's walls or floor show things, as a bool for each.

    A wallpaper or tiles are on the room's other walls, too; framed pictures hang on one. The
    calmest group tells what they are like: it varies by less than `share` of those that vary by
    `least` or more.
    """
    return np.asarray((unrests.min() <= share * unrests) & (unrests >= least))


def mark_outvoted(
    candidates: Sequence[Candidate], lights: Mapping[str, np.ndarray]
) -> list[Candidate]:
    """Return the candidates of a house; those that their surface outvotes get that reason.

    Windows without grave reasons vote, one group per plane of a photo, in the photos' own colours.
    `lights` (3,), linear RGB, are divided out before colours are compared. Groups that show things
    before a wall or on a floor get `CLUTTER`.
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
        found = {Reason.UNLIKE: outvoted(np.stack(colours), weights)}
        limits = {"wall": FILTER.restless_wall, "floor": FILTER.restless_floor}.get(surface)
        if limits is not None:
            looks = [[candidates[n].crop.image for n in g[: FILTER.looked_at]] for g in members]
            found[Reason.CLUTTER] = restless(
                np.array([np.median([unrest(image) for image in images]) for images in looks]),
                *limits,
            )
        for reason, these in found.items():
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
