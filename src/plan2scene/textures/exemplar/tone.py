"""The colour that crops agree on, and a quilted image brought to a colour and a size."""

from __future__ import annotations

import cv2
import numpy as np

_WHITE = 0.96  # channel value beyond which in all channels a crop's colour is burned out
_REPAIR = 0.03  # log repair of the light below which crops count alike for the brightness


def consensus(tones: np.ndarray, repair: np.ndarray) -> np.ndarray:
    """Return the colour (3,) that crops agree on.

    A cast may go either way in each crop: the mean of their chroma (log ratios of the channels)
    has the least error. Shading mostly darkens and spoils some crops more than others: the level
    is the mean weighted by how little their light had to be repaired. Where half of the crops of
    a white surface burn out it is the median; fewer of them have no say.

    Parameters
    ----------
    tones : (n, 3) float
        Median colours of the crops, sRGB in [0, 1].
    repair : (n,) float
        Standard deviation of the log light that was taken out of each.
    """
    burned = tones.min(axis=1) > _WHITE
    if 2 * burned.sum() >= len(tones):
        return np.median(tones, axis=0)
    logs = np.log(np.maximum(tones[~burned], 1 / 255))
    levels = logs.mean(axis=1)
    weights = 1.0 / (_REPAIR + repair[~burned]) ** 2
    chroma = (logs - levels[:, None]).mean(axis=0)
    return np.minimum(np.exp(chroma + np.average(levels, weights=weights)), 1.0)


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
    """Return an sRGB image in [0, 1] scaled to the median colour `tone`, (3,)."""
    median = np.median(image.reshape(-1, 3), axis=0)
    return np.clip(image * (tone / np.maximum(median, 1 / 255)), 0.0, 1.0)
