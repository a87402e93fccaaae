"""The workflow's configuration: its schema, its checks, and what sections of it mean."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError, schema_fault
from plan2scene.provenance import WORKFLOW
from plan2scene.textures.methods import texture_methods
from plan2scene_app.workflow.house_table import HouseTable, read_table, table_of_lists
from plan2scene_app.workflow.layout import Layout, find_layout

_WHERE = "configuration"  #: The place of a fault
MAX_VALUES = 10_000  #: Most values of a configuration; an alias counts at each use


def config_schema() -> dict[str, Any]:
    """Return ``workflow/schemas/config.schema.json`` with the names of the texture methods."""
    path = WORKFLOW / "workflow" / "schemas" / "config.schema.json"
    schema: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    schema["$defs"]["method"]["enum"] = list(texture_methods())
    return schema


def check_config(config: Mapping[str, Any]) -> None:
    """Raise InputError that names one fault if the schema does not allow a configuration."""
    from jsonschema import Draft202012Validator
    from jsonschema.exceptions import best_match

    for count, (key, value) in enumerate(_values(config)):
        if count >= MAX_VALUES:
            raise InputError(f"at most {MAX_VALUES} values", "more", file=_WHERE)
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"a finite number at {key}", str(value), file=_WHERE)
        if isinstance(value, str) and not (value.isprintable() and set("{}").isdisjoint(value)):
            # Snakemake would read text in braces as a wildcard.
            expected = f"text without braces and control characters at {key}"
            raise InputError(expected, repr(value), file=_WHERE)
    error = best_match(Draft202012Validator(config_schema()).iter_errors(config))
    if error is not None:
        raise InputError(*schema_fault(error), file=_WHERE)


def _values(config: Mapping[str, Any]) -> Iterator[tuple[str, object]]:
    """Yield every value of a configuration with its key, sections before their contents."""
    queue: list[tuple[str, object]] = [("", config)]
    while queue:
        key, value = queue.pop()
        yield key, value
        if isinstance(value, Mapping | list):
            items = list(value.items() if isinstance(value, Mapping) else enumerate(value))
            queue += [(f"{key}.{name}" if key else str(name), item) for name, item in items[::-1]]


def check_checkpoints(config: Mapping[str, Any]) -> None:
    """Raise InputError if a needed checkpoint is not named, or a named one is not a file.

    The same holds for named folders and a pretrained network: else each house would fail.
    """
    paths = {f"metrics.{name}": config["metrics"][name] for name in ("vgg16", "inception")}
    paths |= {f"models.{name}": path for name, path in config["models"].items()}
    if config["weights"] == "official":
        names = ("texture", "propagation", "naivesynth")
        paths |= {f"official.{name}": config["official"][name] for name in names}
        # A propagation network fits the embeddings of one texture model only: both are needed.
        for name in ("official.texture", "official.propagation"):
            if paths[name] is None:
                raise InputError(f"a path for {name}", "null", file=_WHERE)
    for name, path in paths.items():
        if path is not None and not Path(path).is_file():
            raise InputError(f"a checkpoint ({name})", "no such file", file=path)
    for section, key in (("crops", "folder"), ("textures", "library_folder")):
        path = config[section][key]
        if path is not None and not Path(path).is_dir():
            raise InputError(f"a folder ({section}.{key})", "no such folder", file=path)
    folder = config["photos"]["masks_folder"]
    if config["photos"]["masks"] == "precomputed" and not (folder and Path(folder).is_dir()):
        raise InputError("a folder of label PNGs (photos.masks_folder)", str(folder or "null"))
    pretrained = config["photos"]["pretrained"]
    given = pretrained["path"] or (pretrained["id"] and pretrained["revision"])
    if config["photos"]["masks"] == "pretrained" and not given:
        raise InputError("a path, or id and revision, in photos.pretrained", "neither")


def table_of(dataset: Mapping[str, Any]) -> HouseTable:
    """Return the house table of a data set; if none is named, make it from the data lists.

    `dataset` is the section ``dataset`` of the configuration. InputError if there is no data set in
    its ``root``.
    """
    if dataset["table"] is not None:
        return read_table(find_layout(dataset["root"]).data / dataset["table"])
    return table_of_lists(dataset["root"], architecture=dataset["architecture"])


def chosen_crops(layout: Layout, crops: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``{"source", "folder"}`` of the section ``crops``, with ``auto`` resolved.

    Then precomputed crops of Rent3D++ are taken if the data set has them or a folder is named;
    else crops are sampled from the photos.
    """
    source, folder = crops["source"], crops["folder"]
    if source == "sampled":
        return {"source": source, "folder": folder}
    if folder is None and layout.surface_crops is not None:
        folder = str(layout.surface_crops)
    if source == "auto":
        source = "sampled" if folder is None else "precomputed"
    if source == "precomputed" and folder is None:
        expected = "crops.folder, or surface_crops/ with the data set"
        raise InputError(expected, "neither", file=layout.processed)
    return {"source": source, "folder": folder}
