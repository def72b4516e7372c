"""A cylinder on a flat that slides as a whole, for the tests of local laws."""

from tests.bodies import STEEL
from tests.wear_jumps import LINE_LOAD_N_per_mm
from wirewear.reference import Elastic, LineContact, contact_modulus, hertz_line

STROKE_mm = 0.02


def hertz_of_line() -> LineContact:
    """Its fresh contact."""
    steel = Elastic(STEEL.youngs_modulus_MPa, STEEL.poissons_ratio)
    return hertz_line(LINE_LOAD_N_per_mm, 6.0, contact_modulus(steel, steel))
