"""What a DXF drawing holds, before its unit is known: names of layers and blocks, its size."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.plans.formats import PlanFile, PlanFormat, Unscaled
from plan2scene.plans.parse import Source
from plan2scene_app.plan_formats.dxf import entities_of, house_of_dxf, is_dxf, load_dxf
from plan2scene_app.plan_formats.dxf_curves import CURVES, Curves
from plan2scene_app.plan_formats.dxf_layers import LayerKinds, names_of

#: Most layers and blocks that are told, those with the most entities first.
MAX_NAMES = 200
#: Metres of a unit by which curves are cut while the unit is unknown.
TRIAL = 1e-3


@dataclass(frozen=True)
class DxfName:
    """A layer, or a block that is inserted."""

    name: str
    count: int  #: entities
    block: bool
    kind: str  #: rooms, walls, doors or windows as it is read now; empty: left out


def contents_of_dxf(
    path: Path, house_id: str, layers: Mapping[str, str] | None = None
) -> tuple[list[DxfName], tuple[float, float] | None]:
    """Return the names in the model space, and width and depth of its rooms and walls.

    The size is in units of the drawing; None where no layer is of rooms or walls.
    """
    source = Source(str(path), house_id)
    document = load_dxf(source, path)
    kinds, curves = LayerKinds(source, layers or {}), Curves(source, document, TRIAL)
    counts: Counter[tuple[str, bool]] = Counter()
    bounds = []
    for entity in entities_of(source, document):
        *block, layer = names_of(entity)
        counts.update([(layer, False), *((name, True) for name in block)])
        if entity.dxftype() in CURVES and kinds.of(entity) in ("rooms", "walls"):
            line = curves.line(entity)
            bounds += [] if line is None else [line.bounds]
    names = [
        DxfName(name, count, block, kinds.of_name(name))
        for (name, block), count in counts.most_common(MAX_NAMES)
    ]
    if not bounds:
        return names, None
    array = np.array(bounds)
    width, depth = (array[:, 2:].max(axis=0) - array[:, :2].min(axis=0)) / TRIAL
    return names, (float(width), float(depth))


def _look(plan: PlanFile) -> Unscaled:
    names, size = contents_of_dxf(plan.path, plan.house_id, plan.dxf_layers)
    return Unscaled("unit", size, tuple(names))


PLAN_FORMAT = PlanFormat(
    "DXF",
    lambda plan: is_dxf(plan.head),
    lambda plan: house_of_dxf(plan.path, plan.house_id, plan.metres_per_pixel, plan.dxf_layers),
    suffixes=(".dxf",),
    needs="plan2scene[formats]",
    look=_look,
)
