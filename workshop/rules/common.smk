# The checked config, and what all rules of the workshop share.
import functools
from dataclasses import fields
from pathlib import Path

import plan2scene_workshop
from plan2scene.weights import MODELS
from plan2scene_app.workflow import closures
from plan2scene_workshop.homes.residences import ResidenceOptions, residence_names
from snakemake.utils import validate

validate(config, schema="../schemas/config.schema.json")

HOMES = config["synthetic"]
ROOT = HOMES["root"]
TABLE = f"{ROOT}/houses.tsv"
RESIDENCES = residence_names(HOMES["prefix"], HOMES["houses"])
TRAINING = config["training"]
# Trained weights land here; shipping them (a copy into resources/models) is a deliberate act.
TRAINED = "results/training/models"
# A stopped training goes on from results/training/{name}.checkpoint, which is there while a run is
# unfinished alone. It is a param: Snakemake removes what a failed job declares as output.

code_hash = functools.partial(
    closures.code_hash,
    packages=(Path(plan2scene_workshop.__file__).parent, *closures.PACKAGES),
)


wildcard_constraints:
    house=r"[A-Za-z0-9_][A-Za-z0-9_.-]*",
    split="train|val|test",
