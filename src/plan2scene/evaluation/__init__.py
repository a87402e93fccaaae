"""Evaluation on a data set: metrics, the paper's table 1, sweeps over drops, ablations."""
