"""The use of a photographed room, by the things that an ImageNet network sees in it.

Nothing is trained here: a table says how likely each thing is in each kind of room.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.photos.labels.palette import KINDS

if TYPE_CHECKING:
    import torch

#: Longer sides in pixels at which the network sees a photo, and the side of the windows that it
#: classifies, in cells of 32 pixels: the 224 pixels that the network was trained on.
SIDES = (320, 512, 768)
WINDOW = 7
#: Longer side in pixels at which photos are compared with each other.
LOOK_SIDE = 448
#: Quantile of a thing's probability over the windows that counts for the photo. It is not the
#: largest, because the network may be wrong in one window.
SHARE = 0.95
#: Probability that is subtracted: the network is never sure that a thing is absent.
LEAST_SURE = 0.05
#: Power of the odds. Chosen by hand, as the table and `LEAST_SURE`, on two real listings and a flat
#: (development).
SHARPNESS = 3.0


def _read_things() -> tuple[list[list[int]], np.ndarray]:
    """Return the ImageNet classes of each row of things.csv, and its shares (t, k) of `KINDS`."""
    text = Path(__file__).with_name("things.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    classes = [[int(number) for number in row["classes"].split()] for row in rows]
    return classes, np.array([[float(row.get(kind) or 0.0) for kind in KINDS] for row in rows])


#: For each thing, its ImageNet classes and its shares: which share of the photos that show it are
#: of each kind of room. For receptions it is .6 of that share, because they are photographed most,
#: and `which_room` takes that into account. Kinds without a share have 0. Many cupboards look like
#: a medicine cabinet, some beds like a couch. Classes that an empty white room resembles are left
#: out: refrigerator, dishwasher, shower curtain, paper, soap.
THINGS, SHARES = _read_things()
#: Classes of outdoor scenes: land and shore, buildings, fences, bridges, street, vehicles.
OUTDOORS = (
    *(970, 972, 975, 976, 977, 978, 979, 980),
    *(410, 425, 437, 442, 448, 449, 483, 497, 500, 580, 660, 663, 668, 698, 743, 832, 853, 858),
    *(489, 562, 682, 706, 716, 825, 873, 912),
    *(536, 718, 821, 839, 888, 704, 733, 919, 920),
    *(436, 511, 609, 621, 627, 654, 656, 675, 705, 717, 751, 803, 817, 864, 867),
)
#: Least mean probability of `OUTDOORS` over the windows of a photo from outside, at the first of
#: `SIDES`. Chosen on real listings and flats (development): it was .49 to .71 for three photos from
#: outside and .17 for a fourth, .30 and .24 for two of 268 photos of rooms, less for the others.
OUTSIDE = 0.2
#: Added to each share, so that no thing rules out a kind of room.
_LEAST = 0.03


class ThingKinds:
    """Finds the use of rooms by the things that photos show."""

    def __init__(self, network: Any) -> None:
        self._network = network

    def seen(self, image: np.ndarray) -> np.ndarray:
        """Return the probabilities (t,) of :data:`THINGS` in a (h, w, 3) uint8 sRGB photo."""
        side_quantiles = []
        for side in SIDES:
            classes = self._classes(image, side)
            things = np.stack([classes[:, names].sum(axis=1) for names in THINGS])
            side_quantiles.append(np.quantile(things, SHARE, axis=1))
        return np.asarray(np.mean(side_quantiles, axis=0))

    def look(self, image: np.ndarray) -> np.ndarray:
        """Return the mean features (1280,) float32 of a (h, w, 3) uint8 sRGB photo."""
        return np.asarray(self._cells(image, LOOK_SIDE).mean(dim=(2, 3))[0])

    def _cells(self, image: np.ndarray, side: int) -> torch.Tensor:
        """Return the network's last features (1, 1280, h', w') of a photo."""
        import cv2
        import torch

        from plan2scene.photos.labels.segmentation import network_size

        size = network_size((image.shape[0], image.shape[1]), side)
        small = cv2.resize(image, size[::-1], interpolation=cv2.INTER_AREA)
        photo = torch.from_numpy((small.astype(np.float32) - 127.0) / 128.0)
        with torch.inference_mode():
            found: torch.Tensor = self._network.extract_features(photo.permute(2, 0, 1)[None])
        return found

    def _classes(self, image: np.ndarray, side: int) -> np.ndarray:
        """Return the probabilities (w, 1000) of ImageNet's classes in each window of a photo."""
        import torch
        from torch.nn import functional

        cells = self._cells(image, side)
        with torch.inference_mode():
            window = [min(WINDOW, cells.shape[2]), min(WINDOW, cells.shape[3])]
            cells = functional.avg_pool2d(cells, window, 1)[0].flatten(1).T
            return np.asarray(torch.softmax(self._network._fc(cells), dim=1))

    def outside(self, image: np.ndarray) -> bool:
        """Return whether a (h, w, 3) uint8 sRGB photo looks taken from outside."""
        shares = self._classes(image, SIDES[0])[:, list(OUTDOORS)].sum(axis=1)
        return bool(shares.mean() >= OUTSIDE)

    def probabilities(self, image: np.ndarray) -> np.ndarray:
        """Return the probability of each of :data:`KINDS`, (k,) float32, for a (h, w, 3) photo.

        A thing that is not seen changes nothing.
        """
        shares = SHARES + _LEAST
        odds = shares / np.mean(shares, axis=1, keepdims=True)
        sure = np.maximum(self.seen(image) - LEAST_SURE, 0.0) / (1.0 - LEAST_SURE)
        log = SHARPNESS * np.log1p(sure[:, None] * (odds - 1.0)).sum(axis=0)
        share = np.exp(log - log.max())
        return np.asarray(share / share.sum(), dtype=np.float32)
