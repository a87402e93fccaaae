"""Meshes: a house's floors, ceilings, walls with openings, doors and windows, and their files."""

from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import TileTexture, load_textures

__all__ = ["MeshPart", "TileTexture", "build_parts", "load_textures", "write_glb"]
