"""Tables of wirewear beside CalculiX: agreement of results, and costs with the ratios that were aimed at."""

from dataclasses import dataclass

from .calculix_results import CalculixIncrement, increment_near
from .calculix_run import SlidingCost
from .crossed_wires import BACK, OUT, DRIVES_um
from .measured_process import ProcessCost

#: Total CalculiX times at the end of the normal load and after each sliding increment.
PRESSED = 2.0
SLIDING = (*(PRESSED + (i + 1) / OUT for i in range(OUT)), *(PRESSED + 1.0 + (i + 1) / BACK for i in range(BACK)))
CYCLE_INCREMENTS = 40


@dataclass(frozen=True)
class WirewearSide:
    """wirewear's figures: seconds of CPU and wall time, MPa, µm, N; one entry for each of DRIVES_um in the lists."""

    condensation_s: float
    press_s: float
    increments_s: list[float]
    increments_wall_s: list[float]
    peak_pressure_MPa: float
    approach_um: float
    tangential_force_N: list[float]
    rise_um: list[float]


@dataclass(frozen=True)
class StudyCost:
    """A whole study of 100 000 cycles: its fidelity, condensation included."""

    fidelity: str
    cpu_s: float
    wall_s: float


def agreement(own: WirewearSide, increments: tuple[CalculixIncrement, ...], peaks: dict[float, float]) -> list[str]:
    """Lines of the tables of agreement, as far as CalculiX came. increments: from .dat; peaks: MPa at each total time.

    rise: of the upper wire's holder since the end of the normal load.
    """
    pressed = increment_near(increments, PRESSED)
    approach_um = None if pressed is None else -1e3 * float(pressed.holder_mm[2])
    peak = next((p for t, p in peaks.items() if abs(t - PRESSED) < 1e-3), None)
    rows = [
        f"{'under the normal load':22}{'wirewear':>12}{'CalculiX':>12}{'difference':>12}",
        f"{'p0 [MPa]':22}{_beside(own.peak_pressure_MPa, peak)}",
        f"{'approach [um]':22}{_beside(own.approach_um, approach_um)}",
        f"{'':22}{'Q [N]':>36}{'rise [um]':>24}{'P [N]':>12}",
        (
            f"{'sliding, drive [um]':22}{'wirewear':>12}{'CalculiX':>12}{'difference':>12}{'wirewear':>12}"
            f"{'CalculiX':>12}{'CalculiX':>12}"
        ),
    ]
    for drive, force, rise, moment in zip(DRIVES_um, own.tangential_force_N, own.rise_um, SLIDING, strict=True):
        row = f"{drive:22.2f}"
        there = increment_near(increments, moment)
        if there is None or approach_um is None:
            row += f"{_beside(force, None)}{'':12}{rise:12.4f}"
        else:
            x, _, z = there.grip_force_N.tolist()
            row += f"{_beside(force, x)}{rise:12.4f}{1e3 * float(there.holder_mm[2]) + approach_um:12.4f}{z:12.4f}"
        rows.append(row)
    return rows


def _beside(ours: float, theirs: float | None) -> str:
    if theirs is None:
        return f"{ours:12.4f}{'not reached':>12}"
    return f"{ours:12.4f}{theirs:12.4f}{100.0 * (ours / theirs - 1.0):11.2f}%"


def costs(
    own: WirewearSide, memory_MB: float, peer: ProcessCost, sliding: SlidingCost | None, study: StudyCost | None = None
) -> list[str]:
    """Lines of the table of costs, over the sliding increments that both finished."""
    ended = "stopped" if peer.stopped else "finished"
    head = f"CalculiX {ended} after {peer.cpu_s:.0f} s of CPU, {peer.wall_s:.0f} s of wall time"
    if sliding is None:
        return [f"{head}, in which no sliding increment was finished; {peer.peak_memory_MB:.0f} MB"]
    n = sliding.increments
    own_cpu_s, own_wall_s = sum(own.increments_s[:n]) / n, sum(own.increments_wall_s[:n]) / n
    aims = {"CPU": sliding.cpu_s / own_cpu_s, "memory": peer.peak_memory_MB / memory_MB}
    rows = [
        f"{head}; {n} of {len(SLIDING)} sliding increments",
        f"{'cost':28}{'wirewear':>12}{'CalculiX':>12}{'ratio':>12}",
        (
            f"{'CPU s / sliding increment':28}{own_cpu_s:12.4f}{sliding.cpu_s:12.2f}{aims['CPU']:12.0f}"
            f"   {_verdict(aims['CPU'] >= 200.0)}: at least 200"
        ),
        f"{'wall s / sliding increment':28}{own_wall_s:12.4f}{sliding.wall_s:12.2f}{sliding.wall_s / own_wall_s:12.0f}",
        (
            f"{'peak memory [MB]':28}{memory_MB:12.0f}{peer.peak_memory_MB:12.0f}{aims['memory']:12.2f}"
            f"   {_verdict(aims['memory'] >= 1.0)}: at least 1"
        ),
        f"{'condensation [CPU s], once':28}{own.condensation_s:12.2f}",
    ]
    if study is not None:
        cycle_s = CYCLE_INCREMENTS * sliding.cpu_s
        rows.append(
            f"whole study of 100 000 cycles, {study.fidelity}, condensation included: {study.cpu_s:.0f} s of CPU, "
            f"{study.wall_s:.0f} s of wall time\n"
            f"one CalculiX cycle of {CYCLE_INCREMENTS} increments: {cycle_s:.0f} s of CPU; study / cycle = "
            f"{study.cpu_s / cycle_s:.3f}   {_verdict(study.cpu_s < cycle_s / 5.0)}: less than 0.2"
        )
    return rows


def _verdict(reached: bool) -> str:
    return "reached" if reached else "NOT reached"
