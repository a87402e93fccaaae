"""What the layers and blocks of a DXF drawing are taken for, by their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

from plan2scene.errors import InputError
from plan2scene.plans.parse import Source

#: Patterns of layer and block names, as CAD programs have them: parted by commas, of the whole
#: name in any case; ``*`` any letters, ``?`` one, ``[aä]`` one of these, ``[!a-z]`` none of these.
LAYERS = {
    "rooms": "*room*,*raum*,*r[aä]ume*,*space*,*area,*area[!l]*,*zone*,*fl[aä]che*,*pi[eè]ce*,"
    "*locale*,*habitac*,*ruimte*",
    "doors": "*door*,*t[uü]r*,*tuer*,*porte,*porte[!u]*,*puerta*,*porta*,*deur*",
    "windows": "*window*,*fenster*,*fen[eê]tre*,*ventana*,*finestra*,*raam*,*glaz*",
    "walls": "*wall*,*wand*,*w[aä]nde*,*mauer*,mur*,*[!a-z]mur*,*muro*,*parete*,*muur*",
}
#: Longest pattern.
MAX_PATTERN = 300


def layers_of(pairs: Sequence[str]) -> dict[str, str]:
    """Return the patterns of ``KIND=PATTERN`` lines, as `house_of_dxf` takes them."""
    patterns: dict[str, str] = {}
    for pair in pairs:
        kind, _, pattern = pair.partition("=")
        if kind not in LAYERS or not pattern:
            expected = f"a DXF layer as KIND=PATTERN, KIND one of {', '.join(LAYERS)}"
            raise InputError(expected, repr(pair))
        patterns[kind] = pattern
    return patterns


def names_of(entity: Any) -> list[str]:
    """Return the names that tell what an entity is: its block's where it is one, its layer's."""
    names = [str(entity.dxf.get("layer", ""))]
    if entity.dxftype() == "INSERT":
        names.insert(0, str(entity.dxf.get("name", "")))
    return names


class LayerKinds:
    """Tells of which of `LAYERS` names are; `layers` holds patterns in place of its own."""

    def __init__(self, source: Source, layers: Mapping[str, str]) -> None:
        self.patterns: dict[str, list[str]] = {}
        self._known: dict[str, str] = {}
        for kind in ("doors", "windows", "rooms", "walls"):
            text = layers.get(kind) or LAYERS[kind]
            if len(text) > MAX_PATTERN:
                expected = f"at most {MAX_PATTERN} letters of {kind} in dxf_layers"
                raise source.fault(expected, len(text))
            self.patterns[kind] = [part.strip().casefold() for part in text.split(",")]

    def of_name(self, name: str) -> str:
        """Return the kind of a layer or block; empty for none."""
        if name not in self._known:  # many entities, few names
            folded = name.casefold()
            kinds = (
                kind
                for kind, patterns in self.patterns.items()
                if any(fnmatchcase(folded, pattern) for pattern in patterns)
            )
            self._known[name] = next(kinds, "")
        return self._known[name]

    def of(self, entity: Any) -> str:
        """Return the kind of an entity by its block's name, else by its layer; empty for none."""
        return next((kind for name in names_of(entity) if (kind := self.of_name(name))), "")
