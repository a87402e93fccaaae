"""Read damaged and odd images; print each result and the memory that reading takes.

``python benchmarks/odd_images.py``

The files are those of tests/plan2scene/test_odd_images.py. Each is read in its own process, which
may map at most 400 MB more than before; then the masks stage takes all files as one house.
"""

from __future__ import annotations

import importlib.util
import logging
import os
import resource
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path
from types import ModuleType

READ_ONE = """
import resource, sys
from PIL import Image, ImageCms
from plan2scene.errors import InputError
from plan2scene.images import read_image
Image.init()
# Not ru_maxrss: that one begins with the parent's.
peak = lambda: int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
before = peak()
mapped = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (mapped + 400_000_000,) * 2)
try:
    image = read_image(sys.argv[1])
    what = f"read, {image.shape[1]}x{image.shape[0]}"
except InputError as error:
    what = f"expected {error.expected}, found {error.found}"
print((peak() - before) // 1024, what)
"""


def cases() -> ModuleType:
    """Return the test module, which makes the files."""
    path = Path(__file__).parents[1] / "tests" / "plan2scene" / "test_odd_images.py"
    spec = importlib.util.spec_from_file_location("odd_images_cases", path)
    if spec is None or spec.loader is None:
        raise SystemExit(f"no module {path}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def write_files(folder: Path) -> list[Path]:
    """Write every case into `folder`, and a folder named like a photo; return the paths."""
    made = cases()
    files = {name: make() for name, (make, *_) in (made.WORKS | made.FAILS).items()}
    files |= made.bombs()
    for name, data in files.items():
        (folder / name).write_bytes(data)
    for size in ((1, 1), (20000, 10)):
        made.Image.new("RGB", size).save(folder / f"{size[0]}x{size[1]}.png")
        files[f"{size[0]}x{size[1]}.png"] = b""
    (folder / "folder.jpg").mkdir()
    return [folder / name for name in [*sorted(files), "folder.jpg"]]


def main() -> None:
    """Print a line for each file, then the result of the masks stage for all of them."""
    from plan2scene.photos.labels.labeller import labeller
    from plan2scene.photos.masks import make_masks
    from plan2scene.weights import MODELS

    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    crashed, most = 0, 0
    with tempfile.TemporaryDirectory() as name:
        paths = write_files(Path(name))
        print("| file | what it gives | MB |\n|---|---|---|")
        for path in paths:
            command = [sys.executable, "-c", READ_ONE, str(path)]
            run = subprocess.run(
                command, env=environment, text=True, capture_output=True, check=False
            )
            if run.returncode:
                crashed += 1
                print(f"| {path.name} | CRASHED: {run.stderr.strip().splitlines()[-1]} | |")
                continue
            megabytes, what = run.stdout.strip().split(" ", 1)
            most = max(most, int(megabytes))
            print(f"| {path.name} | {what} | {megabytes} |")
        print(f"\n{len(paths)} files, {crashed} crashed, at most {most} MB more than before")
        logging.getLogger("plan2scene").setLevel(logging.ERROR)
        stems = {path.stem: path for path in paths}  # two photos with the same stem are refused
        warnings = make_masks(
            {path.name: path for path in stems.values()},
            partial(labeller, "embedded", model=MODELS / "segmentation.safetensors"),
            Path(name) / "masks",
            house_id="odd",
        )
        left = sum("left out" in line for line in warnings)
        print(f"masks stage: {len(stems)} photos, {left} left out with a line each")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(f"peak of the masks stage's process: {peak} MB")


if __name__ == "__main__":
    main()
