"""What bodies are made of."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Elastic:
    """An isotropic linear elastic material.

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
