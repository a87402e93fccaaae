# On demand: the user study. `snakemake -j2 study` makes the form and its key. When people's answer
# files lie in the folder config["study"]["answers"], `snakemake study_result` counts preferences.
from plan2scene_app.study.study import study_houses

STUDY = config["study"]
STUDY_METHODS = list(
    dict.fromkeys(method for pair in STUDY["pairs"] for method in pair)
)
# Methods of the table, whose tiles are made for the table, and other methods.
STUDY_COMPARED = [method for method in STUDY_METHODS if method in METHODS]
STUDY_OTHERS = [method for method in STUDY_METHODS if method not in METHODS]
STUDY_HOUSES = study_houses(HOUSES, STUDY["houses"], seed=config["seed"])


rule study_house:
    # Plan, photos and a render by each method, with no photo hidden.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        assignment=assignment_of,
        photos=photos_of,
        compared=COMPARED if STUDY_COMPARED else [],
        others=[
            f"{RESULTS}/drop_0.0/{method}/{{house}}/textures"
            for method in STUDY_OTHERS
        ],
    output:
        directory(f"{RESULTS}/study/houses/{{house}}"),
    log:
        f"logs/{DATASET}/study_house/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/study_house/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        methods=STUDY_METHODS,
        others=STUDY_OTHERS,
        names=photo_names_of,
        photo_folder=str(LAYOUT.photos),
        contents=contents_of(assignment_of, photos_of),
        code=rule_code("study_house"),
    script:
        "../scripts/study_house.py"


rule study:
    # One offline page with the questions, and the key: which method is on which side.
    input:
        sheets=expand(f"{RESULTS}/study/houses/{{house}}", house=STUDY_HOUSES),
    output:
        form=report(
            f"{RESULTS}/study/form.html",
            caption="../report/study.rst",
            category="Evaluation",
        ),
        key=f"{RESULTS}/study/key.csv",
    log:
        f"logs/{DATASET}/study.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/study.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        houses=STUDY_HOUSES,
        pairs=STUDY["pairs"],
        seed=config["seed"],
        code=rule_code("study"),
    script:
        "../scripts/study.py"


rule study_result:
    # Preferences between methods, with 95 % intervals.
    input:
        key=f"{RESULTS}/study/key.csv",
        answers=study_answers_of,
    output:
        csv=f"{RESULTS}/tables/study.csv",
        text=f"{RESULTS}/tables/study.txt",
    log:
        f"logs/{DATASET}/study_result.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/study_result.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        pairs=STUDY["pairs"],
        code=rule_code("study_result"),
    script:
        "../scripts/study_result.py"
