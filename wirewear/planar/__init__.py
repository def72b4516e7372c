"""Line contacts: a pad on a flat in plane strain, from a TOML file to profiles, loops and pictures."""

from wirewear.planar.run import run_planar_study, run_planar_variants
from wirewear.planar.tables import PlanarStudy, planar_study_from_tables

__all__ = ["PlanarStudy", "planar_study_from_tables", "run_planar_study", "run_planar_variants"]
