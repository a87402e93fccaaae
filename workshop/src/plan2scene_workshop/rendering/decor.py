"""The look of one scene: materials, textiles, pictures, light, clutter.

Scenes are like real rooms, or randomised (domain randomisation, Tobin et al. 2017): then any
surface may have any texture at any scale, and lamps any colour.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plan2scene.house import SurfaceKey
from plan2scene.materials import Material
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.rendering.bedding import patchwork
from plan2scene_workshop.rendering.interiors import GLOW, Furnisher, RoomStyle
from plan2scene_workshop.rendering.inventory import BULK
from plan2scene_workshop.rendering.lights import (
    LightPlan,
    add_balcony,
    black_body,
    draw_light,
    view_outside,
)
from plan2scene_workshop.rendering.linings import granite, grid_ceiling, panels
from plan2scene_workshop.rendering.models import ModelShop
from plan2scene_workshop.rendering.palette import FABRICS, Palette, draw_palette, pattern
from plan2scene_workshop.rendering.randomised import random_surface
from plan2scene_workshop.rendering.sources import Environment, Sources
from plan2scene_workshop.rendering.tracer import Finish

_PICTURES = tuple(f"poster{k}" for k in range(6))
_RUGS = tuple(f"textile{k}" for k in range(6))
_SKINS = tuple(f"skin{k}" for k in range(5))
_QUILTS = tuple(f"quilt{k}" for k in range(3))
_TOPS = tuple(f"top{k}" for k in range(3))
#: Probability that a room is filled by each of `BULK`.
_BULK_SHARES = (0.16, 0.18, 0.16, 0.08, 0.07, 0.15)
#: Name of the material of boards on walls, and of beams.
PANELLING = "panelling"


@dataclass(frozen=True)
class Decor:
    """The look of one scene; it depends only on the fields below."""

    seed: int
    sources: Sources
    randomised: bool
    palette: Palette
    style: RoomStyle
    shop: ModelShop
    listing: bool = False  #: a tidy home with good light, as in photos of listings
    emptied: bool = False  #: nearly without furniture; surfaces stay normal unless `randomised`
    covered: float = 0.0  #: share of windows covered by blinds or curtains
    joinery: bool = False  #: whether there are fitted closets, various doors, balconies outside

    def finishes(self) -> dict[str, Finish]:
        """Return the finishes of textiles, pictures, skins, lamps, plain model parts and others."""
        rng = generator(self.seed, "finishes")
        made = {
            "model": Finish(two_sided=True),
            GLOW: Finish(emission=float(rng.uniform(5, 40)), light=self._lamp_colour(rng)),
        }
        for name in (*FABRICS, *_RUGS):
            made[name] = self._textile(rng)
        for name in _PICTURES:
            made[name] = self._picture(rng)
        for name in _SKINS:
            material = self._any(rng)
            size = material.size_m * float(np.exp(rng.uniform(-1.2, 0.3)))
            made[name] = Finish(material.albedo, size, material.roughness)
        if not self.listing:
            more = generator(self.seed, "tops")
            for name in _TOPS:
                made[name] = self._top(more)
            made[PANELLING] = self._panelling(more)
            for name in _QUILTS:
                made[name] = Finish(patchwork(more), float(np.exp(more.uniform(-1.2, 0.7))), 1.0)
        return made

    def _top(self, rng: np.random.Generator) -> Finish:
        """Return the finish of worktops and tables: stone or wood, often polished."""
        rough = float(rng.uniform(0.05, 0.6))
        real = [m for m in self.sources.textures if m.substance in ("wood", "tile")]
        if real and rng.random() < 0.6:
            material = real[int(rng.integers(len(real)))]
            size = material.size_m * float(np.exp(rng.uniform(-0.7, 0.3)))
            return Finish(_tinted(material.albedo, rng), size, rough)
        return Finish(granite(rng), float(np.exp(rng.uniform(-1.2, 0.2))), rough)

    def _panelling(self, rng: np.random.Generator) -> Finish:
        """Return the finish of boards side by side."""
        real = [m for m in self.sources.textures if m.substance == "wood"]
        wood = real[int(rng.integers(len(real)))].albedo if real and rng.random() < 0.6 else None
        size = float(np.exp(rng.uniform(-0.7, 0.4)))
        return Finish(panels(rng, wood), size, float(rng.uniform(0.2, 0.8)))

    def materials(self, materials: Mapping[SurfaceKey, Material]) -> dict[SurfaceKey, Material]:
        """Return the materials of the rooms' surfaces: as given, partly replaced or randomised."""
        if self.listing or (self.emptied and not self.randomised):
            return dict(materials)
        if not self.randomised:
            return {key: self._plausible(key, found) for key, found in materials.items()}
        made = {}
        for key in materials:
            rng = generator(self.seed, "surface", *key)
            real = {"floor": 0.7, "wall": 0.35, "ceiling": 0.12}[key.surface]
            if self.sources.textures and rng.random() < real:
                material = self._any(rng)
                size = material.size_m * float(np.exp(rng.uniform(-0.6, 0.5)))
                made[key] = replace(material, albedo=_tinted(material.albedo, rng), size_m=size)
            else:
                made[key] = random_surface(key, derive_seed(self.seed, "surface", *key))
        return made

    def _plausible(self, key: SurfaceKey, material: Material) -> Material:
        """Return a surface's material, sometimes replaced by one that is rare in listings."""
        seed = derive_seed(self.seed, "plausible", *key)
        rng = generator(seed)
        other = rng.random()
        if key.surface == "ceiling" and other < 0.25:
            return grid_ceiling(rng)
        if key.surface == "ceiling" and other < 0.4:
            return self._real(rng, ("wood", "plaster")) or random_surface(key, seed)
        if key.surface == "wall" and other < 0.2:
            return self._real(rng, ("tile", "wood", "plaster")) or material
        if key.surface == "wall" and other < 0.35:
            return random_surface(key, seed)
        return material

    def _real(self, rng: np.random.Generator, substances: tuple[str, ...]) -> Material | None:
        """Return a real texture of a random one of the substances; None if there is none."""
        wanted = str(rng.choice(substances))
        real = [m for m in self.sources.textures if m.substance == wanted]
        return real[int(rng.integers(len(real)))] if real else None

    def furnisher(self) -> Furnisher:
        """Return the furnisher of the scene's rooms."""
        return Furnisher(self.shop, self.palette, self.style)

    def light(self, floor: float, windows: float) -> LightPlan:
        """Return the light of the photographed room (areas in square metres)."""
        rng = generator(self.seed, "light")
        plan = draw_light(rng, floor, windows)
        if self.listing:
            return plan
        kelvin = float(rng.uniform(2000, 6500))
        night = rng.random() < 0.35
        sky = plan.sky * float(np.exp(rng.normal(0, 0.5)))
        if night:
            sky = float(rng.uniform(0.0, 0.4))
        lamps = float(np.exp(rng.normal(-0.3, 0.6))) if night or rng.random() < 0.6 else plan.lamps
        colour = self._lamp_colour(rng) if self.randomised else black_body(kelvin)
        tint = plan.sky_colour
        environment = self._environment()
        if environment is not None:
            tint = tuple(np.sqrt(np.array(tint) * environment.tint))
        return LightPlan(sky, lamps, tint, colour)

    def outside(self) -> NDArray[np.float32]:
        """Return the panorama seen through windows."""
        environment = self._environment()
        rng = generator(self.seed, "outside")
        if environment is None:
            view = view_outside(rng)
        else:
            view = np.roll(environment.panorama, int(rng.integers(1024)), axis=1)
        if self.joinery and rng.random() < 0.4:
            floor, wall = (self._any(rng).albedo for _ in range(2))
            return add_balcony(view, floor, wall, rng)
        return view

    def _environment(self) -> Environment | None:
        rng = generator(self.seed, "environment")
        choices = self.sources.environments
        if not choices or rng.random() < 0.25:
            return None
        return choices[int(rng.integers(len(choices)))]

    def _lamp_colour(self, rng: np.random.Generator) -> tuple[float, float, float]:
        colour = np.array(black_body(float(rng.uniform(2000, 6500))))
        if self.randomised:
            colour = colour * np.exp(rng.normal(0, 0.2, 3))
        red, green, blue = (float(c) for c in colour / colour.mean())
        return (red, green, blue)

    def _any(self, rng: np.random.Generator) -> Material:
        """Return any texture, mostly a real one if there are any."""
        textures = self.sources.textures
        if textures and rng.random() < 0.85:
            return textures[int(rng.integers(len(textures)))]
        key = SurfaceKey("any", str(rng.choice(["floor", "wall"])))
        return random_surface(key, int(rng.integers(2**31)))

    def _textile(self, rng: np.random.Generator) -> Finish:
        """Return a textile: a real one, sometimes in other colours, or a pattern."""
        real = [m for m in self.sources.textures if m.substance == "carpet"]
        if real and rng.random() < 0.6:
            material = real[int(rng.integers(len(real)))]
            size = material.size_m * float(np.exp(rng.uniform(-0.5, 0.7)))
            return Finish(_tinted(material.albedo, rng), size, 1.0)
        return Finish(pattern(rng, 96), float(np.exp(rng.uniform(-1.8, 0.6))), 1.0)

    def _picture(self, rng: np.random.Generator) -> Finish:
        """Return a poster: a crop of a view outside, a texture, or blobs."""
        environments = self.sources.environments
        if environments and rng.random() < 0.4:
            view = environments[int(rng.integers(len(environments)))].panorama
            x = int(rng.integers(0, view.shape[1] - 200))
            crop = np.clip(view[20:220, x : x + 200] * 0.6, 0, 1)
            tile = (255 * crop ** (1 / 2.2)).astype(np.uint8)
        elif rng.random() < 0.4:
            tile = _tinted(self._any(rng).albedo, rng)
        else:
            tile = _poster(rng)
        return Finish(np.ascontiguousarray(tile), float(rng.uniform(0.4, 1.2)), 0.3)


def draw_decor(sources: Sources, seed: int, *, randomised: bool, emptied: bool = False) -> Decor:
    """Draw the look of one scene; an emptied one has hardly any furniture."""
    rng = generator(seed, "decor")
    kind = "Office" if rng.random() < 0.2 else None
    if randomised and rng.random() < 0.3:
        kind = str(rng.choice(["Reception", "Bedroom", "Kitchen", "Office", "Bathroom"]))
    dense = rng.random() < 0.7
    style = RoomStyle(
        crowd=float(rng.uniform(1.2, 2.6) if dense else rng.uniform(0.2, 1.0)),
        clutter=float(rng.uniform(1.0, 3.2) if dense else rng.uniform(0.1, 0.9)),
        kind=kind,
        skins=_SKINS if randomised else (),
        bedding=(*_QUILTS, *FABRICS, *_RUGS),
        fabrics=(*FABRICS, *_RUGS),
        pictures=_PICTURES,
        lit=float(rng.choice([0.0, 0.5, 1.0])),
        tops=_TOPS,
        bulk=str(rng.choice(["", *BULK], p=[0.2, *_BULK_SHARES])),
    )
    if emptied:
        style = _emptied(style, generator(seed, "emptied"))
    palette = draw_palette(generator(seed, "palette"))
    shop = ModelShop(sources.models)
    return Decor(seed, sources, randomised, palette, style, shop, emptied=emptied)


def _emptied(style: RoomStyle, rng: np.random.Generator) -> RoomStyle:
    """Return the style of an emptied room: built-in furniture and a few other things."""
    crowd, clutter, rugs = (float(x) for x in rng.uniform(0.0, 0.35, 3) * (rng.random() < 0.7))
    left = replace(
        style, crowd=crowd, clutter=clutter, rugs=rugs, built_in=float(rng.uniform(0, 1))
    )
    return replace(left, kind=None, tops=(), bulk="")


def listing_decor(sources: Sources, seed: int) -> Decor:
    """Draw the look of a home that was tidied up for photos."""
    rng = generator(seed, "listing")
    style = RoomStyle(
        crowd=float(rng.uniform(0.9, 1.4)),
        clutter=float(rng.uniform(0.4, 1.0)),
        kind=None,
        skins=(),
        bedding=(*FABRICS, *_RUGS),
        fabrics=(*FABRICS, *_RUGS),
        pictures=_PICTURES,
        lit=float(rng.choice([0.0, 0.5])),
    )
    palette = draw_palette(generator(seed, "palette"))
    return Decor(seed, sources, False, palette, style, ModelShop(sources.models), listing=True)


def _tinted(tile: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the tile, in half of the cases with changed colours."""
    if rng.random() < 0.5:
        return tile
    gain = np.exp(rng.normal(0, 0.3, 3) + rng.normal(0, 0.35))
    image = tile.astype(np.float32)
    if rng.random() < 0.3:
        image = image[..., rng.permutation(3)]
    return np.clip(image * gain, 4, 250).astype(np.uint8)


def _poster(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return blobs and bars on a gradient."""
    size = 96
    y, x = np.mgrid[:size, :size] / size
    top, bottom = rng.uniform(10, 250, (2, 3))
    image = top + (bottom - top) * y[..., None]
    for _ in range(int(rng.integers(3, 25))):
        cx, cy, turn = rng.random(3)
        w, h = np.exp(rng.uniform(-4, -1, 2))
        a = (x - cx) * np.cos(6.3 * turn) + (y - cy) * np.sin(6.3 * turn)
        b = (y - cy) * np.cos(6.3 * turn) - (x - cx) * np.sin(6.3 * turn)
        round_ = rng.random() < 0.5
        inside = (a / w) ** 2 + (b / h) ** 2 < 1 if round_ else (abs(a) < w) & (abs(b) < h)
        image[inside] = rng.uniform(5, 250, 3)
    return np.clip(image, 0, 255).astype(np.uint8)
