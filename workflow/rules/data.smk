# Synthetic data sets: `snakemake data --configfile config/benchmark.yaml`. The houses come from
# config["synthetic"] alone, so that they are made in parallel and only where missing.
from snakemake.utils import validate

from plan2scene.synthetic.residences import residence_names

SYNTHETIC = config.get("synthetic", {})
if SYNTHETIC:
    validate(SYNTHETIC, schema="../schemas/synthetic.schema.json")
SYNTHETIC_ROOT = SYNTHETIC.get("root", "data/synthetic")
RESIDENCES = (
    residence_names(SYNTHETIC["prefix"], SYNTHETIC["houses"]) if SYNTHETIC else {}
)


rule data:
    input:
        f"{SYNTHETIC_ROOT}/houses.tsv",


rule residence:
    # One house: plan, photo table, photos/{house}_NN.jpg (as many as its seed says), truth.
    output:
        plan=f"{SYNTHETIC_ROOT}/archs_no_objects/{{split}}/{{house}}.scene.json",
        assignment=f"{SYNTHETIC_ROOT}/photo_assignments/{{split}}/{{house}}.photoroom.csv",
        truth=directory(f"{SYNTHETIC_ROOT}/truth/{{split}}/{{house}}"),
    log:
        f"logs/data/{SYNTHETIC_ROOT}/residence/{{split}}/{{house}}.log",
    benchmark:
        f"logs/data/{SYNTHETIC_ROOT}/benchmarks/residence/{{split}}/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=SYNTHETIC.get("seed"),
        photos=SYNTHETIC.get("photos"),
        hidden_room_share=SYNTHETIC.get("hidden_room_share"),
        height=SYNTHETIC.get("height"),
        width=SYNTHETIC.get("width"),
        samples_per_pixel=SYNTHETIC.get("samples_per_pixel"),
        jpeg_quality=SYNTHETIC.get("jpeg_quality"),
        tile_px=SYNTHETIC.get("tile_px"),
        variant=SYNTHETIC.get("variant"),
        textures=SYNTHETIC.get("textures"),
        code=code_hash("synthetic.residences"),
    script:
        "../scripts/residence.py"


rule residence_index:
    # Data lists, photos to hide and the house table: what the other rules start from.
    input:
        plans=[
            f"{SYNTHETIC_ROOT}/archs_no_objects/{split}/{house}.scene.json"
            for house, split in RESIDENCES.items()
        ],
        assignments=[
            f"{SYNTHETIC_ROOT}/photo_assignments/{split}/{house}.photoroom.csv"
            for house, split in RESIDENCES.items()
        ],
    output:
        table=f"{SYNTHETIC_ROOT}/houses.tsv",
        hidden=f"{SYNTHETIC_ROOT}/unobserved_photos.json",
        lists=expand(
            "{root}/data_lists/{split}.txt",
            root=SYNTHETIC_ROOT,
            split=["train", "val", "test"],
        ),
    log:
        f"logs/data/{SYNTHETIC_ROOT}/residence_index.log",
    benchmark:
        f"logs/data/{SYNTHETIC_ROOT}/benchmarks/residence_index.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        houses=RESIDENCES,
        seed=SYNTHETIC.get("seed"),
        code=code_hash("synthetic.residences"),
    script:
        "../scripts/residence_index.py"
