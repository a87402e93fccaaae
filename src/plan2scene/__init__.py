"""Plan2Scene: a vector floorplan and room photos in, a textured metric 3D house out.

The library behind the Snakemake workflow. It never imports Snakemake and is usable on its own.
Axes, units, colour spaces, label values and file schemas: ``docs/conventions.md``.
"""

__version__ = "0.1.0"
