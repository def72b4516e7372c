"""Planar studies: a cylinder on a flat in plane strain, from a TOML file to profiles, loops and pictures."""

from wirewear.planar.kinds import AnyStudy, load_any_study
from wirewear.planar.run import run_planar_study
from wirewear.planar.tables import PlanarStudy

__all__ = ["AnyStudy", "PlanarStudy", "load_any_study", "run_planar_study"]
