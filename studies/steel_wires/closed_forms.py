"""Both runs against what is known in closed form, and against the friction that the article measured."""

import numpy as np

from studies.verdicts import Comparison
from wirewear import ResultError, reference
from wirewear.loops import analyse_loop

from .pair import LATE, WIRES, Pair, analysed, value_of


def first_loop_comparisons(pair: Pair) -> list[Comparison]:
    """First simulated cycle against Hertz and the loop of a Cattaneo–Mindlin contact behind a spring, without wear."""
    study = pair.compliant.study
    wire = reference.Elastic(study["wires"]["youngs_modulus_MPa"], study["wires"]["poissons_ratio"])
    load, friction = study["conditions"]["normal_load_N"], study["contact"]["friction"]
    amplitude_mm = 1e-3 * study["conditions"]["displacement_amplitude_um"]
    rig = study["holder"]["tangential_stiffness_N_per_mm"]
    hertz = reference.hertz_point(load, 0.5 * study["wires"]["diameter_mm"], reference.contact_modulus(wire, wire))
    contact = reference.partial_slip_point(
        load, friction, hertz.contact_radius_mm, reference.tangential_contact_modulus(wire, wire)
    )
    first = {run.variant: {name: float(column[0]) for name, column in run.evolution.items()} for run in pair.runs}
    comparisons = []
    for run, stiffness in ((pair.compliant, rig), (pair.rigid, np.inf)):
        slip, energy = (first[run.variant][name] for name in ("slip_amplitude_um", "dissipated_energy_mJ"))
        slip_expected = 1e3 * reference.slip_amplitude(contact, amplitude_mm, stiffness)
        energy_expected = reference.dissipated_energy(contact, amplitude_mm, stiffness)
        comparisons += [
            Comparison(f"{run.variant}: δ0 [µm]", slip, slip_expected, 0.01, "closed form"),
            Comparison(f"{run.variant}: energy per cycle [mJ]", energy, energy_expected, 0.02, "closed form"),
        ]
    taken = first["rigid"]["slip_amplitude_um"] - first["compliant"]["slip_amplitude_um"]
    loop = pair.compliant.loops[0]
    ideal = reference.closed_loop(contact, amplitude_mm, rig, samples=loop.time_s.size)
    # The analysis fits a line to a curved branch: the same is done to the closed form, on as many samples.
    expected = analyse_loop(1e3 * ideal.displacement_mm, ideal.tangential_force_N).measured_stiffness_N_per_um
    stiffness = analysed(loop).measured_stiffness_N_per_um
    if stiffness is None or expected is None:
        raise ResultError("the first loop on the compliant rig shows no micro-slip branch to measure its stiffness on")
    return [
        *comparisons,
        Comparison("displacement taken by rig [µm]", taken, 1e3 * friction * load / rig, 0.05, "µP/K"),
        Comparison(
            "compliant: stiffness K_t,m [N/mm]", 1e3 * stiffness.value, 1e3 * expected.value, 0.05, "closed form"
        ),
        Comparison(
            "compliant: largest pressure before wear [MPa]",
            float(pair.compliant.settings.get("fresh_max_pressure_MPa", np.nan)),
            hertz.peak_pressure_MPa,
            0.02,
            "Hertz",
        ),
    ]


def volume_comparisons(pair: Pair) -> list[Comparison]:
    """Worn volume of each wire against its share of the wear coefficient times the friction energy."""
    comparisons = []
    for run in pair.runs:
        wear, evolution = run.study["wear"], run.evolution
        for wire, share in zip(WIRES, (wear["moving_share"], 1.0 - wear["moving_share"]), strict=True):
            volume = float(evolution[f"worn_volume_{wire}_mm3"][-1])
            expected = share * wear["energy_wear_coefficient_mm3_per_J"] * float(evolution["accumulated_energy_J"][-1])
            name = f"{run.variant}: worn off {wire} wire [10⁻³ mm³]"
            comparisons.append(Comparison(name, 1e3 * volume, 1e3 * expected, 1e-6, "energy law"))
    return comparisons


def worn_friction_comparison(pair: Pair) -> Comparison:
    """Geometry-independent friction of the late loop against the friction that the article measured in this way."""
    friction = analysed(pair.compliant.loop(LATE)).friction_geometry_independent
    expected = pair.compliant.study["contact"]["friction"]
    return Comparison("compliant: friction in the last loop", value_of(friction), expected, 0.02, "the article")
