rule floorplan:
    # Read any supported plan, validate it and write it as scene.json.
    input:
        unpack(plan_files),
    output:
        f"{RESULTS}/houses/{{house}}/scene.json",
    log:
        f"logs/{DATASET}/floorplan/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/floorplan/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        # As the house table names them, so that the job can say which file is missing.
        named=named_files,
        photos=str(LAYOUT.photos),
        metres_per_pixel=config["floorplans"]["metres_per_pixel"],
        dxf_layers=config["floorplans"]["dxf_layers"],
        traced=is_traced,
        warn=config["floorplans"]["warn"],
        name=lambda wildcards: (config["floorplans"]["names"] or {}).get(
            wildcards.house, ""
        ),
        contents=contents_of(plan_files),
        code=plan_code_of,
    script:
        "../scripts/floorplan.py"


use rule floorplan as drawn_floorplan with:
    output:
        f"{RESULTS}/houses/{{house}}/drawn.scene.json",
    log:
        f"logs/{DATASET}/drawn_floorplan/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/drawn_floorplan/{{house}}.tsv"


ruleorder: ceilings > floorplan


rule ceilings:
    input:
        drawn=f"{RESULTS}/houses/{{house}}/drawn.scene.json",
        masks=MASKS,
        assignment=assignment_of,
    output:
        f"{RESULTS}/houses/{{house}}/scene.json",
    log:
        f"logs/{DATASET}/ceilings/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/ceilings/{{house}}.tsv"
    # Photos give the heights of ceilings and windows, which the plans of these houses may lack.
    wildcard_constraints:
        house="|".join(map(re.escape, HOUSES_WITHOUT_HEIGHTS)) or "(?!)",
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=worker_memory(1000, 300),
    params:
        traced=is_traced,
        name_hints=config["photos"]["name_hints"],
        contents=contents_of(assignment_of),
        code=rule_code("ceilings"),
    script:
        "../scripts/ceilings.py"


rule trace:
    # A plan from a picture: the plan network finds rooms and openings, text gives scale and names.
    input:
        picture=picture_of,
    output:
        plan=f"{RESULTS}/houses/{{house}}/plan.json",
        overlay=f"{RESULTS}/houses/{{house}}/plan.overlay.png",
        doubts=f"{RESULTS}/houses/{{house}}/plan.doubts.txt",
    log:
        f"logs/{DATASET}/trace/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/trace/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 2
    resources:
        mem_mb=2500,
    params:
        metres_per_pixel=config["floorplans"]["metres_per_pixel"],
        model=model_of("plans"),
        fixture_model=model_of("fixtures"),
        weights=hashes({name: model_of(name) for name in ("plans", "fixtures")}),
        contents=contents_of(picture_of),
        code=rule_code("trace"),
    script:
        "../scripts/trace.py"
