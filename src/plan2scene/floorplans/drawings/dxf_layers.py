"""What the layers and blocks of a DXF drawing are taken for, by their names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from plan2scene.errors import InputError
from plan2scene.floorplans.parse import Source

#: Regular expressions of layer and block names; a name may match anywhere, in any case.
LAYERS = {
    "rooms": r"room|raum|r[aä]ume|space|area(?!l)|zone|fl[aä]che|pi[eè]ce|locale|habitac|ruimte",
    "doors": r"door|t[uü]r|tuer|porte|puerta|porta|deur",
    "windows": r"window|fenster|fen[eê]tre|ventana|finestra|raam|glaz",
    "walls": r"wall|wand|w[aä]nde|mauer|\bmur|muro|parete|muur",
}


def layers_of(pairs: Sequence[str]) -> dict[str, str]:
    """Return the patterns of ``KIND=PATTERN`` lines, as `house_of_dxf` takes them."""
    found: dict[str, str] = {}
    for pair in pairs:
        kind, _, pattern = pair.partition("=")
        if kind not in LAYERS or not pattern:
            expected = f"a DXF layer as KIND=PATTERN, KIND one of {', '.join(LAYERS)}"
            raise InputError(expected, repr(pair))
        found[kind] = pattern
    return found


def names_of(entity: Any) -> list[str]:
    """Return the names that tell what an entity is: its block's where it is one, its layer's."""
    names = [str(entity.dxf.get("layer", ""))]
    if entity.dxftype() == "INSERT":
        names.insert(0, str(entity.dxf.get("name", "")))
    return names


class LayerKinds:
    """Tells of which of `LAYERS` names are; `layers` holds patterns in place of its own."""

    def __init__(self, source: Source, layers: Mapping[str, str]) -> None:
        try:
            self.patterns = {
                kind: re.compile(layers.get(kind) or LAYERS[kind], re.IGNORECASE)
                for kind in ("doors", "windows", "rooms", "walls")
            }
        except re.error as error:
            raise source.fault("regular expressions in dxf_layers", error) from None

    def of_name(self, name: str) -> str:
        """Return the kind of a layer or block; empty for none."""
        return next((kind for kind, pattern in self.patterns.items() if pattern.search(name)), "")

    def of(self, entity: Any) -> str:
        """Return the kind of an entity by its block's name, else by its layer; empty for none."""
        return next((kind for name in names_of(entity) if (kind := self.of_name(name))), "")
