"""Make one house from a user's files: a data set of one house, Snakemake, results copied out."""

from __future__ import annotations

import csv
import filecmp
import io
import logging
import shutil
import sys
import tempfile
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from plan2scene.datasets.assignments import read_assignment
from plan2scene.errors import InputError, WorkflowError
from plan2scene.images import MAX_PHOTO_PIXELS, decode_image, png_bytes, to_small_srgb
from plan2scene.io import absent, atomic_path, safe_join, write_text
from plan2scene.photos.labels.imagenet import imagenet_installed
from plan2scene.plans.formats import read_plan
from plan2scene.plans.plan_file import PlanFile
from plan2scene.plans.validate import validate_house
from plan2scene.provenance import WORKFLOW
from plan2scene_app.bound_process import run_bound
from plan2scene_app.check import photo_problem
from plan2scene_app.finishes import finishes_file, read_finishes
from plan2scene_app.out_folder import DATASET_FOLDER, OutFolder, changed_by_hand, claimed_folder
from plan2scene_app.packed_photos import photo_files, unpacked
from plan2scene_app.panoramas import FOV_DEG, cut_panoramas, panorama_of
from plan2scene_app.tracing.picture import paper_share, read_plan_picture
from plan2scene_app.tracing.settings import SETTINGS
from plan2scene_app.workflow.house_table import COLUMNS

_LOG = logging.getLogger("plan2scene")
DATASET = "own"
#: Values of ``house.colours``: paint without light, or colours as the photos show them.
HOUSE_COLOURS = ("paint", "photo")
#: Values of ``house.walls``: all walls of a room share a texture, or accent walls have their own.
HOUSE_WALLS = ("room", "wall")
#: Sides of a tile, in pixels, that the configuration allows.
TEXTURE_SIZES = (128, 256, 512)
#: Files of the house that are delivered to the user.
DELIVERED: tuple[str, ...] = (
    "house.glb",
    "house.scene.json",
    "preview.png",
    "rooms.jpg",
    "viewer.html",
)
#: The table of the photos' rooms, which the user can correct.
PHOTO_TABLE = "photos.csv"
#: Further files if there are photos: the house seen from the photos' places, the floors' patterns,
#: the contact sheet, the page of doubts, and the table.
OF_PHOTOS: tuple[str, ...] = (
    "views.jpg",
    "patterns.jpg",
    "contact_sheet.png",
    "doubts.html",
    PHOTO_TABLE,
)
#: Snakemake options by what is printed of the progress: nothing, a line for each job (a bar on a
#: terminal), or everything.
PRINTED = {
    "quiet": ("--quiet", "all"),
    "lines": ("--logger", "plan2scene"),
    "verbose": ("--printshellcmds",),
}
#: Further files if the plan is a picture.
TRACED = ("plan.json", "plan.overlay.png", "plan.doubts.txt")


@dataclass(frozen=True)
class SingleHouse:
    """The user's files and settings for one house."""

    plan: Path
    photo_table: Path | None
    #: Folder of the photos in the table (default: the table's folder), or a ZIP or PDF with them.
    #: Without a table, all photos in it are used.
    photos_dir: Path | None
    house: str
    method: str
    metres_per_pixel: float | None
    seed: int
    texture_size: int
    colours: str = "paint"
    walls: str = "wall"
    dxf_layers: Mapping[str, str] | None = None
    #: Field of view of the photos along their longer side, degrees; None if it is estimated.
    fov_deg: float | None = None
    #: The house's name for people; empty if it is the same as `house`, the id.
    name: str = ""
    #: Further pictures: each shows another storey of the home.
    storeys: tuple[Path, ...] = ()
    #: Photo table of an earlier run that the user changed: its rooms override `photo_table`.
    corrections: Path | None = None
    #: Files of the views of each 360-degree photo, by name; see `panoramas.cut_panoramas`.
    views: Mapping[str, Mapping[str, Path]] = field(default_factory=dict)


def is_picture(request: SingleHouse) -> bool:
    """Return whether the plan is a picture, which the workflow traces first."""
    return PlanFile(request.plan, request.house).is_picture


def plan_files(request: SingleHouse) -> tuple[Path, ...]:
    """Return the plan, or the pictures of all storeys."""
    return (request.plan, *request.storeys)


def read_input(request: SingleHouse) -> list[str]:
    """Read plan and photos, so that errors are found before any job; return the photos' names."""
    house = None
    if finishes_file(request.plan).is_file():
        read_finishes(finishes_file(request.plan))
        if request.colours != "paint":
            _LOG.warning("%s is left out: the colours are the photos'", finishes_file(request.plan))
    if request.storeys:
        if request.metres_per_pixel:
            found = f"--metres-per-pixel {request.metres_per_pixel:g}"
            raise InputError("pictures of single storeys without a scale", found, file=request.plan)
        read: list[Path] = []
        for path in plan_files(request):
            if not PlanFile(path, request.house).is_picture:
                raise InputError("a picture of each storey", "a plan of another format", file=path)
            read_plan_picture(path)
            if any(filecmp.cmp(path, other, shallow=False) for other in read):
                raise InputError("another picture for each storey", "the same twice", file=path)
            read.append(path)
    elif is_picture(request):
        read_plan_picture(request.plan)
    else:
        house = read_plan(request.plan, request.house, request.metres_per_pixel, request.dxf_layers)
        for line in validate_house(house, file=request.plan):
            _LOG.warning("%s", line)
    if request.corrections is not None and house is not None:
        read_assignment(request.corrections, house, house_id=request.house)
    if request.photo_table is not None:
        if request.photos_dir is not None and not request.photos_dir.is_dir():
            raise InputError("the folder of the photos", "no such folder", file=request.photos_dir)
        if kind := PlanFile(request.photo_table, request.house).binary:
            raise InputError("a folder of photos, or a table", kind, file=request.photo_table)
        rows = read_assignment(request.photo_table, house, house_id=request.house)
        names = sorted({row.photo for row in rows})
        if not names:
            empty = InputError("at least one photo", "none", file=request.photo_table)
            _LOG.warning("%s", empty)
    elif request.photos_dir is not None:
        names = photos_in(request.photos_dir, plan_files(request))
    else:
        return []
    names = list(dict.fromkeys(view for name in names for view in request.views.get(name, [name])))
    faults: dict[str, InputError] = {}
    paths = _photo_paths(request, names)
    for name, path in paths.items():
        try:
            photo_problem(path, house_id=request.house)
            if panorama_of(path) is not None:
                expected = f"a panorama that shows {FOV_DEG:g} degrees, also up and down"
                raise InputError(expected, "a narrower one", file=path, house=request.house)
        except InputError as error:
            faults[name] = error
    if names and len(faults) == len(names):
        name, first = next(iter(faults.items()))
        what = f"none of {len(names)}; the first, {paths[name]}: {first.found}"
        source = request.photo_table or request.photos_dir or ""
        raise InputError("a photo that can be read", what, file=source)
    for fault in faults.values():
        _LOG.warning("%s", fault)
    if faults:
        _LOG.warning("%d of %d photos are used", len(names) - len(faults), len(names))
    # What a table names stays: the workflow says of it, too, why it is left out.
    return names if request.photo_table else [name for name in names if name not in faults]


def _views(request: SingleHouse, folder: Path) -> dict[str, dict[str, Path]]:
    """Cut the 360-degree photos of a request into views in a folder (`cut_panoramas`)."""
    if request.photos_dir is not None and request.photos_dir.is_dir():
        photos = photo_files(request.photos_dir)
    elif request.photo_table is not None and request.photo_table.is_file():
        rows = read_assignment(request.photo_table, house_id=request.house)
        photos = _photo_paths(request, sorted({row.photo for row in rows}))
    else:
        return {}
    return cut_panoramas(photos, folder, request.fov_deg or FOV_DEG)


def photos_in(folder: Path, plans: Collection[Path]) -> list[str]:
    """Return the names of the photos in a folder and its folders, sorted (see `photo_files`).

    Hidden files, the `plans`, repeated photos, drawings and pages are left out. InputError if there
    is no such folder or no photo in it.
    """
    if not folder.is_dir():
        raise InputError("a folder of photos, or a photo table", absent(folder), file=folder)
    files = photo_files(folder)
    photo_by_stem: dict[str, str] = {}
    # Of files that differ in their extension alone, the photo counts, not its video or raw data.
    for name, path in sorted(files.items(), key=lambda item: -_pixels(item[1])):
        if any(map(path.samefile, plans)):
            continue
        photos = photo_by_stem.values()
        same = [old for old in photos if filecmp.cmp(files[old], path, shallow=False)]
        stem = Path(name).stem
        if same:
            _LOG.warning("photo %s left out: %s is the same", name, same[0])
        elif stem in photo_by_stem:
            why = "has the same name before the extension"
            _LOG.warning("photo %s left out: %s %s", name, photo_by_stem[stem], why)
        elif is_page(path):
            why = "a drawing or a page, no photo; a photo table that names it keeps it"
            _LOG.warning("photo %s left out: %s", name, why)
        else:
            photo_by_stem[stem] = name
    if not photo_by_stem:
        raise InputError("a folder of photos", "no photo in it", file=folder)
    return sorted(photo_by_stem.values())


def _pixels(path: Path) -> int:
    """Return the number of a photo's pixels; 0 if it cannot be read."""
    try:
        photo_problem(path)
        return decode_image(
            path, lambda image: image.width * image.height, max_pixels=MAX_PHOTO_PIXELS
        )
    except InputError:
        return 0


def is_page(path: Path) -> bool:
    """Return whether a file is a picture that is mostly paper; False if it cannot be read."""
    try:
        image = decode_image(path, partial(to_small_srgb, side=SETTINGS.page_side_px))
    except InputError:
        return False
    return paper_share(image) >= SETTINGS.page_paper


def _photo_paths(request: SingleHouse, names: list[str]) -> dict[str, Path]:
    """Return the paths of the request's photos by name, also of those that are missing."""
    table = request.photo_table
    folder = request.photos_dir or (table.parent if table else Path())
    files = photo_files(folder) if request.photos_dir and folder.is_dir() else {}
    for views in request.views.values():
        files |= views
    paths = {}
    for name in names:
        path = safe_join(folder, name, file=table or folder, house_id=request.house)
        paths[name] = path if path.is_file() else files.get(name, path)
    return paths


def prepare(request: SingleHouse, names: list[str], work: Path) -> Path:
    """Write a data set of one house with these photos under `work`; return its config file.

    Photos that are missing are not copied; the house is made without them.
    """
    root = work / DATASET_FOLDER
    photos = root / "photos"
    photos.mkdir(parents=True, exist_ok=True)
    suffix = ".png" if is_picture(request) else request.plan.suffix or ".json"
    plan = root / f"plan{suffix}"
    if request.storeys:
        from plan2scene_app.tracing.drawings import page_of_storeys

        _write_changed(png_bytes(page_of_storeys(plan_files(request))), plan)
    else:
        _copy_changed(request.plan, plan)
    _copy_finishes(request.plan, plan)
    assignment = ""
    if request.photo_table is not None or names:
        _copy_photos(names, photos, request)
        assignment = "photoroom.csv"
    if request.photo_table is not None and not (request.views or request.corrections):
        _copy_changed(request.photo_table, root / assignment)
    elif assignment:
        _write_changed(_table_of(names, request).encode(), root / assignment)
    with (root / "houses.tsv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter="\t", lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerow([request.house, "test", plan.name, assignment, "|".join(names)])
    return _write_config(request, root, work)


def _copy_finishes(plan: Path, copy: Path) -> None:
    """Copy the finishes that lie beside the plan; without any, remove those of an earlier run."""
    source, target = finishes_file(plan), finishes_file(copy)
    if source.is_file():
        _copy_changed(source, target)
    else:
        target.unlink(missing_ok=True)


def _table_of(names: list[str], request: SingleHouse) -> str:
    """Return the text of a photo table (CSV) of these photos, with the rooms that the user gave.

    Views have the rooms of their 360-degree photo.
    """
    rooms: dict[str, list[str]] = {}
    for source in filter(None, (request.photo_table, request.corrections)):
        given: dict[str, list[str]] = {}
        for row in read_assignment(source, house_id=request.house):
            for name in request.views.get(row.photo, [row.photo]):
                given.setdefault(name, []).append(row.room_id)
        rooms |= {name: ids for name, ids in given.items() if any(ids)}
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["room_id", "photo"])
    table.writerows([room, name] for name in names for room in rooms.get(name, [""]))
    return text.getvalue()


def _write_changed(content: bytes, target: Path) -> None:
    """Write a file, unless the target already has this content."""
    if not target.is_file() or target.read_bytes() != content:
        with atomic_path(target) as temporary:
            temporary.write_bytes(content)


def _copy_photos(names: list[str], target: Path, request: SingleHouse) -> None:
    """Copy the photos that exist; remove the copies of those that no longer exist."""
    for name, path in _photo_paths(request, names).items():
        copy = safe_join(target, name)
        if path.is_file():
            _copy_changed(path, copy)
        else:
            copy.unlink(missing_ok=True)


def _copy_changed(source: Path, target: Path) -> None:
    """Copy a file, unless the target already has the same content.

    The copy's time is now, not that of the source. So the workflow makes everything that depends on
    it again, even if an older file replaces a newer one.
    """
    if target.is_file() and filecmp.cmp(source, target, shallow=False):
        return
    with atomic_path(target) as temporary:
        shutil.copyfile(source, temporary)


def shipped_config() -> dict[str, Any]:
    """Return the demo's configuration: ``advanced.yaml``, overridden by ``config.yaml``."""
    import yaml

    advanced, config = (
        yaml.safe_load((WORKFLOW / "config" / f"{name}.yaml").read_text(encoding="utf-8"))
        for name in ("advanced", "config")
    )
    sections = {key: value for key, value in config.items() if isinstance(value, dict)}
    return (
        advanced | config | {key: advanced.get(key, {}) | value for key, value in sections.items()}
    )


def _write_config(request: SingleHouse, root: Path, work: Path) -> Path:
    """Write the run's configuration: the shipped one, changed for this request."""
    import yaml

    config = shipped_config()
    config["dataset"] |= {
        "name": DATASET,
        "root": str(root.relative_to(work)),
        "table": "houses.tsv",
        "splits": ["test"],
    }
    config["seed"] = request.seed
    config["drops"] = [0.0]
    house = {"method": request.method, "colours": request.colours, "walls": request.walls}
    config["house"] |= house
    config["photos"]["known_fov_deg"] = request.fov_deg
    config["photos"]["masks"] = "imagenet" if imagenet_installed() else "embedded"
    config["floorplans"]["metres_per_pixel"] = request.metres_per_pixel
    config["floorplans"]["warn"] = False  # `read_input` tells them with the user's paths
    config["floorplans"]["dxf_layers"] = dict(request.dxf_layers or {}) or None
    config["floorplans"]["names"] = (
        None if request.name in ("", request.house) else {request.house: request.name}
    )
    config["textures"]["size_px"] = request.texture_size
    path = work / "config.yaml"
    write_text(path, yaml.safe_dump(config, sort_keys=False))
    return path


def run(
    request: SingleHouse,
    out: Path,
    *,
    cores: int,
    printed: str = "lines",
    events: Path | None = None,
    first: tuple[str, ...] = (),
) -> dict[str, Path]:
    """Make one house with Snakemake under `out`; return the delivered files by name.

    The same call continues a run that was killed. Raises InputError for errors of the input and
    WorkflowError if the workflow fails.

    Parameters
    ----------
    printed : str
        What is printed of the progress, a key of :data:`PRINTED`.
    events : path, optional
        File to which the logger appends its events; only with `printed` ``lines``.
    first : tuple of str
        Names of :data:`DELIVERED` that are made and delivered before the others.
    """
    if not (WORKFLOW / "Snakefile").is_file():
        raise WorkflowError(f"this installation lacks the workflow: no Snakefile in {WORKFLOW}")
    if request.texture_size not in TEXTURE_SIZES:
        raise InputError(f"a texture size of {TEXTURE_SIZES} pixels", str(request.texture_size))
    sources = (*plan_files(request), request.photo_table, request.photos_dir)
    inputs = [path for path in sources if path is not None]
    with unpacked(request.photos_dir) as photos_dir, tempfile.TemporaryDirectory() as views:
        request = replace(request, photos_dir=photos_dir)
        request = replace(request, views=_views(request, Path(views)))
        table, plan = out / PHOTO_TABLE, out / "plan.json"
        if changed_by_hand(out, PHOTO_TABLE) and table.resolve() != _resolved(request):
            request = replace(request, corrections=table)
            _LOG.warning("%s was changed since the last run: its rooms are used", table)
        if is_picture(request) and changed_by_hand(out, plan.name):
            _LOG.warning("%s was changed since the last run: --plan %s uses it", plan, plan)
        names = read_input(request)
        wanted = (*DELIVERED, *OF_PHOTOS) if names else DELIVERED
        wanted += TRACED if is_picture(request) else ()
        # If the user passes the photos.csv of an earlier run, it is an input and not overwritten.
        wanted = tuple(name for name in wanted if (out / name).resolve() != _resolved(request))
        with claimed_folder(out, (*wanted, "textures"), inputs) as folder:
            config = prepare(request, names, folder.work)
            base = f"results/{DATASET}/houses/{request.house}"
            options = list(PRINTED[printed])
            options += ["--logger-plan2scene-events", str(events.resolve())] if events else []
            options += ["--cores", str(cores)]
            made = folder.work / "results" / DATASET
            files = {name: made / "houses" / request.house / name for name in wanted}
            files["textures"] = (
                made / "houses" / request.house / "textures"
                if request.colours == "paint"
                else made / "drop_0.0" / request.method / request.house / "textures"
            )
            if first:
                _make([f"{base}/{name}" for name in first], config, folder, options)
                folder.deliver({name: files[name] for name in first})
            _make([f"{base}/{name}" for name in wanted], config, folder, options)
            made_files = folder.deliver(files)
            if is_picture(request):
                for line in made_files["plan.doubts.txt"].read_text(encoding="utf-8").splitlines():
                    _LOG.warning("%s", line)
            return made_files


def _profile_options() -> list[str]:
    """Return the default profile as options; for a profile file Snakemake would print a line."""
    import yaml

    text = (WORKFLOW / "workflow" / "profiles" / "default" / "profile.yaml").read_text("utf-8")
    options = ["--workflow-profile", "none"]
    for name, value in yaml.safe_load(text).items():
        if value is not False:
            options += [f"--{name}"] if value is True else [f"--{name}", str(value)]
    return options


def _resolved(request: SingleHouse) -> Path | None:
    """Return the photo table's resolved path, or None."""
    return None if request.photo_table is None else request.photo_table.resolve()


def _make(targets: list[str], config: Path, folder: OutFolder, options: list[str]) -> None:
    """Run Snakemake in the work folder; WorkflowError when it fails."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(WORKFLOW / "Snakefile")]
    command += ["--directory", str(folder.work), "--configfile", str(config)]
    command += _profile_options()
    command += [*options, "--", *targets]
    # The child inherits the lock: the folder stays locked until Snakemake has ended, too.
    inherited = (folder.lock,) if folder.lock >= 0 else ()
    if run_bound(command, pass_fds=inherited) != 0:
        raise WorkflowError(f"the workflow failed; its logs are in {folder.work / 'logs'}")
