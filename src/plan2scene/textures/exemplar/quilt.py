"""A tile quilted on a torus from patches of several crops, joined in the gradient domain.

The best crop is laid down, then patches of all crops at the offsets where they fit best cover
what is left; each joint follows a minimum cut (Kwatra et al. 2003), and the tile is rebuilt from
the gradients of its patches, which takes the last steps of brightness out of the joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from plan2scene.textures.exemplar.cut import minimum_cut

_FIRST = 0.82  # side of the first patch over the torus's, at most: the rest joins its borders
_EXPECTED = 0.5  # what a pixel counts that the pattern's periods tell, over one that is there
_RIM = 2  # pixels next to a patch's border that it never takes from what is there


@dataclass(frozen=True, eq=False)
class Source:
    """A straightened crop at the tile's scale: (h, w, 3) float32 and its valid pixels (h, w)."""

    image: np.ndarray
    valid: np.ndarray


@dataclass(eq=False)
class Canvas:
    """A torus that patches are laid on.

    Attributes
    ----------
    image : (s, s, 3) float32
    filled : (s, s) bool
    down, right : (s, s, 3) float32
        Gradient from each pixel to its lower and right neighbour.
    """

    size: int
    image: np.ndarray = field(init=False)
    filled: np.ndarray = field(init=False)
    down: np.ndarray = field(init=False)
    right: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        shape = (self.size, self.size)
        self.image = np.zeros((*shape, 3), np.float32)
        self.filled = np.zeros(shape, bool)
        self.down, self.right = np.zeros_like(self.image), np.zeros_like(self.image)

    def laid(self, source: Source, offset: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Return a source's pixels and validity on the torus, its corner at `offset`."""
        image = np.zeros_like(self.image)
        valid = np.zeros_like(self.filled)
        height, width = source.valid.shape
        image[:height, :width], valid[:height, :width] = source.image, source.valid
        return np.roll(image, offset, (0, 1)), np.roll(valid, offset, (0, 1))

    def lay(self, source: Source, offset: tuple[int, int]) -> None:
        """Lay a patch: it covers what is empty, elsewhere the minimum cut decides."""
        patch, valid = self.laid(source, offset)
        inner = cv2.erode(
            np.pad(valid, _RIM, mode="wrap").astype(np.uint8),
            np.ones((2 * _RIM + 1,) * 2, np.uint8),
        )[_RIM:-_RIM, _RIM:-_RIM].astype(bool)
        new = valid & ~self.filled
        old = (self.filled & ~inner & ~new) | ~valid
        if not old.any():
            taken = valid
        else:
            difference = np.abs(self.image - patch).sum(axis=2)
            difference[~(self.filled & valid)] = 0.05
            down, right = (difference + np.roll(difference, -1, axis) for axis in (0, 1))
            taken = minimum_cut((down, right), old, new)
        self._merge(patch, valid, taken)

    def _merge(self, patch: np.ndarray, valid: np.ndarray, taken: np.ndarray) -> None:
        """Take pixels and gradients of a patch; joints get the mean of both sides' gradients."""
        for axis, own in ((0, self.down), (1, self.right)):
            beside = np.roll(taken, -1, axis)
            patch_step = np.roll(patch, -1, axis) - patch
            known = self.filled & np.roll(self.filled, -1, axis)
            possible = valid & np.roll(valid, -1, axis)
            inside = taken & beside
            own[inside] = patch_step[inside]
            joint = taken != beside
            both = joint & known & possible
            own[both] = (own[both] + patch_step[both]) / 2
            single = joint & ~known & possible
            own[single] = patch_step[single]
        self.image[taken] = patch[taken]
        self.filled |= taken

    def solve(self) -> np.ndarray:
        """Return the (s, s, 3) image whose gradients are the patches', its mean the patches'."""
        divergence = sum(g - np.roll(g, 1, axis) for g, axis in ((self.down, 0), (self.right, 1)))
        wave = 2.0 * np.cos(2.0 * np.pi * np.arange(self.size) / self.size)
        laplace = wave[:, None] + wave[None, :] - 4.0
        laplace[0, 0] = 1.0
        spectrum = np.fft.fft2(divergence, axes=(0, 1)) / laplace[..., None]
        spectrum[0, 0] = self.image.sum(axis=(0, 1))
        return np.fft.ifft2(spectrum, axes=(0, 1)).real


def quilt(sources: Sequence[Source], size: int, periods: tuple[int, int] = (0, 0)) -> Canvas:
    """Return a filled torus of `size` px; `sources` the best first, none larger than it.

    `periods` is how often the pattern repeats in it along x and y, 0 where it has no period: a
    patch has to fit what is there one period on, too, so joints that a patch shows alone keep step.
    ValueError without a source that has valid pixels.
    """
    if not any(source.valid.any() for source in sources):
        raise ValueError("no source has valid pixels")
    canvas = Canvas(size)
    canvas.lay(_middle(sources[0], round(_FIRST * size)), (0, 0))
    spectra = [_spectra(source, size) for source in sources]
    while not canvas.filled.all():
        index, offset = _best_offset(canvas, spectra, periods) or _anywhere(canvas, sources)
        canvas.lay(sources[index], offset)
    return canvas


def _middle(source: Source, side: int) -> Source:
    """Return a source whose valid pixels lie within the middle square of `side` px."""
    valid = np.zeros_like(source.valid)
    top, left = (max(0, (n - side) // 2) for n in valid.shape)
    part = slice(top, top + side), slice(left, left + side)
    valid[part] = source.valid[part]
    return Source(source.image, valid)


def _anywhere(canvas: Canvas, sources: Sequence[Source]) -> tuple[int, tuple[int, int]]:
    """Return a source and an offset that fills the first empty pixel, where nothing overlaps."""
    index = next(k for k, source in enumerate(sources) if source.valid.any())
    places = np.argwhere(~canvas.filled)[0]
    valid = np.argwhere(sources[index].valid)
    inside = valid[len(valid) // 2]
    row, column = (places - inside) % canvas.size
    return index, (int(row), int(column))


def _spectra(source: Source, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return conjugate spectra of a source's validity, values and squared values."""
    valid = np.zeros((size, size))
    image = np.zeros((size, size, 3))
    height, width = source.valid.shape
    valid[:height, :width] = source.valid
    image[:height, :width] = source.image * source.valid[..., None]
    return (
        np.fft.rfft2(valid).conj(),
        np.fft.rfft2(image, axes=(0, 1)).conj(),
        np.fft.rfft2((image**2).sum(axis=2)).conj(),
    )


def _best_offset(
    canvas: Canvas, spectra: Sequence[tuple[np.ndarray, ...]], periods: tuple[int, int]
) -> tuple[int, tuple[int, int]] | None:
    """Return the source and its offset that fits best for the area it fills; None if none does."""
    known, weight = _expected(canvas, periods)
    shape = canvas.filled.shape
    f_filled = np.fft.rfft2(canvas.filled.astype(np.float64))
    f_weight = np.fft.rfft2(weight)
    f_known = np.fft.rfft2(known * weight[..., None], axes=(0, 1))
    f_square = np.fft.rfft2((known**2).sum(axis=2) * weight)
    best = (np.inf, 0, (0, 0))
    empty = float((~canvas.filled).sum())
    for index, (valid, image, square) in enumerate(spectra):
        overlap = np.fft.irfft2(f_filled * valid, s=shape)
        weighed = np.fft.irfft2(f_weight * valid, s=shape)
        error = np.fft.irfft2(
            f_square * valid - 2.0 * (f_known * image).sum(axis=2) + f_weight * square, s=shape
        )
        area = float(valid[0, 0].real)
        gain = (area - overlap) / min(area, empty)
        misfit = np.sqrt(np.maximum(error, 0.0) / np.maximum(weighed, 1.0))
        score = np.where(
            (overlap > 0.15 * area) & (gain > 0.02),
            misfit / np.clip(gain, 0.02, 1.0) ** 0.5,
            np.inf,
        )
        at = int(score.argmin())
        if score.flat[at] < best[0]:
            best = (float(score.flat[at]), index, (at // shape[1], at % shape[1]))
    return (best[1], best[2]) if np.isfinite(best[0]) else None


def _expected(canvas: Canvas, periods: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return what a torus shows or is to show by its periods, (s, s, 3), and its weight (s, s)."""
    filled = canvas.filled.astype(np.float64)
    columns, rows = (max(1, count) for count in periods)
    total, times = np.zeros(canvas.image.shape), np.zeros_like(filled)
    for row in range(rows):
        for column in range(columns):
            by = round(row * canvas.size / rows), round(column * canvas.size / columns)
            share = np.roll(filled, by, (0, 1))
            total += np.roll(canvas.image, by, (0, 1)) * share[..., None]
            times += share
    known = np.where(
        canvas.filled[..., None], canvas.image, total / np.maximum(times, 1)[..., None]
    )
    return known, np.where(canvas.filled, 1.0, _EXPECTED * (times > 0))
