# What makes the plan of thousands of houses quick: what Snakemake would do again for each job.
import gc

from plan2scene.planning import first_of_each
from snakemake import dag as snakemake_dag

# All of a plan stays: to look for garbage in it takes a quarter of the time. Jobs leave some, so
# `onstart` lets it be looked for again.
gc.disable()


# Whether a job's script can be read takes a seventh of the time; all jobs of a rule have the same.
if hasattr(snakemake_dag, "ScriptProcessor"):
    scripts = snakemake_dag.ScriptProcessor
    scripts.process_job = first_of_each(scripts.process_job, lambda job: job.rule)
