"""Synthetic homes: layouts, styles, data sets."""
