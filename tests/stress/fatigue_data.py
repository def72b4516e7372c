"""Fatigue data of a steel, as the table [life] states them."""

STRENGTH, B, DUCTILITY, C = 2000.0, -0.09, 0.5, -0.6
OWN = {
    "fatigue_strength_coefficient_MPa": STRENGTH,
    "fatigue_strength_exponent": B,
    "fatigue_ductility_coefficient": DUCTILITY,
    "fatigue_ductility_exponent": C,
}
