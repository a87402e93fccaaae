"""Read ZIP archives and XML from untrusted sources, within limits."""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

from plan2scene.plans.parse import Source

#: Largest number of bytes and of elements of an XML document.
MAX_XML_BYTES = 64_000_000
MAX_XML_ELEMENTS = 500_000
#: Largest number of an archive's entries that are looked at.
MAX_ENTRIES = 50_000


def zip_names(path: Path) -> list[str] | None:
    """Return the names in a ZIP archive; None if the file is no readable archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            return [entry.filename for entry in archive.infolist()[:MAX_ENTRIES]]
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return None


def zip_entry(source: Source, path: Path, name: str) -> bytes:
    """Return one entry of a ZIP archive; no more than `MAX_XML_BYTES` are unpacked."""
    try:
        with zipfile.ZipFile(path) as archive, archive.open(name) as entry:
            content = entry.read(MAX_XML_BYTES + 1)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, zlib.error) as error:
        raise source.fault(f"a readable {name} in the archive", str(error) or "damage") from None
    if len(content) > MAX_XML_BYTES:
        raise source.fault(f"at most {MAX_XML_BYTES} bytes of {name}", "more")
    return content


def parse_xml(source: Source, content: bytes, *, doctype: bool = False) -> Element:
    """Return the root of an XML document.

    Entities and external references are refused. A DOCTYPE is refused unless `doctype` is set.
    """
    from defusedxml import DefusedXmlException
    from defusedxml.ElementTree import fromstring

    if len(content) > MAX_XML_BYTES:
        raise source.fault(f"at most {MAX_XML_BYTES} bytes of XML", len(content))
    if content.count(b"<") > 2 * MAX_XML_ELEMENTS:
        raise source.fault(f"at most {MAX_XML_ELEMENTS} XML elements", "more")
    try:
        # All at once: fed in pieces, a long attribute takes time by the square of its length.
        root: Element = fromstring(content, forbid_dtd=not doctype)
    except DefusedXmlException as error:
        raise source.fault("XML without entities or outside references", repr(error)) from None
    except (ParseError, LookupError, ValueError) as error:
        raise source.fault("XML", f"a syntax error ({error})") from None
    return root


def attribute(
    source: Source, element: Element, name: str, default: float | None = None, *, scale: float = 1.0
) -> float:
    """Return an attribute's number times `scale`; `default` times `scale` if it is absent."""
    text = element.get(name)
    what = f"{name} of {element.tag[-40:]} {(element.get('id') or '')[:60]}".strip()
    if text is None:
        if default is None:
            raise source.fault(f"a number for {what}", "nothing")
        return default * scale
    try:
        value = float(text)
    except ValueError:
        raise source.fault(f"a number for {what}", repr(text)) from None
    return source.number(value * scale if math.isfinite(value) else value, what)
