"""wirewear and CalculiX on the same meshes of two crossed wires: agreement, time per increment and memory, in one run.

Usage: python -m studies.benchmarks.bench_calculix [--contact-mesh-um 10] [--method linmortar|penalty]
           [--rig 167.0|rigid]
           [--study-seconds S | --with-study quick|standard] [--most-minutes 10] [--output FOLDER]

Both run on one thread, one after the other. Times are CPU seconds; wirewear's condensation, done once for a wire, is
apart. CalculiX is stopped after --most-minutes and its increments until then are compared. Its files stay in the
output folder. --study-seconds: CPU time of a whole 100 000-cycle study; --with-study runs that of studies/steel_wires.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from wirewear.contact_problem import build_wire

from .calculix_deck import CalculixTest, deck
from .calculix_results import CalculixIncrement, increment_near, read_forces, read_peak_pressures
from .crossed_wires import BACK, OUT, AMPLITUDE_um, DRIVES_um, discretised, study
from .measured_process import ProcessCost, run_measured

#: Total CalculiX times at the end of the normal load and after each sliding increment.
PRESSED = 2.0
SLIDING = (*(PRESSED + (i + 1) / OUT for i in range(OUT)), *(PRESSED + 1.0 + (i + 1) / BACK for i in range(BACK)))
CYCLE_INCREMENTS = 40
ABSENT = "CalculiX is not installed, so there is nothing to compare with: apt-get install calculix-ccx"


@dataclass(frozen=True)
class WirewearSide:
    """wirewear's figures: CPU seconds, MPa, µm, N."""

    condensation_s: float
    press_s: float
    increments_s: list[float]
    peak_pressure_MPa: float
    approach_um: float
    tangential_force_N: list[float]

    @property
    def seconds_per_increment(self) -> float:
        """Mean over the normal load and the sliding increments."""
        return (self.press_s + sum(self.increments_s)) / (1 + len(self.increments_s))


def agreement(own: WirewearSide, increments: tuple[CalculixIncrement, ...], peaks: dict[float, float]) -> list[str]:
    """Lines of the table of agreement, as far as CalculiX came."""
    rows = [f"{'quantity':28}{'wirewear':>12}{'CalculiX':>12}{'difference':>12}"]

    def row(name: str, ours: float, theirs: float | None) -> None:
        beside = f"{'not reached':>12}" if theirs is None else f"{theirs:12.4f}{100.0 * (ours / theirs - 1.0):11.2f}%"
        rows.append(f"{name:28}{ours:12.4f}{beside}")

    pressed = increment_near(increments, PRESSED)
    row("p0 [MPa]", own.peak_pressure_MPa, next((p for t, p in peaks.items() if abs(t - PRESSED) < 1e-3), None))
    row("approach [um]", own.approach_um, None if pressed is None else -1e3 * float(pressed.holder_mm[2]))
    for drive, force, moment in zip(DRIVES_um, own.tangential_force_N, SLIDING, strict=True):
        there = increment_near(increments, moment)
        row(f"Q [N] at {drive:7.2f} um", force, None if there is None else float(there.grip_force_N[0]))
    return rows


def costs(
    own: WirewearSide, memory_MB: float, peer: ProcessCost, increments: int, study_s: float | None = None
) -> list[str]:
    """Lines of the table of costs; `increments` is how many CalculiX finished."""
    rows = [
        (
            f"wirewear: condensation {own.condensation_s:.1f} s; {own.seconds_per_increment:.4f} s an increment; "
            f"{memory_MB:.0f} MB"
        )
    ]
    if increments == 0:
        return [*rows, f"CalculiX: no increment finished in {peer.cpu_s:.0f} s; {peer.peak_memory_MB:.0f} MB"]
    each = peer.cpu_s / increments
    rows += [
        f"CalculiX: {each:.1f} s an increment over {increments} increments; {peer.peak_memory_MB:.0f} MB",
        (
            f"CalculiX / wirewear: {each / own.seconds_per_increment:.0f} in time an increment, "
            f"{peer.peak_memory_MB / memory_MB:.2f} in peak memory"
        ),
    ]
    if study_s is not None:
        cycle = CYCLE_INCREMENTS * each
        rows.append(
            f"100 000-cycle study {study_s:.0f} s / one CalculiX cycle of {CYCLE_INCREMENTS} increments {cycle:.0f} s "
            f"= {study_s / cycle:.3f}"
        )
    return rows


def main() -> int:
    """Run both and print the tables."""
    options = _options()
    program = shutil.which("ccx")
    if program is None:
        print(ABSENT)
        return 0
    folder = options.output or Path(tempfile.mkdtemp(prefix="wirewear-calculix-"))
    folder.mkdir(parents=True, exist_ok=True)
    mesh_um, rig = str(options.contact_mesh_um), options.rig
    side = ["studies.benchmarks.wirewear_side", mesh_um, rig, str(folder / "wirewear.json")]
    ours = run_measured(
        ["env", f"WIREWEAR_CACHE={tempfile.mkdtemp(dir=folder)}", sys.executable, "-m", *side],
        Path.cwd(),
        folder / "wirewear.log",
    )
    if ours.status != 0:
        print(f"wirewear failed; see {folder / 'wirewear.log'}")
        return 1
    own = WirewearSide(**json.loads((folder / "wirewear.json").read_text(encoding="utf-8")))
    _write_deck(folder, options)
    limit = f"{60.0 * options.most_minutes:.0f}"
    print(f"CalculiX is running, for at most {options.most_minutes:g} minutes; its files are in {folder}", flush=True)
    peer = run_measured(["timeout", limit, program, "-i", "wires"], folder, folder / "calculix.log")
    increments = read_forces(_text(folder / "wires.dat"))
    study_s = _study_seconds(options, folder)
    lines = [*agreement(own, increments, read_peak_pressures(_text(folder / "wires.frd"))), ""]
    lines += costs(own, ours.peak_memory_MB, peer, len(increments), study_s)
    print("\n".join(lines))
    (folder / "table.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


def _write_deck(folder: Path, options: argparse.Namespace) -> None:
    of = study(options.contact_mesh_um, options.rig)
    meshes = discretised(of)
    test = CalculixTest(
        normal_load_N=of.conditions.normal_load_N,
        approach_mm=meshes.hertz.approach_mm,
        amplitude_mm=1e-3 * AMPLITUDE_um,
        out=OUT,
        back=BACK,
        friction=of.contact.friction,
        rig_stiffness_N_per_mm=of.holder.tangential_stiffness_N_per_mm,
        youngs_modulus_MPa=of.moving_wire.youngs_modulus_MPa,
        poissons_ratio=of.moving_wire.poissons_ratio,
        method=options.method,
    )
    text = deck(build_wire(meshes.moving), build_wire(meshes.fixed), test)
    (folder / "wires.inp").write_text(text, encoding="utf-8")


def _study_seconds(options: argparse.Namespace, folder: Path) -> float | None:
    if options.with_study is None:
        return None if options.study_seconds is None else float(options.study_seconds)
    command = [
        "-c",
        "from wirewear.cli import main; main()",
        "run",
        "studies/steel_wires/study.toml",
        "--fidelity",
        options.with_study,
    ]
    output = folder / f"study-{time.time():.0f}"
    cost = run_measured([sys.executable, *command, "--output", str(output)], Path.cwd(), folder / "study.log")
    if cost.status != 0:
        print(f"the study failed; see {folder / 'study.log'}")
        return None
    return cost.cpu_s


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="wirewear and CalculiX on the same meshes")
    parser.add_argument("--contact-mesh-um", type=float, default=10.0)
    parser.add_argument("--method", choices=["linmortar", "penalty"], default="linmortar")
    parser.add_argument("--rig", default="167.0")
    parser.add_argument("--study-seconds", type=float)
    parser.add_argument("--with-study", choices=["quick", "standard"])
    parser.add_argument("--most-minutes", type=float, default=10.0)
    parser.add_argument("--output", type=Path)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
