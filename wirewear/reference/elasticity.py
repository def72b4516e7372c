"""Combined elastic constants of two bodies in contact (N, mm, MPa)."""

from geometry import Elastic


def contact_modulus(first: Elastic, second: Elastic) -> float:
    """E* in MPa, 1/E* = Σ (1 − ν²)/E (Johnson, Contact Mechanics, 1985, section 4.2)."""
    return 1.0 / sum((1.0 - body.poissons_ratio**2) / body.youngs_modulus_MPa for body in (first, second))


def tangential_contact_modulus(first: Elastic, second: Elastic) -> float:
    """G* in MPa, 1/G* = Σ (2 − ν)/(4G) (Mindlin 1949; Johnson 1985, section 7.2)."""
    return 1.0 / sum((2.0 - body.poissons_ratio) / (4.0 * body.shear_modulus_MPa) for body in (first, second))


def require_positive(**values: float) -> None:
    """Raise ValueError naming the first argument that is not a positive number."""
    for name, value in values.items():
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, not {value:g}")
