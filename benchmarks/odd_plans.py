"""Read files that are no plans or too large with the command line, for robustness.md of the docs.

python benchmarks/odd_plans.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from plan2scene.images import write_png
from plan2scene_workshop.plans.views import other_drawing

ROOT = Path(__file__).parents[1]
LAUGHS = "<!DOCTYPE h [<!ENTITY a 'aaaaaaaaaa'>{}]>".format(
    "".join(f"<!ENTITY {b} '{f'&{a};' * 10}'>" for a, b in zip("abcdefgh", "bcdefghi", strict=True))
)


def zip_bomb(path: Path) -> None:
    """Write an archive of 2 MB with a Home.xml of 2 GB of blanks."""
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("Home.xml", "w", force_zip64=True) as entry,
    ):
        for _ in range(200):
            entry.write(b" " * 10_000_000)


def laughing_home(path: Path) -> None:
    """Write a Home.xml with nested entities that expand to a billion letters."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("Home.xml", f"{LAUGHS}<home name='&i;'/>")


def laughing_svg(path: Path) -> None:
    """Write the same entities as an SVG drawing."""
    path.write_text(f"{LAUGHS}<svg><g class='Space Bath'><text>&i;</text></g></svg>")


def solid_dxf(path: Path) -> None:
    """Write a drawing of 20,000 splines and 3D faces on layers of walls."""
    import ezdxf

    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = 6
    space, rng = document.modelspace(), np.random.default_rng(0)
    for _ in range(10_000):
        corners = rng.uniform(0, 10, (4, 3)).tolist()
        space.add_spline(corners, dxfattribs={"layer": "WALL"})
        space.add_3dface(corners, dxfattribs={"layer": "WALL"})
    document.saveas(path)


def empty_ifc(path: Path) -> None:
    """Write a model that has a project and nothing else."""
    import ifcopenshell

    model = ifcopenshell.file(schema="IFC4")
    model.create_entity("IfcProject", GlobalId="0" * 22)
    model.write(str(path))


def photo(path: Path) -> None:
    """Write a photo of the demo in place of a plan."""
    source = next((ROOT / "resources/demo/photos").glob("*.jpg"))
    path.write_bytes(source.read_bytes())


def large_picture(path: Path) -> None:
    """Write a drawn plan of 12,000 x 9,000 pixels."""
    drawn = other_drawing(1, 7, 60.0, held_out=False)
    cv2.imwrite(str(path), cv2.resize(drawn.image[..., ::-1], (12_000, 9_000)))


def huge_picture(path: Path) -> None:
    """Write an empty page of 20,000 x 20,000 pixels of one bit."""
    Image.new("1", (20_000, 20_000), 1).save(path)


def empty_page(path: Path) -> None:
    """Write a white page."""
    write_png(path, np.full((1600, 1200, 3), 255, np.uint8))


def letter(path: Path) -> None:
    """Write a page of text."""
    image = np.full((1400, 1000, 3), 255, np.uint8)
    for row in range(28):
        text = "A page of text alone, no 4.2 x 3 m kitchen in it"
        cv2.putText(image, text, (60, 90 + 45 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.9, (0, 0, 0), 2)
    write_png(path, image)


#: Name of the case: the file's name, the function that writes it, the command that reads it.
CASES: dict[str, tuple[str, Callable[[Path], None], str]] = {
    "zip bomb (2 GB in 2 MB)": ("home.sh3d", zip_bomb, "check"),
    "XML entities, Sweet Home 3D": ("home.sh3d", laughing_home, "check"),
    "XML entities, SVG": ("plan.svg", laughing_svg, "check"),
    "DXF of 20,000 splines and 3D faces": ("plan.dxf", solid_dxf, "check"),
    "IFC without spaces and walls": ("plan.ifc", empty_ifc, "check"),
    "a photo": ("plan.jpg", photo, "trace"),
    "a plan of 12,000 x 9,000 pixels": ("plan.png", large_picture, "trace"),
    "an empty page of 20,000 x 20,000 pixels": ("plan.png", huge_picture, "trace"),
    "an empty page": ("plan.png", empty_page, "trace"),
    "text alone": ("plan.png", letter, "trace"),
}


#: Runs the command line in a folder and writes the peak of its memory to a file.
PROGRAM = """
import atexit, os, sys
from pathlib import Path
def peak():
    lines = Path("/proc/self/status").read_text().splitlines()
    Path("peak").write_text(next(line for line in lines if line.startswith("VmHWM")))
atexit.register(peak)
from plan2scene_app.cli import main
main()
"""


def run(command: str, plan: Path, folder: Path) -> tuple[int, str, float, float]:
    """Return exit code, error line, seconds and peak MiB of a command on a plan."""
    arguments = [command, plan.name, *(["--out", "out/plan.json"] if command == "trace" else [])]
    started = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    seconds = time.perf_counter() - started
    lines = [line for line in done.stdout.splitlines() if line.lower().startswith("error")]
    peak = int((folder / "peak").read_text().split()[1]) / 1024
    return done.returncode, " ".join(lines), seconds, peak


def main() -> None:
    """Print the table."""
    print("| plan | exit code | said | s | peak MiB | files written |")
    print("|---|---|---|---|---|---|")
    for what, (name, write, command) in CASES.items():
        with tempfile.TemporaryDirectory() as base:
            folder = Path(base)
            write(folder / name)
            (folder / "out").mkdir()
            code, line, seconds, peak = run(command, folder / name, folder)
            line = "expected " + line.split("expected ")[-1] if line else "read"
            made = [p.name for p in (folder / "out").iterdir()]
            strange = {p.name for p in folder.iterdir()} - {name, "out", "peak"}
            count = f"{len(made)}" + (f", and {strange}" if strange else "")
            print(
                f"| {what} | {code} | {line} | {seconds:.1f} | {peak:.0f} | {count} |", flush=True
            )


if __name__ == "__main__":
    main()
