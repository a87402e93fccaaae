"""A plan on disk (:class:`PlanFile`), and the functions of a plan format (:class:`PlanFormat`)."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import read_text
from plan2scene.plans.parse import parse_json

#: First bytes of files that are not text, and what such a file is.
_SIGNATURES = (
    (b"PK\x03\x04\n\0\0\0\0\0", "a ZIP archive (of USDZ? Scanners save RoomPlan JSON beside it)"),
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
    (b"glTF", "a GLB model"),
)


#: The start of an SVG, and what shows that it names its rooms and walls, as those of CubiCasa do.
_SVG = re.compile(rb"<svg[\s>]")
_OF_PLANS = re.compile(rb"\b(?:class|id)\s*=\s*[\"'](?:Space|Wall)\b")


#: JSON plans above this many bytes are refused: parsed, they take twenty times the memory.
MAX_JSON_BYTES = 32_000_000


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
        if self.path.exists() and not self.path.is_file():
            raise self.fault("a file", "a folder" if self.path.is_dir() else "no plain file")
        try:
            with self.path.open("rb") as file:
                return file.read(4096)
        except OSError as error:
            raise self.fault("a readable file", error.strerror or "an error") from None

    @cached_property
    def binary(self) -> str:
        """The kind of a file that is no text of a plan, by its first bytes; empty for such text."""
        if self.head[4:8] == b"ftyp":
            return "a HEIC or AVIF picture"
        kind = next((name for start, name in _SIGNATURES if self.head.startswith(start)), "")
        if not kind and _SVG.search(self.head) and not _OF_PLANS.search(self.path.read_bytes()):
            return "an SVG picture"
        if self.head.startswith(b"PK") and not zipfile.is_zipfile(self.path):
            return "a damaged file of Sweet Home 3D or another ZIP archive"
        return kind or "a binary file" * (b"\0\0" in self.head)

    @property
    def is_picture(self) -> bool:
        """Whether it is a picture, also an SVG, or a PDF, from which a plan has to be traced."""
        return self.binary.endswith("picture") or self.binary == "a PDF"

    @cached_property
    def text(self) -> str:
        """The UTF-8 text; empty for a :attr:`binary` file, and for a DXF in another encoding."""
        try:
            return "" if self.binary else read_text(self.path)
        except InputError as error:
            if b"SECTION" in self.head.split()[:40]:  # its reader knows the code pages of DXF
                return ""
            raise self.fault(error.expected, error.found) from None

    @cached_property
    def document(self) -> Any:
        """The parsed JSON; None if the text is no JSON (a syntax error is an InputError)."""
        if not self.text.lstrip().startswith(("{", "[")):
            return None
        size = len(self.text.encode())
        if size > MAX_JSON_BYTES:
            raise self.fault(f"at most {MAX_JSON_BYTES} bytes of JSON", str(size))
        return parse_json(self.text, self.path, self.house_id)

    def fault(self, expected: str, found: str) -> InputError:
        """Return (not raise) the error of a fault of this file."""
        return InputError(expected, found, file=self.path, house=self.house_id)


@dataclass(frozen=True)
class Unscaled:
    """What is known about a drawing whose scale is not known."""

    unit: str  #: pixel or unit
    size: tuple[float, float] | None = None  #: width and depth of what is drawn, in its unit
    names: tuple[Any, ...] = ()  #: layers and blocks of DXF


@dataclass(frozen=True)
class PlanFormat:
    """A format of plans.

    `sniff` decides by a file's content whether it is of this format. The first format that accepts
    it reads it: `read` returns the house, or raises InputError for a fault that can't be repaired.
    Formats that are a `fallback` are tried after all others. A format that `needs_scale` is drawn
    in pixels: `metres_per_pixel` must be given. If the scale of a format may be given, `look`
    returns the size of the drawing, and the layers of DXF. `suffixes` are the usual ends of file
    names, lower case. `needs` is what pip installs for it, beyond its own package's dependencies.
    `lacks_heights` returns, by a file's first bytes, whether its plan may lack ceiling heights.
    """

    name: str
    sniff: Callable[[PlanFile], bool]
    read: Callable[[PlanFile], House]
    suffixes: tuple[str, ...] = ()
    needs_scale: bool = False
    fallback: bool = False
    look: Callable[[PlanFile], Unscaled] | None = None
    needs: str = ""
    lacks_heights: Callable[[PlanFile], bool] = lambda _: False
