"""What a house's photos together tell about their windows: a common light, and who agrees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from plan2scene.colour import linear_to_srgb, median_colour, rgb_to_lab, srgb_to_linear
from plan2scene.photos.crops.filter import outvoted, with_reason
from plan2scene.photos.crops.tables import PhotoCandidate
from plan2scene.photos.crops.verdict import Reason


def agreeing(
    drawn: Sequence[PhotoCandidate], lights: Mapping[str, np.ndarray]
) -> list[PhotoCandidate]:
    """Return the candidates, those outvoted by the rest of their surface with that reason.

    `drawn` are those of a house, as photographed: windows without grave reasons vote, one group
    per plane of a photo. `lights` (3,), linear RGB, are divided out before colours are compared.
    """
    groups: dict[tuple[str, str], dict[tuple[str, int], list[int]]] = {}
    for number, item in enumerate(drawn):
        if not item.candidate.verdict.grave:
            for room in item.rooms:
                planes = groups.setdefault((room, item.surface), {})
                planes.setdefault((item.photo, item.plane), []).append(number)
    result = list(drawn)
    for planes in groups.values():
        colours = [
            np.median([_colour(drawn[number], lights) for number in members], axis=0)
            for members in planes.values()
        ]
        weights = np.array([len(members) for members in planes.values()], dtype=float)
        unlike = outvoted(np.stack(colours), weights)
        for members, out in zip(planes.values(), unlike, strict=True):
            for number in members if out else ():
                refused = with_reason(drawn[number].candidate, Reason.UNLIKE)
                result[number] = replace(drawn[number], candidate=refused)
    return result


def _colour(item: PhotoCandidate, lights: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the L*a*b* (3,) of a crop's median colour without its photo's light."""
    linear = srgb_to_linear(median_colour(item.candidate.crop.image))
    linear = linear / lights.get(item.photo, np.ones(3))
    return rgb_to_lab(linear_to_srgb(np.minimum(linear, 1.0)))
