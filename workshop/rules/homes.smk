# Synthetic data sets. The houses come from config["synthetic"] alone, so that they are made in
# parallel and only where missing.


rule data:
    input:
        TABLE,


rule residence:
    # One house: plan, photo table, photos/{house}_NN.jpg (as many as its seed says), truth; photos
    # as of listings, or snapshots to train on.
    output:
        plan=f"{ROOT}/archs_no_objects/{{split}}/{{house}}.scene.json",
        assignment=f"{ROOT}/photo_assignments/{{split}}/{{house}}.photoroom.csv",
        truth=directory(f"{ROOT}/truth/{{split}}/{{house}}"),
    log:
        f"logs/data/{ROOT}/residence/{{split}}/{{house}}.log",
    benchmark:
        f"logs/data/{ROOT}/benchmarks/residence/{{split}}/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=HOMES["seed"],
        options={field.name: HOMES[field.name] for field in fields(ResidenceOptions)},
        textures=HOMES["textures"],
        environments=HOMES["environments"],
        models=HOMES["models"],
        snapshots=HOMES["snapshots"],
        code=code_hash("plan2scene_workshop.homes.snapshots"),
    script:
        "../scripts/residence.py"


rule residence_index:
    # Data lists, photos to hide and the house table: what the other rules start from.
    input:
        plans=[
            f"{ROOT}/archs_no_objects/{split}/{house}.scene.json"
            for house, split in RESIDENCES.items()
        ],
        assignments=[
            f"{ROOT}/photo_assignments/{split}/{house}.photoroom.csv"
            for house, split in RESIDENCES.items()
        ],
    output:
        table=TABLE,
        hidden=f"{ROOT}/unobserved_photos.json",
        lists=expand(
            "{root}/data_lists/{split}.txt",
            root=ROOT,
            split=["train", "val", "test"],
        ),
    log:
        f"logs/data/{ROOT}/residence_index.log",
    benchmark:
        f"logs/data/{ROOT}/benchmarks/residence_index.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        houses=RESIDENCES,
        seed=HOMES["seed"],
        code=code_hash("plan2scene_workshop.homes.residences"),
    script:
        "../scripts/residence_index.py"
