# What makes the plan of thousands of houses quick and small: what Snakemake would do again for each job.
import gc

from plan2scene.planning import first_of_each, flags_of_flagged, one_of_each
from snakemake import dag as snakemake_dag
from snakemake import io as snakemake_io
from snakemake import iocontainers as snakemake_lists

# All of a plan stays: to look for garbage in it takes a quarter of the time. Jobs leave some, so
# `onstart` lets it be looked for again.
gc.disable()


# Whether a job's script can be read takes a seventh of the time; all jobs of a rule have the same.
if hasattr(snakemake_dag, "ScriptProcessor"):
    scripts = snakemake_dag.ScriptProcessor
    scripts.process_job = first_of_each(scripts.process_job, lambda job: job.rule)


# Two thirds of a plan's memory are paths and lists of them.
if hasattr(getattr(snakemake_io, "_IOFile", None), "clone_flags"):
    paths = snakemake_io._IOFile
    paths.clone_flags = flags_of_flagged(paths.clone_flags)
if hasattr(snakemake_lists, "AttributeGuard"):
    snakemake_lists.AttributeGuard.__new__ = one_of_each()
