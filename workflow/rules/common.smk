# The checked config and house table, and the input functions of all rules.
# Paths of all results: results/{dataset}/..., the grammar is in docs/conventions.md.
import functools
import os
import sys
from pathlib import Path

import pandas as pd

from plan2scene.config import check_config
from plan2scene.datasets import read_unobserved
from plan2scene.datasets.drops import hidden_photos
from plan2scene.datasets.layout import find_layout
from plan2scene.datasets.table import SPLITS
from plan2scene.datasets.house_table import (
    check_metrics,
    check_official,
    chosen_crops,
    load_houses,
    photo_paths,
    safe_names,
    table_of,
)
from plan2scene.errors import InputError
from plan2scene.provenance import code_hash
from plan2scene.textures.methods import METHODS as TEXTURE_METHODS

try:
    check_config(config)
except InputError as error:
    sys.exit(f"plan2scene: {error}")

DATASET = config["dataset"]["name"]
LAYOUT = find_layout(config["dataset"]["root"])
DATA_ROOT = LAYOUT.root
RESULTS = f"results/{DATASET}"
# Relative to the working directory, which need not be the clone (`plan2scene run`).
MODELS = os.path.relpath(Path(workflow.basedir) / "resources" / "models")
METHODS = config["methods"]
DROPS = [f"{drop:.1f}" for drop in config["drops"]]

try:
    # A table that is worked out is made once, by the main process: jobs read it.
    TABLE = table_of(
        config["dataset"], RESULTS, make=workflow.is_main_process, warn=sys.stderr
    )
    config["crops"] |= chosen_crops(LAYOUT, config["crops"])
    check_official(config)
    check_metrics(config["metrics"])
    HOUSES = load_houses(
        TABLE,
        splits=config["dataset"]["splits"],
    )
    # Houses of other splits are asked for by name, or for the means of released weights.
    ALL_HOUSES = load_houses(TABLE, splits=SPLITS, may_be_absent=True)
    # Whose crops the copying methods may take where their own house has none.
    POOL_HOUSES = list(
        ALL_HOUSES.index[ALL_HOUSES["split"].isin(config["textures"]["crop_pool"])]
    )
    # Photos hidden at drop fractions, where the data set says so.
    UNOBSERVED = (
        read_unobserved(LAYOUT.unobserved) if LAYOUT.unobserved.is_file() else None
    )
    MEANS_HOUSES = (
        list(load_houses(TABLE, splits=config["official"]["means_splits"]).index)
        if config["weights"] == "official"
        else []
    )
except InputError as error:
    sys.exit(f"plan2scene: {error}")


wildcard_constraints:
    house=r"[A-Za-z0-9_][A-Za-z0-9_.-]*",
    drop=r"[01]\.\d",
    method="|".join(TEXTURE_METHODS),


def plan_of(wildcards):
    """Return the plan of a house; empty when it is missing (the job then says so)."""
    path = DATA_ROOT / ALL_HOUSES.loc[wildcards.house, "plan"]
    return str(path) if path.is_file() else []


def assignment_of(wildcards):
    """Return the photo table of a house; empty when the house has none."""
    name = ALL_HOUSES.loc[wildcards.house, "assignment"]
    path = DATA_ROOT / name
    return str(path) if name and path.is_file() else []


def object_boxes_of(wildcards):
    """Return the object boxes of a house; empty when the data set has none."""
    split = ALL_HOUSES.loc[wildcards.house, "split"]
    path = LAYOUT.object_boxes(split, wildcards.house)
    return str(path) if path.is_file() else []


def photo_names_of(wildcards):
    """Return all photo names that the house table gives a house."""
    return [
        name for name in ALL_HOUSES.loc[wildcards.house, "photos"].split("|") if name
    ]


def photos_of(wildcards):
    """Return the photos of a house that exist; what is missing is the job's to report."""
    return [str(path) for path in photo_paths(LAYOUT.photos, photo_names_of(wildcards))]


def hidden_at(drop, wildcards):
    """Return the photos of a house that are hidden at a drop fraction, sorted."""
    return hidden_photos(
        UNOBSERVED,
        drop,
        photo_names_of(wildcards),
        seed=config["seed"],
        house_id=wildcards.house,
    )


def model_of(name):
    """Return the path of a model: the configured one, a released one, else the embedded one."""
    if config["models"].get(name):
        return config["models"][name]
    if config["weights"] == "official" and config["official"].get(name):
        return f"{RESULTS}/weights/{name}.safetensors"
    return f"{MODELS}/{name}.safetensors"


def house_files(*names):
    """Return result files of every house: ``house_files("house.glb")``."""
    return expand(
        f"{RESULTS}/houses/{{house}}/{{name}}", house=HOUSES.index, name=names
    )


def named_assignment_of(wildcards):
    """Return the photo table that the house table names, there or not; "" for none."""
    name = ALL_HOUSES.loc[wildcards.house, "assignment"]
    return str(DATA_ROOT / name) if name else ""


def label_model_of(wildcards):
    """Return the segmentation model; none where labels are read from a folder.

    Of a pretrained network on disk its files; one of the hub is no file, its commit is a param.
    """
    source = config["photos"]["masks"]
    if source == "embedded":
        return model_of("segmentation")
    folder = config["photos"]["pretrained"]["path"]
    if source == "precomputed" or not folder:
        return []
    return sorted(
        str(path)
        for pattern in ("*.json", "*.safetensors")
        for path in Path(folder).glob(pattern)
    )


def ready_masks_of(wildcards):
    """Return the label PNGs that the configured folder has for a house's photos."""
    if config["photos"]["masks"] != "precomputed":
        return []
    folder = Path(config["photos"]["masks_folder"] or "")
    names = safe_names(photo_names_of(wildcards))
    paths = (folder / f"{Path(name).stem}.png" for name in names)
    return [str(path) for path in paths if path.is_file()]


def masks_of(wildcards):
    """Return the masks folder of a house; none where crops are ready."""
    if config["crops"]["source"] == "precomputed":
        return []
    return f"{RESULTS}/houses/{wildcards.house}/masks"


def cameras_of(wildcards):
    """Return the photos' places in the plan of a house; none where crops are ready."""
    if config["crops"]["source"] == "precomputed":
        return []
    return f"{RESULTS}/houses/{wildcards.house}/cameras.json"


@functools.cache
def ready_crops():
    """Return the ready crops of the configured folder by photo stem."""
    found = {}
    folder = config["crops"]["folder"]
    if config["crops"]["source"] == "precomputed" and folder:
        for path in sorted(Path(folder).glob("*/*_crop*.png")):
            found.setdefault(path.name.rsplit("_", 2)[0], []).append(str(path))
    return found


def ready_crops_of(wildcards):
    """Return the ready crops of a house's photos; none where crops are sampled."""
    stems = [Path(name).stem for name in safe_names(photo_names_of(wildcards))]
    return [path for stem in stems for path in ready_crops().get(stem, [])]


def seam_correction(*methods):
    """Return whether seams are corrected by method: as configured, else as registered."""
    chosen = config["textures"]["seam_correction"]
    return {
        name: chosen.get(name, TEXTURE_METHODS[name].seam_correction)
        for name in methods
    }


def decoder_of(wildcards):
    """Return the texture model of a method; none where nothing is decoded."""
    name = TEXTURE_METHODS[wildcards.method].weights
    return model_of(name) if name else []


def library_of(wildcards):
    """Return the tile library; none for a method that takes nothing from it."""
    needed = TEXTURE_METHODS[wildcards.method].library
    return f"{RESULTS}/texture_library.parquet" if needed else []


def metric_model(network):
    """Return the weights of a metric's network: the configured one's, else the embedded."""
    if config["metrics"][network]:
        return f"{RESULTS}/weights/{network}.safetensors"
    return model_of("features")


def crop_pool_of(wildcards):
    """Return the crops of other houses; none where none are configured or none are copied."""
    copied = TEXTURE_METHODS[wildcards.method].crop_pool
    return f"{RESULTS}/crop_pool.parquet" if POOL_HOUSES and copied else []


def hidden_at_drops(drops):
    """Return an input function: drop fraction to the photos of a house hidden at it."""
    return lambda wildcards: {drop: hidden_at(drop, wildcards) for drop in drops}


def study_answers_of(wildcards):
    """Return the answer files that were handed in; the job says so when there are none."""
    folder = config["study"]["answers"]
    return sorted(str(path) for path in Path(folder).glob("*.csv")) if folder else []
