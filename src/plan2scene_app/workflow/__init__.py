"""Helpers of the workflow's scripts and rules; none imports Snakemake."""
