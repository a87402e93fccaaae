"""Evaluation on a data set: the metrics of each house, and the paper's table 1."""
