"""Combined elastic constants of two bodies in contact (N, mm, MPa)."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Elastic:
    """Isotropic linear elastic material.

    Raises ValueError unless the modulus is positive and Poisson's ratio lies between 0 and 0.5.
    """

    youngs_modulus_MPa: float
    poissons_ratio: float

    def __post_init__(self) -> None:
        if not self.youngs_modulus_MPa > 0.0:
            raise ValueError(f"youngs_modulus_MPa must be positive, not {self.youngs_modulus_MPa:g}")
        if not 0.0 <= self.poissons_ratio <= 0.5:
            raise ValueError(f"poissons_ratio must lie between 0 and 0.5, not {self.poissons_ratio:g}")

    @property
    def shear_modulus_MPa(self) -> float:
        """G = E / 2(1 + ν)."""
        return self.youngs_modulus_MPa / (2.0 * (1.0 + self.poissons_ratio))


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
