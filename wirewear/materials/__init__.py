"""Elastic constants of materials by name, each with its source."""

from wirewear.materials.table import Material, material_named, materials, names

__all__ = ["Material", "material_named", "materials", "names"]
