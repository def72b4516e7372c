"""What came out of a rig stiffness run, on one screen."""

from rich.console import Group, RenderableType

from wirewear.planar.rig_stiffness.results import RigStiffnessResult, differences
from wirewear.planar.summary import titled_table, worst_residuals

_CASES = (
    "contact",
    "case",
    "scenario",
    "K_t,m\n[N/mm²]",
    "θ_max\n[°]",
    "Q_max\n[N/mm]",
    "δ0\n[µm]",
    "regime",
    "cycles",
)
_DIFFERENCES = (
    "contact",
    "case",
    "K_t,m\nratio",
    "loop, share\nof Q_max",
    "pressure centre\nmoved [µm]",
    "reshaped, share\nof load",
    "peak\nratio",
    "width\nratio",
    "mean slip\n[µm]",
)
_WORDS = ("contact", "regime")


def rig_stiffness_summary(result: RigStiffnessResult) -> RenderableType:
    """All cases in both scenarios, what scenario 2 changes, and the worst residual of each kind."""
    cases = titled_table(result.name, _CASES, _WORDS)
    for run in result.runs:
        cases.add_row(
            run.contact,
            str(run.case),
            str(run.scenario),
            f"{run.measured_stiffness_N_per_mm2:.4g}",
            f"{run.largest_tilt_deg:.3g}" if run.scenario == 2 else "–",
            f"{run.largest_force_N_per_mm:.4g}",
            f"{run.slip_amplitude_of_loop_um:.2f}",
            run.regime,
            str(run.cycles),
        )
    changes = titled_table("scenario 2 (rotation) against scenario 1 (translation)", _DIFFERENCES, _WORDS)
    for change in differences(result):
        changes.add_row(
            change.contact,
            str(change.case),
            f"{change.stiffness_ratio:.4f}",
            f"{change.loop:.2%}",
            f"{change.pressure_centre_um:.0f}",
            f"{change.pressure_reshaped:.1%}",
            f"{change.peak_pressure_ratio:.3f}",
            f"{change.width_ratio:.3f}",
            f"{change.mean_slip_um:+.2f}",
        )
    worst = {
        name: max(getattr(run, name) for run in result.runs)
        for name in ("force_balance", "penetration", "complementarity", "shakedown_change")
    }
    return Group(cases, changes, worst_residuals(worst))
