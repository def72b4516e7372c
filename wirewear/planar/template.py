"""What studies of line contacts begin with."""

from wirewear.planar.tables import KINDS, PlanarStudy
from wirewear.study.template import Template

#: An alloy like Ti-6Al-4V.
TITANIUM = {"youngs_modulus_MPa": 116000.0, "poissons_ratio": 0.3}

#: A titanium cylinder on a titanium flat.
LINE_CONTACT = Template(
    KINDS[0],
    PlanarStudy,
    ("pad", "specimen", "conditions", "contact", "wear", "holder", "log"),
    {
        "pad": {"radius_mm": 40.0, **TITANIUM},
        "specimen": TITANIUM,
        "conditions": {
            "normal_load_N_per_mm": 390.0,
            "displacement_amplitude_um": 35.0,
            "cycles": 10000,
            "frequency_Hz": 5.0,
        },
        "contact": {"friction": 0.9},
        "wear": {"pad_energy_mm3_per_J": 2.0e-5, "specimen_energy_mm3_per_J": 4.0e-5},
        "holder": {"tangential_stiffness_N_per_mm2": "rigid"},
    },
    "A cylinder on a flat, to be changed into your line contact; everything is per mm of its length.",
)
