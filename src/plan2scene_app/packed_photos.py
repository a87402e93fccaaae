"""Where photos lie: in a folder with its folders, a ZIP archive, or a PDF such as a brochure."""

from __future__ import annotations

import importlib
import os
import re
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from itertools import takewhile
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.images import MAX_IMAGE_BYTES, MAX_PIXELS
from plan2scene.io import safe_join
from plan2scene_app.out_folder import is_out_folder
from plan2scene_app.pdf import is_pdf, opened

#: Shortest side in pixels of a photo in a PDF: smaller pictures are logos and portraits.
LEAST_SIDE = 300
#: Largest number of pages, of photos, and of bytes of all photos of a ZIP archive.
MOST_PAGES, MOST_PHOTOS, MOST_BYTES = 100, 500, 4_000_000_000
#: How deep a picture may lie in groups of a page's objects.
_DEPTH = 5
#: Largest number of files below a folder of photos: who gives a whole disk gets one line.
MOST_FILES = 5000
_JPEG_QUALITY = 95
#: Flag of an entry of a ZIP archive: its name is UTF-8.
_UTF8 = 0x800


def is_packed(path: Path | None) -> bool:
    """Return whether a path is a PDF or a ZIP archive, by its content."""
    return path is not None and path.is_file() and (is_pdf(path) or zipfile.is_zipfile(path))


def photo_files(folder: Path) -> dict[str, Path]:
    """Return the files in a folder and its folders by their names as photos, sorted.

    The name of a file in a folder begins with the folder's: ``kitchen_1.jpg`` for
    ``kitchen/1.jpg``. Characters that no name of a photo may have become ``_``. Hidden files and
    folders and the results of ``plan2scene run`` are left out. InputError for more than
    `MOST_FILES` files.
    """
    files: dict[str, Path] = {}
    for place, folders, names in os.walk(folder):
        at = Path(place)
        folders[:] = [
            name for name in folders if not name.startswith(".") and not is_out_folder(at / name)
        ]
        for name in sorted(names):
            if not name.startswith(".") and (at / name).is_file():
                files.setdefault(_name_of((at / name).relative_to(folder).parts), at / name)
        if len(files) > MOST_FILES:
            expected = f"at most {MOST_FILES} files in a folder of photos and its folders"
            raise InputError(expected, "more", file=folder)
    return dict(sorted(files.items()))


def _name_of(parts: Sequence[str]) -> str:
    """Return a photo's name made of the names of its folders and its own."""
    return re.sub(r'[\\:*?"<>|{}\x00-\x1f]', "_", "_".join(parts)).strip()


@contextmanager
def unpacked(photos: Path | None) -> Iterator[Path | None]:
    """Yield a folder of photos: a new, temporary one for a PDF or ZIP, else the path as it is."""
    if photos is None or not is_packed(photos):
        yield photos
        return
    with tempfile.TemporaryDirectory() as temporary:
        # Messages name files in it: people know the name of the archive.
        folder = Path(temporary, photos.name)
        folder.mkdir()
        if not unpack_photos(photos, folder):
            expected = f"photos, in a PDF of at least {LEAST_SIDE} pixels a side"
            raise InputError(expected, "none", file=photos)
        try:
            yield folder
        except InputError as error:
            if temporary not in str(error):
                raise
            raise InputError(error.expected, error.found, file=photos) from None


def unpack_photos(source: Path, folder: Path) -> list[Path]:
    """Write the photos of a PDF or ZIP archive into a folder; return their paths.

    Pictures of a PDF are named ``page01_1.jpg`` and so on; small ones are left out, and those of
    more than `MAX_PIXELS`. Files of an archive keep their names, with the folders that differ.
    InputError for a damaged file, and for one that holds too much.
    """
    return _of_pdf(source, folder) if is_pdf(source) else _of_zip(source, folder)


def _of_pdf(source: Path, folder: Path) -> list[Path]:
    pictures = [importlib.import_module("pypdfium2").raw.FPDF_PAGEOBJ_IMAGE]
    written: list[Path] = []
    if source.stat().st_size > MAX_IMAGE_BYTES:
        raise InputError(f"a PDF of at most {MAX_IMAGE_BYTES} bytes", "a larger one", file=source)
    with opened(source) as document:
        for number in range(min(len(document), MOST_PAGES)):
            with closing(document[number]) as page:
                for place, picture in enumerate(page.get_objects(pictures, max_depth=_DEPTH), 1):
                    width, height = picture.get_px_size()
                    if min(width, height) < LEAST_SIDE or width * height > MAX_PIXELS:
                        continue
                    if len(written) == MOST_PHOTOS:
                        return written
                    path = folder / f"page{number + 1:02d}_{place}.jpg"
                    image = picture.get_bitmap().to_pil().convert("RGB")
                    image.save(path, quality=_JPEG_QUALITY)
                    written.append(path)
    return written


def _of_zip(source: Path, folder: Path) -> list[Path]:
    written: dict[Path, None] = {}
    total = 0
    try:
        with zipfile.ZipFile(source) as archive:
            parts = {entry: _parts(entry) for entry in archive.infolist() if _is_of_user(entry)}
            if len(parts) > MOST_PHOTOS:
                raise InputError(f"at most {MOST_PHOTOS} photos", f"{len(parts)}", file=source)
            folders = zip(*(names[:-1] for names in parts.values()), strict=False)
            shared = sum(1 for _ in takewhile(lambda level: len(set(level)) == 1, folders))
            for entry, names in parts.items():
                name = _name_of(names[shared:])
                path = safe_join(folder, name, file=source)
                with archive.open(entry) as file:
                    content = file.read(MAX_IMAGE_BYTES + 1)
                total += len(content)
                if len(content) > MAX_IMAGE_BYTES or total > MOST_BYTES:
                    expected = f"photos of at most {MAX_IMAGE_BYTES} bytes, {MOST_BYTES} in all"
                    raise InputError(expected, f"more in {name}", file=source)
                path.write_bytes(content)
                written[path] = None
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, zlib.error) as error:
        raise InputError("a ZIP archive that can be read", str(error), file=source) from None
    return list(written)


def _parts(entry: zipfile.ZipInfo) -> list[str]:
    """Return the names of an entry's folders and its own."""
    name = entry.filename
    if not entry.flag_bits & _UTF8:  # many programs write UTF-8 without saying so
        with suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")
    return [part for part in re.split(r"[/\\]", name) if part.strip(". ")]


def _is_of_user(entry: zipfile.ZipInfo) -> bool:
    """Return whether an entry is a file that the user put in, none of the operating system's."""
    hidden = any(part.startswith((".", "__MACOSX")) for part in _parts(entry))
    return not entry.is_dir() and not hidden and bool(_parts(entry))
