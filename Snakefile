# Plan2Scene: every file of a textured house, from a plan and photos. Paths: docs/conventions.md.
from snakemake.utils import min_version

min_version("9.10")


configfile: "config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/floorplans.smk"


rule all:
    default_target: True
    input:
        expand(f"{RESULTS}/houses/{{house}}/scene.json", house=HOUSES.index),
