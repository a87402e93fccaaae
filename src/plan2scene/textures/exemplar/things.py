"""Things on plain surfaces, outlets, switches, stickers, that other crops do not show."""

from __future__ import annotations

import numpy as np

from plan2scene.textures.exemplar.grain import pattern_band

#: High percentile over the median of what a crop's pattern varies by: noise and plaster have 5 to
#: 10, a thing on them more, as do joints of tiles (from 12 on).
PLAIN = 10.0
#: That percentile: an outlet has a few pixels of a crop.
_HIGH = 99.97
#: Share of the crops that have to be plain for their surface to be so.
_SOME = 0.25


def oddness(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return by how much (n,) log crops of a plain surface show things; 0 where nearly all do.

    `luma` (n, s, s) log grey values, `masks` (n, s, s) bool pixels to leave out.
    """
    ratio = np.ones(len(luma))
    for k, (one, mask) in enumerate(zip(luma, masks, strict=True)):
        away = np.abs(pattern_band(one)[~mask])
        if len(away):
            ratio[k] = np.percentile(away, _HIGH) / max(float(np.median(away)), 1e-6)
    if not len(ratio) or np.quantile(ratio, _SOME) > PLAIN:
        return np.zeros(len(ratio))
    return np.asarray(np.maximum(np.log(ratio / PLAIN), 0.0))
