# What makes the plan of thousands of houses quick and small: what Snakemake would do again for each job.
import gc

from plan2scene.workflow.planning import (
    answer_of_each,
    first_of_each,
    flags_of_flagged,
    one_of_each,
    parameters_of_each,
    plain_as_it_is,
)
from snakemake import common as snakemake_common
from snakemake import dag as snakemake_dag
from snakemake import io as snakemake_io
from snakemake import iocontainers as snakemake_lists
from snakemake import jobs as snakemake_jobs
from snakemake import rules as snakemake_rules

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


# The parameters of a rule's functions are those of the functions, of each job the same.
if hasattr(snakemake_common, "get_function_params"):
    of_functions = parameters_of_each(snakemake_common.get_function_params)
    snakemake_common.get_function_params = of_functions
    snakemake_rules.get_function_params = of_functions


# A rule has one conda environment and one script; to ask each job makes it expand its params.
if hasattr(snakemake_jobs.Job, "conda_env_spec"):
    asked = snakemake_jobs.Job.conda_env_spec.fget
    snakemake_jobs.Job.conda_env_spec = property(
        answer_of_each(asked, lambda job: job.rule)
    )
if hasattr(snakemake_jobs.Job, "_path_to_source_file"):
    sourced = snakemake_jobs.Job._path_to_source_file
    snakemake_jobs.Job._path_to_source_file = answer_of_each(
        sourced, lambda job: job.rule
    )


# What is printed of a path is looked up in nine flags; nearly all have none.
if hasattr(snakemake_jobs, "fmt_iofile"):
    snakemake_jobs.fmt_iofile = plain_as_it_is(snakemake_jobs.fmt_iofile)
