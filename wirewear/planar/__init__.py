"""Planar studies: a cylinder on a flat in plane strain, from a TOML file to profiles, loops and pictures."""

from wirewear.planar.reading import is_planar_study, load_planar_study
from wirewear.planar.run import run_planar_study
from wirewear.planar.tables import PlanarStudy

__all__ = ["PlanarStudy", "is_planar_study", "load_planar_study", "run_planar_study"]
