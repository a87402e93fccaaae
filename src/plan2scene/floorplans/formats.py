"""The plan formats: one registry, which :func:`read_plan` and its messages follow.

A new format is a reader module in this folder and an entry in :data:`FORMATS`
(docs/extending.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.floorplans.drawings.cubicasa import house_of_cubicasa
from plan2scene.floorplans.drawings.dxf import house_of_dxf, is_dxf
from plan2scene.floorplans.drawings.ifc import house_of_ifc, is_ifc
from plan2scene.floorplans.drawings.roomplan import house_of_roomplan, is_roomplan
from plan2scene.floorplans.drawings.sweet_home import house_of_sweet_home, is_sweet_home
from plan2scene.floorplans.drawings.zind import house_of_zind, is_zind
from plan2scene.floorplans.parse import parse_json
from plan2scene.floorplans.plan_json import FORMAT, house_of_plan
from plan2scene.floorplans.r2v import house_of_r2v
from plan2scene.floorplans.r2v_text import is_r2v
from plan2scene.floorplans.scene_json import house_of_scene
from plan2scene.floorplans.unscaled import Unscaled, unscaled_dxf, unscaled_r2v, unscaled_svg
from plan2scene.house import House
from plan2scene.io import read_text

#: How files that are no text begin, and what they are.
_SIGNATURES = (
    (b"PK\x03\x04", "a ZIP archive"),
    (b"PK\x05\x06", "an empty ZIP archive"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"RIFF", "a WebP picture or other RIFF file"),
    (b"II*\x00", "a TIFF picture"),
    (b"MM\x00*", "a TIFF picture"),
    (b"BM", "a BMP picture"),
    (b"%PDF", "a PDF"),
    (b"AC10", "a DWG drawing (save it as DXF)"),
    (b"\xac\xed", "a serialised Java object"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"glTF", "a GLB model"),
)


@dataclass(frozen=True)
class PlanFile:
    """A plan on disk, read when a format first looks at it.

    The house gets the name `house_id`; `metres_per_pixel` is the scale of formats in pixels (of
    DXF the unit), `dxf_layers` names the layers of DXF (docs/floorplans.md).
    """

    path: Path
    house_id: str
    metres_per_pixel: float | None = None
    dxf_layers: Mapping[str, str] | None = None

    @cached_property
    def head(self) -> bytes:
        """The first bytes of the file."""
        try:
            with self.path.open("rb") as file:
                return file.read(4096)
        except OSError as error:
            raise self.fault("a readable file", error.strerror or "an error") from None

    @cached_property
    def binary(self) -> str:
        """What kind of file this is when it begins like one that is no text; else empty."""
        return next((name for start, name in _SIGNATURES if self.head.startswith(start)), "")

    @property
    def is_picture(self) -> bool:
        """Whether it is a picture, which is to be traced."""
        return self.binary.endswith("picture")

    @cached_property
    def text(self) -> str:
        """The file as UTF-8 text; empty for a :attr:`binary` one."""
        try:
            return "" if self.binary else read_text(self.path)
        except InputError as error:
            raise self.fault(error.expected, error.found) from None

    @cached_property
    def document(self) -> Any:
        """The parsed JSON; None where the text is none (a syntax error is an InputError)."""
        if not self.text.lstrip().startswith(("{", "[")):
            return None
        return parse_json(self.text, self.path, self.house_id)

    def fault(self, expected: str, found: str) -> InputError:
        """Return (not raise) the error of a fault of this file."""
        return InputError(expected, found, file=self.path, house=self.house_id)


@dataclass(frozen=True)
class PlanFormat:
    """A format of plans.

    `sniff` tells by its content whether a file is of this format; the first that says yes reads
    it: `read` gives the house, or InputError for a fault that can't be repaired. A format that
    `needs_scale` is drawn in pixels: `metres_per_pixel` must be given. Of a format whose scale may
    be given, `look` tells how large it is drawn, and the layers of DXF.
    """

    name: str
    sniff: Callable[[PlanFile], bool]
    read: Callable[[PlanFile], House]
    needs_scale: bool = False
    look: Callable[[PlanFile], Unscaled] | None = None


def _is_plan_json(plan: PlanFile) -> bool:
    """Return whether the document names this program's own format."""
    return isinstance(plan.document, dict) and str(plan.document.get("format")) == FORMAT


def _is_svg(plan: PlanFile) -> bool:
    """Return whether the text is XML whose first element is an SVG drawing."""
    return plan.text.lstrip().startswith("<") and "<svg" in plan.text[:5000]


def _read_svg(plan: PlanFile) -> House:
    """Return the house of an SVG drawing."""
    content = plan.text.encode()
    return house_of_cubicasa(content, plan.house_id, plan.metres_per_pixel, file=str(plan.path))


def _read_r2v(plan: PlanFile) -> House:
    """Return the house of raster-to-vector text, drawn in pixels."""
    return house_of_r2v(plan.text, plan.house_id, plan.metres_per_pixel or 0.0, file=str(plan.path))


#: In the order in which they are asked.
FORMATS: tuple[PlanFormat, ...] = (
    PlanFormat(
        "IFC",
        lambda plan: is_ifc(plan.head),
        lambda plan: house_of_ifc(plan.path, plan.house_id),
    ),
    PlanFormat(
        "DXF",
        lambda plan: is_dxf(plan.head),
        lambda plan: house_of_dxf(plan.path, plan.house_id, plan.metres_per_pixel, plan.dxf_layers),
        look=lambda plan: unscaled_dxf(plan.path, plan.house_id, plan.dxf_layers),
    ),
    PlanFormat(
        "plan2scene-plan JSON",
        _is_plan_json,
        lambda plan: house_of_plan(plan.document, plan.house_id, file=str(plan.path)),
    ),
    PlanFormat(
        "RoomPlan JSON",
        lambda plan: is_roomplan(plan.document),
        lambda plan: house_of_roomplan(plan.document, plan.house_id, file=str(plan.path)),
    ),
    PlanFormat(
        "ZInD JSON",
        lambda plan: is_zind(plan.document),
        lambda plan: house_of_zind(
            plan.document, plan.house_id, plan.metres_per_pixel, file=str(plan.path)
        ),
        look=lambda _: Unscaled("unit"),
    ),
    PlanFormat(
        "scene.json",
        lambda plan: plan.document is not None,
        lambda plan: house_of_scene(plan.document, plan.house_id, file=str(plan.path)),
    ),
    PlanFormat(
        "raster-to-vector text",
        lambda plan: is_r2v(plan.text),
        _read_r2v,
        needs_scale=True,
        look=lambda plan: unscaled_r2v(plan.text, plan.house_id),
    ),
    PlanFormat(
        "CubiCasa SVG",
        _is_svg,
        _read_svg,
        look=lambda plan: unscaled_svg(plan.text.encode(), plan.house_id),
    ),
    PlanFormat(
        "Sweet Home 3D",
        lambda plan: plan.binary.startswith("a ZIP") and is_sweet_home(plan.path),
        lambda plan: house_of_sweet_home(plan.path, plan.house_id),
    ),
)


def format_of(plan: PlanFile) -> PlanFormat | None:
    """Return the format of a file by its content; None for none of them."""
    return next((entry for entry in FORMATS if entry.sniff(plan)), None)


def read_plan(
    path: str | Path,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
) -> House:
    """Return the house of any plan of :data:`FORMATS`; its content tells which.

    Parameters are those of :class:`PlanFile`; a format in pixels needs its scale.
    """
    plan = PlanFile(Path(path), house_id, metres_per_pixel, dxf_layers)
    if not plan.path.is_file():
        raise plan.fault("a plan", "no such file")
    if not plan.binary and not plan.text.strip():
        raise plan.fault("a plan", "an empty file")
    found = format_of(plan)
    if found is None:
        names = ", ".join(entry.name for entry in FORMATS)
        start = plan.binary + (" (plan2scene trace makes a plan of it)" * plan.is_picture)
        start = start or f"{plan.text.split()[0][:40]!r} at its start"
        raise plan.fault(f"a plan ({names})", start)
    if found.needs_scale and not 0 < (metres_per_pixel or 0) <= 1:
        expected = f"metres_per_pixel above 0 and up to 1 for {found.name}"
        raise plan.fault(expected, str(metres_per_pixel))
    return found.read(plan)
