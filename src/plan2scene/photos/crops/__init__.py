"""Rectified crops of surfaces: sampling, filters, light, tables."""
