# Plan2Scene: every file of a textured house, from a plan and photos. Paths: docs/conventions.md.
from snakemake.utils import min_version

min_version("9.19")


configfile: f"{workflow.basedir}/config/advanced.yaml"
configfile: f"{workflow.basedir}/config/config.yaml"
configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/texture_inputs.smk"
include: "workflow/rules/checkpoints.smk"
include: "workflow/rules/floorplans.smk"
include: "workflow/rules/photos.smk"
include: "workflow/rules/embeddings.smk"
include: "workflow/rules/textures.smk"
include: "workflow/rules/houses.smk"
include: "workflow/rules/evaluation.smk"
include: "workflow/rules/sweep.smk"
include: "workflow/rules/ablation.smk"
include: "workflow/rules/study.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/collect.smk"


rule all:
    default_target: True
    input:
        house_files("house.glb", "preview.png", "rooms.jpg", "views.jpg", "viewer.html"),
        house_files("contact_sheet.png", "texture_sheet.png"),
        f"{RESULTS}/tables/paper_table.csv",
        f"{RESULTS}/index.html",
