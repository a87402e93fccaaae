"""The plan formats: one registry, which :func:`read_plan` and its messages follow.

A format is an entry point of the group :data:`GROUP` that names a :class:`PlanFormat`. Formats of
other packages are found in the same way (docs/extending.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import read_text
from plan2scene.plans.parse import parse_json
from plan2scene.plugins import code_of, installed, plugins

#: Entry points of this group name a :class:`PlanFormat`.
GROUP = "plan2scene.plan_formats"
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
class Unscaled:
    """What is known of a drawing before its scale is."""

    unit: str  #: pixel or unit
    size: tuple[float, float] | None = None  #: width and depth of what is drawn, in its unit
    names: tuple[Any, ...] = ()  #: layers and blocks of DXF


@dataclass(frozen=True)
class PlanFormat:
    """A format of plans.

    `sniff` decides by its content whether a file is of this format; the first that accepts it reads
    it: `read` gives the house, or InputError for a fault that can't be repaired. Formats that are
    a `fallback` are asked after all others. A format that `needs_scale` is drawn in pixels:
    `metres_per_pixel` must be given. Of a format whose scale may be given, `look` tells how large
    it is drawn, and the layers of DXF. `suffixes` are the file names' usual ends, lower case.
    `needs` is what pip installs for it beside its own package's dependencies.
    """

    name: str
    sniff: Callable[[PlanFile], bool]
    read: Callable[[PlanFile], House]
    suffixes: tuple[str, ...] = ()
    needs_scale: bool = False
    fallback: bool = False
    look: Callable[[PlanFile], Unscaled] | None = None
    needs: str = ""


def plan_formats() -> tuple[PlanFormat, ...]:
    """Return all registered formats in the order in which they are asked."""
    return tuple(sorted(plugins(GROUP, PlanFormat).values(), key=lambda item: item.fallback))


def reader_code(suffix: str) -> list[str]:
    """Return what changes when the code of a reader does that a file with this suffix can have."""
    named = [item.name for item in plan_formats() if suffix in item.suffixes]
    return code_of(GROUP, PlanFormat, *(named or plugins(GROUP, PlanFormat)))


def format_of(plan: PlanFile) -> PlanFormat | None:
    """Return the format of a file by its content; None for none of them."""
    return next((entry for entry in plan_formats() if entry.sniff(plan)), None)


def read_plan(
    path: str | Path,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
) -> House:
    """Return the house of any plan of :func:`plan_formats`; its content tells which.

    Parameters are those of :class:`PlanFile`; a format in pixels needs its scale.
    """
    plan = PlanFile(Path(path), house_id, metres_per_pixel, dxf_layers)
    if not plan.path.is_file():
        raise plan.fault("a plan", "no such file")
    if not plan.binary and not plan.text.strip():
        raise plan.fault("a plan", "an empty file")
    plan_format = format_of(plan)
    if plan_format is None:
        names = ", ".join(entry.name for entry in plan_formats())
        start = plan.binary + (" (plan2scene trace makes a plan of it)" * plan.is_picture)
        start = start or f"{plan.text.split()[0][:40]!r} at its start"
        raise plan.fault(f"a plan ({names})", start)
    if plan_format.needs_scale and not 0 < (metres_per_pixel or 0) <= 1:
        expected = f"metres_per_pixel above 0 and up to 1 for {plan_format.name}"
        raise plan.fault(expected, str(metres_per_pixel))
    with installed(plan_format.needs, house_id):
        return plan_format.read(plan)
