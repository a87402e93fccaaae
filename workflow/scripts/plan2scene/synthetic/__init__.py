"""Synthetic homes with truth: plans, materials, style, photos, data sets."""
