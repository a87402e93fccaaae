# The checked config, the house table, and the functions that rules call for inputs and params.
# All results lie below results/{dataset}/; docs/conventions.md lists the files.
import functools
import json
import os
import re
import shlex
import sys
from pathlib import Path

from snakemake.logging import logger

from plan2scene_app.workflow.layout import find_layout
from plan2scene.errors import InputError
from plan2scene.images import SUFFIXES
from plan2scene.photos.labels.imagenet import imagenet_installed
from plan2scene.provenance import file_hash
from plan2scene.textures.methods import texture_methods
from plan2scene_app.finishes import finishes_file
from plan2scene_app.workflow.closures import (
    contents_hash,
    export_code,
    method_code,
    reader_code,
    rule_code,
)
from plan2scene_app.workflow.config import (
    check_checkpoints,
    check_config,
    chosen_crops,
    table_of,
)
from plan2scene_app.workflow.drops import hidden_photos, read_unobserved
from plan2scene_app.workflow.failures import failures
from plan2scene_app.workflow.planning import (
    lacks_rooms,
    may_lack_heights,
    photo_paths,
    safe_names,
)
from plan2scene_app.workflow.slurm import check_cluster

try:
    check_config(config)
    LAYOUT = find_layout(config["dataset"]["root"])
    TABLE = table_of(config["dataset"])
    HOUSES = list(
        TABLE.of_splits(config["dataset"]["splits"], config["dataset"]["houses"])
    )
    for name in config["floorplans"]["names"] or {}:
        TABLE[name]  # a name of an unknown house is a typing error
    CROPS = config["crops"] | chosen_crops(LAYOUT, config["crops"])
    check_checkpoints(config)
    # The photos that the data set itself hides at each drop fraction; None if it does not say.
    UNOBSERVED = (
        {
            drop: frozenset(names)
            for drop, names in read_unobserved(LAYOUT.unobserved).items()
        }
        if LAYOUT.unobserved.is_file()
        else None
    )
    MEANS_HOUSES = (
        list(TABLE.of_splits(config["official"]["means_splits"]))
        if config["weights"] == "official"
        else []
    )
except InputError as error:
    sys.exit(f"plan2scene: {error}")

# Houses whose crops may be copied to a surface for which its own house has no crop.
POOL_HOUSES = [
    row.house
    for row in TABLE.houses.values()
    if row.split in config["textures"]["crop_pool"]
]
DATASET = config["dataset"]["name"]
DATA_ROOT = LAYOUT.root
RESULTS = f"results/{DATASET}"
# Relative to the working directory, which may be outside the clone (`plan2scene run`).
MODELS = os.path.relpath(Path(workflow.basedir) / "resources" / "models")
METHODS = config["methods"]
TEXTURE_METHODS = texture_methods()
DROPS = [f"{drop:.1f}" for drop in config["drops"]]


wildcard_constraints:
    house=r"[A-Za-z0-9_][A-Za-z0-9_.-]*",
    drop=r"[01]\.\d",
    method="|".join(TEXTURE_METHODS),


onstart:
    if TABLE.warnings:
        more = len(TABLE.warnings) - 1
        rest = f" (and {more} more: plan2scene check)" if more else ""
        print(f"plan2scene: warning: {TABLE.warnings[0]}{rest}", file=sys.stderr)
    # Stop before the first submission where Snakemake could not see that SLURM's jobs have ended.
    if hasattr(workflow.executor_settings, "status_command"):
        try:
            check_cluster(workflow.executor_settings.status_command)
        except InputError as error:
            sys.exit(f"plan2scene: {error}")


def tell_how_to_unlock(record):
    """Add the unlocking command to Snakemake's message about the lock that a killed run left."""
    if "the --unlock argument" in str(record.msg):
        command = shlex.join(["snakemake", "--unlock", *sys.argv[1:]])
        record.msg = f"{record.msg}\nplan2scene: if none runs here: {command}"
    return True


logger.addFilter(tell_how_to_unlock)


def row_of(wildcards):
    """Return a house's row of the house table; an unknown house ends the run with one line."""
    try:
        return TABLE[wildcards.house]
    except InputError as error:
        sys.exit(f"plan2scene: {error}")


def plan_files(wildcards):
    """Return the files that a house's plan is read from, if they exist.

    A missing plan is no input, so that the job can report it in one line.
    """
    path = DATA_ROOT / row_of(wildcards).plan
    boxes = HAS_BOXES and object_boxes_of(wildcards)
    plan = read_plan_of(wildcards) if path.is_file() else None
    return given(plan=plan, assignment=assignment_of(wildcards), object_boxes=boxes)


def finish_files(wildcards):
    """Return the file of a house's finishes, if any, and the crops that it may name."""
    path = finishes_file(DATA_ROOT / row_of(wildcards).plan)
    crops = f"{RESULTS}/houses/{wildcards.house}/crops.parquet"
    return {"finishes": str(path), "crops": crops} if path.is_file() else {}


def picture_of(wildcards):
    """Return the picture of a house's plan."""
    return str(DATA_ROOT / row_of(wildcards).plan)


def named_files(wildcards):
    """Return the plan and the photo table that the house table names, existing or not."""
    return {
        "plan": read_plan_of(wildcards),
        "assignment": named_assignment_of(wildcards),
    }


def read_plan_of(wildcards):
    """Return the plan file to read: for a picture of a plan, the plan that rule trace makes."""
    path = DATA_ROOT / row_of(wildcards).plan
    traced = is_traced(wildcards)
    return f"{RESULTS}/houses/{wildcards.house}/plan.json" if traced else str(path)


def is_traced(wildcards):
    """Return whether a house's plan is a picture, which rule trace turns into a plan."""
    path = DATA_ROOT / row_of(wildcards).plan
    return path.suffix.lower() in SUFFIXES and path.is_file()


def lacks_heights(row):
    """Return whether a house's height is measured in photos, since its plan may lack it."""
    path = DATA_ROOT / row.plan
    if not (HAS_MASKS and row.photos and path.is_file()):
        return False
    return path.suffix.lower() in SUFFIXES or may_lack_heights(path)


def trace_files(wildcards):
    """Return the overlay and the doubts that rule trace makes; nothing for other plans."""
    plan = f"{RESULTS}/houses/{wildcards.house}/plan"
    made = dict(overlay=f"{plan}.overlay.png", doubts=f"{plan}.doubts.txt")
    return made if is_traced(wildcards) else {}


@functools.cache
def plan_code(suffix):
    """Return the hashes of the code that reads plan files with this suffix."""
    return [rule_code("floorplan"), *reader_code(suffix)]


def plan_code_of(wildcards):
    """Return the hashes of the code that reads a house's plan."""
    return plan_code(Path(read_plan_of(wildcards)).suffix.lower())


def assignment_of(wildcards):
    """Return the photo table of a house; an empty list if there is none."""
    path = named_assignment_of(wildcards)
    return path if path and os.path.isfile(path) else []


def finds_rooms(wildcards):
    """Return the classifier that helps to find photos' rooms; None if the table has all rooms."""
    path = assignment_of(wildcards)
    if not path or not (is_traced(wildcards) or lacks_rooms(path)):
        return None
    source = config["photos"]["kinds"]
    if source == "auto":
        return "imagenet" if imagenet_installed() else "embedded"
    return source


def object_boxes_of(wildcards):
    """Return the object boxes of a house; empty where it has none."""
    path = LAYOUT.object_boxes(row_of(wildcards).split, wildcards.house)
    return str(path) if path.is_file() else []


def photo_names_of(wildcards):
    """Return the names of a house's photos in the house table, as JSON without "<".

    Snakemake's report writes params into a script tag unescaped; a name with "<" could end it.
    """
    return json.dumps(row_of(wildcards).photos).replace("<", "\\u003c")


def photos_of(wildcards):
    """Return those photos of a house that exist; the job reports the missing ones."""
    names = row_of(wildcards).photos
    return [str(path) for path in photo_paths(LAYOUT.photos, names)]


def hidden_at(drop, wildcards):
    """Return the photos of a house that are hidden at a drop fraction, sorted."""
    return hidden_photos(
        UNOBSERVED,
        drop,
        row_of(wildcards).photos,
        seed=config["seed"],
        house_id=wildcards.house,
    )


def model_of(name):
    """Return the weights of a model: the configured, else the authors', else the embedded ones."""
    if config["models"].get(name):
        return config["models"][name]
    if config["weights"] == "official" and config["official"].get(name):
        return f"{RESULTS}/weights/{name}.safetensors"
    return f"{MODELS}/{name}.safetensors"


def made(models):
    """Return those weights that rules make, by name: only they are inputs of jobs.

    Shipped weights are not inputs, to keep the plan of thousands of jobs small. Their hash is a
    param (:func:`hashes`), so a job runs again when they change.
    """
    return {
        name: path for name, path in models.items() if path.startswith(f"{RESULTS}/")
    }


def hashes(models):
    """Return the hashes of the weights that no rule makes."""
    return [ready_hash(models[name]) for name in sorted(models.keys() - made(models))]


@functools.cache
def ready_hash(path):
    """Return the hash of a weights file; if it is missing, the first job that reads it says so."""
    return file_hash(path) if os.path.isfile(path) else "absent"


def contents_of(*input_functions):
    """Return a params function: the hash of the contents of a job's inputs that no rule makes.

    With it a job runs again when a file is replaced by an older one. Snakemake alone would compare
    times, and keeps no record of what input functions returned.
    """

    def contents(wildcards):
        files = []
        for function in input_functions:
            named = function(wildcards)
            parts = named.values() if isinstance(named, dict) else [named]
            for part in parts:
                files += [part] if isinstance(part, str) else part
        return contents_hash(
            file for file in files if not file.startswith(f"{RESULTS}/")
        )

    return contents


def given(**inputs):
    """Return the inputs that are not empty; empty ones would only make planning slower."""
    return {name: value for name, value in inputs.items() if value}


# Threads of a job: several if there are few houses; else one, as other houses' jobs run too.
HOUSE_THREADS = max(1, 4 // max(1, len(HOUSES)))
# With so many photos or more, a stage takes all threads, even if other stages could run beside.
MANY_PHOTOS = 16


def threads_by_photos(wildcards):
    """Return the threads of a stage that can run at the same time as other stages of its house."""
    return HOUSE_THREADS if len(row_of(wildcards).photos) >= MANY_PHOTOS else 1


def worker_memory(alone, each):
    """Return the megabytes of a job that starts a worker process for each of its threads."""
    return alone + each * HOUSE_THREADS if HOUSE_THREADS > 1 else alone


# Megabytes of a job over all houses. It reads one house at a time, but the sums over InceptionV3's
# 2048 features and Snakemake's list of all input files are large.
GATHERED_MEMORY = (2000 if config["metrics"]["inception"] else 1000) + len(HOUSES) // 50


def house_files(*names):
    """Return result files of every house: ``house_files("house.glb")``."""
    return expand(f"{RESULTS}/houses/{{house}}/{{name}}", house=HOUSES, name=names)


def named_assignment_of(wildcards):
    """Return the photo table that the house table names, existing or not; "" for none."""
    name = row_of(wildcards).assignment
    return str(DATA_ROOT / name) if name else ""


# Inputs that are the same for all houses. Plain values make planning faster than functions, which
# Snakemake calls for every job.
POOL = f"{RESULTS}/crop_pool.parquet" if POOL_HOUSES else None
HAS_BOXES = (LAYOUT.data / "object_aabbs").is_dir()
HAS_MASKS = CROPS["source"] != "precomputed"
MASKS = f"{RESULTS}/houses/{{house}}/masks"
CAMERAS = f"{RESULTS}/houses/{{house}}/cameras.json"
PATTERNS = f"{RESULTS}/houses/{{house}}/patterns.parquet"
HOUSES_WITHOUT_HEIGHTS = [
    row.house for row in TABLE.houses.values() if lacks_heights(row)
]


def metric_model(network):
    """Return the weights of a metric's network: the configured ones, else the embedded."""
    if config["metrics"][network]:
        return f"{RESULTS}/weights/{network}.safetensors"
    return model_of("features")


def hidden_at_drops(drops):
    """Return a params function: the hidden photos of a house at each drop fraction."""
    return lambda wildcards: {drop: hidden_at(drop, wildcards) for drop in drops}


def study_answers_of(wildcards):
    """Return the files of answers; if there are none, the job says so."""
    folder = config["study"]["answers"]
    return sorted(str(path) for path in Path(folder).glob("*.csv")) if folder else []


def finished_houses():
    """Return the houses that have all files in `FINISHED`."""
    return [
        house
        for house in HOUSES
        if all(os.path.exists(path.format(house=house)) for path in FINISHED)
    ]


def finished(name):
    """Return an input function: the files with this name of all finished houses."""

    def files(wildcards):
        houses = finished_houses()
        if not houses:
            sys.exit(f"plan2scene: expected a finished house in {RESULTS}, found none")
        return [f"{RESULTS}/houses/{house}/{name}" for house in houses]

    return files


def label_model():
    """Return the embedded models that label photos, by name; none if masks come from elsewhere.

    The shipped classifier of rooms works on features of the shipped network only.
    """
    source = config["photos"]["masks"]
    if source not in ("embedded", "imagenet"):
        return {}
    own = config["models"].get("segmentation") and not config["models"].get("kinds")
    names = ["segmentation", "amodal", *([] if own else ["kinds"])]
    names += ["segmentation_imagenet"] if source == "imagenet" else []
    return {name: model_of(name) for name in names}


def pretrained_files():
    """Return the files of a pretrained network in a local folder."""
    folder = config["photos"]["pretrained"]["path"]
    if config["photos"]["masks"] != "pretrained" or not folder:
        return []
    return sorted(
        str(path)
        for pattern in ("*.json", "*.safetensors")
        for path in Path(folder).glob(pattern)
    )


def precomputed_masks_of(wildcards):
    """Return the label PNGs that the configured folder has for a house's photos."""
    folder = Path(config["photos"]["masks_folder"] or "")
    names = safe_names(row_of(wildcards).photos)
    paths = (folder / f"{Path(name).stem}.png" for name in names)
    return [str(path) for path in paths if path.is_file()]


@functools.cache
def precomputed_crops():
    """Return the precomputed crops of the configured folder by photo stem."""
    by_stem = {}
    for path in sorted(Path(CROPS["folder"]).glob("*/*_crop*.png")):
        by_stem.setdefault(path.name.rsplit("_", 2)[0], []).append(str(path))
    return by_stem


def precomputed_crops_of(wildcards):
    """Return the precomputed crops of a house's photos."""
    names = safe_names(row_of(wildcards).photos)
    stems = [Path(name).stem for name in names]
    return [path for stem in stems for path in precomputed_crops().get(stem, [])]


def at_all_drops(name):
    """Return a file of every house at every drop fraction."""
    return expand(f"{RESULTS}/drop_{{drop}}/{{house}}/{name}", drop=DROPS, house=HOUSES)


def at_drops(path):
    """Return a house's file at each drop fraction; the house stays a wildcard."""
    return expand(path, drop=DROPS, allow_missing=True)
