# What makes the plan of thousands of houses quick: what Snakemake would do again for each job.
import gc

from snakemake import dag as snakemake_dag

# All of a plan stays: to look for garbage in it takes a quarter of the time. Jobs leave some, so
# `onstart` lets it be looked for again.
gc.disable()


def once_a_rule(check):
    """Return Snakemake's check of a job that looks at the first job of each rule alone."""
    seen = set()

    def process_job(self, job):
        if job.rule not in seen:
            seen.add(job.rule)
            check(self, job)

    return process_job


# Whether a job's script can be read takes a seventh of the time; all jobs of a rule have the same.
if hasattr(snakemake_dag, "ScriptProcessor"):
    scripts = snakemake_dag.ScriptProcessor
    scripts.process_job = once_a_rule(scripts.process_job)
