"""The use of a photographed room, by the things that an ImageNet network sees in it.

Nothing is trained here: a table says how likely each thing is in each kind of room.
"""

from __future__ import annotations

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
#: For each thing, its ImageNet classes and its shares: which share of the photos that show it are
#: of each kind of room. For receptions it is .6 of that share, because they are photographed most,
#: and `which_room` takes that into account. Kinds that are not named have share 0. Classes that an
#: empty white room resembles are left out: refrigerator, dishwasher, shower curtain, paper, soap.
THINGS: tuple[tuple[tuple[int, ...], dict[str, float]], ...] = (
    # bathtub, hot tub, toilet seat, bath towel
    ((435, 876, 861, 434), {"Bathroom": 0.9}),
    # washbasin
    ((896,), {"Bathroom": 0.65, "Kitchen": 0.3}),
    # medicine cabinet; many cupboards look like one
    ((648,), {"Bathroom": 0.4, "Closet": 0.2, "Kitchen": 0.2, "Bedroom": 0.15}),
    # four-poster, quilt, mosquito net, infant bed, cradle, bassinet, pillow, pyjamas
    ((564, 750, 669, 520, 516, 431, 721, 697), {"Bedroom": 0.85, "Reception": 0.06}),
    # couch; some beds look like one
    ((831,), {"Reception": 0.36, "Bedroom": 0.3, "Kitchen": 0.1}),
    # home theatre, entertainment centre, television, rocking chair, fire screen, pianos, pool
    # table, loudspeaker
    (
        (598, 548, 851, 765, 556, 881, 579, 736, 632),
        {"Reception": 0.48, "Bedroom": 0.15, "Kitchen": 0.05},
    ),
    # stove, microwave, plate rack, espresso machine, toaster, waffle iron, rotisserie, pots, pans,
    # bowls and what lies in them
    (
        (827, 651, 729, 550, 859, 891, 766)
        + (544, 909, 567, 505, 849, 659, 521, 813, 618, 828, 533, 647, 809),
        {"Kitchen": 0.85, "Reception": 0.06},
    ),
    # dining table, restaurant
    ((532, 762), {"Reception": 0.3, "Kitchen": 0.45}),
    # desk, computers, screens, keyboard, printer, filing cabinet
    (
        (526, 527, 620, 681, 664, 782, 508, 742, 553),
        {"Bedroom": 0.5, "Reception": 0.21, "Kitchen": 0.05},
    ),
    # bookcase, library, bookshop
    ((453, 624, 454), {"Reception": 0.3, "Bedroom": 0.3, "Corridor": 0.1}),
    # wardrobe, chiffonier
    ((894, 493), {"Bedroom": 0.5, "Closet": 0.3, "Corridor": 0.1}),
    # table lamp, lampshade
    ((846, 619), {"Bedroom": 0.5, "Reception": 0.24}),
    # washing machine
    ((897,), {"Bathroom": 0.45, "Kitchen": 0.35, "Closet": 0.2}),
    # handrail
    ((421,), {"Corridor": 0.7, "Reception": 0.09}),
)
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
            things = np.stack([classes[:, list(names)].sum(axis=1) for names, _ in THINGS])
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
        shares = [[found.get(kind, 0.0) + _LEAST for kind in KINDS] for _, found in THINGS]
        odds = np.array(shares) / np.mean(shares, axis=1, keepdims=True)
        sure = np.maximum(self.seen(image) - LEAST_SURE, 0.0) / (1.0 - LEAST_SURE)
        log = SHARPNESS * np.log1p(sure[:, None] * (odds - 1.0)).sum(axis=0)
        share = np.exp(log - log.max())
        return np.asarray(share / share.sum(), dtype=np.float32)
