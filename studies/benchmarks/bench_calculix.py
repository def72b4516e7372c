"""wirewear and CalculiX on the same meshes of two crossed wires: agreement, time per increment and memory, in one run.

Usage: python -m studies.benchmarks.bench_calculix [--contact-mesh-um 10] [--method linmortar|penalty]
           [--rig 167.0|rigid] [--with-study standard|quick|none] [--most-minutes 20] [--output FOLDER]

Both run on one thread, one after the other. Ratios are those of CPU seconds; wirewear's condensation, done once for a
wire, is apart. Only finished sliding increments of CalculiX count: not its approach, its normal load, nor an increment
that --most-minutes cut short; increments that it did not reach are marked. Its files stay in the output folder.
The whole study is the compliant variant of studies/steel_wires, 100 000 cycles, from an empty cache.
"""

import json
import shutil
import sys
import tempfile
from pathlib import Path

import click

from studies.study_script import StudyScript
from wirewear import Study
from wirewear.base.writing import prepared_folder
from wirewear.simulation.workbench import Discretisation, build_body

from .calculix_deck import CalculixTest, ContactMethod, deck
from .calculix_results import read_forces, read_peak_pressures
from .calculix_run import JOB, run_calculix, sliding_cost
from .comparison_tables import PRESSED, SLIDING, StudyCost, WirewearSide, agreement, costs
from .crossed_wires import BACK, OUT, discretised, study
from .measured_process import ProcessCost, run_measured

REPOSITORY = Path(__file__).resolve().parents[2]
ABSENT = "CalculiX is not installed, so there is nothing to compare with: apt-get install calculix-ccx"


@click.command(cls=StudyScript)
@click.option(
    "--contact-mesh-um",
    type=click.FloatRange(0.0, min_open=True),
    default=10.0,
    show_default=True,
    help="Size of the contact's elements.",
)
@click.option("--method", type=click.Choice(["linmortar", "penalty"]), default="linmortar", show_default=True)
@click.option("--rig", default="167.0", show_default=True, help="Stiffness in N/mm, or rigid.")
@click.option("--with-study", type=click.Choice(["standard", "quick", "none"]), default="standard", show_default=True)
@click.option("--most-minutes", type=click.FloatRange(0.0, min_open=True), default=20.0, show_default=True)
@click.option("--output", type=click.Path(file_okay=False, path_type=Path), help="[default: a temporary folder]")
def main(
    contact_mesh_um: float, method: ContactMethod, rig: str, with_study: str, most_minutes: float, output: Path | None
) -> None:
    """Run wirewear and CalculiX on the same meshes, and print the tables."""
    of = study(contact_mesh_um, rig)
    program = shutil.which("ccx")
    if program is None:
        click.echo(ABSENT)
        return
    folder = prepared_folder(output or Path(tempfile.mkdtemp(prefix="wirewear-calculix-"))).resolve()
    side = ["studies.benchmarks.wirewear_side", str(contact_mesh_um), rig, str(folder / "wirewear.json")]
    ours = _run_wirewear(["-m", *side], folder, "wirewear")
    if ours is None:
        raise SystemExit(1)
    own = WirewearSide(**json.loads((folder / "wirewear.json").read_text(encoding="utf-8")))
    write_deck(folder, of, discretised(of), method, (OUT, BACK))
    click.echo(f"CalculiX is running, for at most {most_minutes:g} minutes; its files are in {folder}")
    run = run_calculix(
        program,
        folder,
        60.0 * most_minutes,
        lambda one: click.echo(f"  time {one.time:.4f} of {SLIDING[-1]:g} after {one.cpu_s:.0f} s of CPU"),
    )
    increments, peaks = read_forces(_text(folder, "dat")), read_peak_pressures(_text(folder, "frd"))
    lines = [*agreement(own, increments, peaks), ""]
    sliding = sliding_cost(run.completed, PRESSED, SLIDING)
    lines += costs(own, ours.peak_memory_MB, run.cost, sliding, _study_cost(with_study, folder))
    click.echo("\n".join(lines))
    (folder / "table.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_deck(
    folder: Path, of: Study, meshes: Discretisation, method: ContactMethod, increments: tuple[int, int]
) -> None:
    """Write a study on wirewear's meshes as CalculiX's input; increments: out to +amplitude and back to -amplitude."""
    test = CalculixTest(
        normal_load_N=of.conditions.normal_load_N,
        approach_mm=meshes.hertz.approach_mm,
        amplitude_mm=1e-3 * of.conditions.displacement_amplitude_um,
        out=increments[0],
        back=increments[1],
        friction=of.contact.friction,
        rig_stiffness_N_per_mm=of.holder.tangential_stiffness_N_per_mm,
        youngs_modulus_MPa=of.bodies[0].youngs_modulus_MPa,
        poissons_ratio=of.bodies[0].poissons_ratio,
        method=method,
    )
    text = deck(build_body(meshes.moving), build_body(meshes.fixed), test)
    (folder / f"{JOB}.inp").write_text(text, encoding="utf-8")


def _study_cost(fidelity: str, folder: Path) -> StudyCost | None:
    if fidelity == "none":
        return None
    click.echo(f"wirewear is running the whole study, {fidelity}")
    file = str(REPOSITORY / "studies" / "steel_wires" / "study.toml")
    output = tempfile.mkdtemp(dir=folder, prefix="study-")
    chosen = ["--variant", "compliant", "--fidelity", fidelity, "--jobs", "1", "--output", output]
    command = ["-c", "from wirewear.app.cli import main; main()", "run", file, *chosen]
    cost = _run_wirewear(command, folder, "study")
    return None if cost is None else StudyCost(fidelity, cost.cpu_s, cost.wall_s)


def _run_wirewear(arguments: list[str], folder: Path, name: str) -> ProcessCost | None:
    """Run Python on this repository with an empty cache of condensed wires; None when it failed."""
    log = folder / f"{name}.log"
    with tempfile.TemporaryDirectory(dir=folder, prefix="cache-") as cache:
        cost = run_measured([sys.executable, *arguments], REPOSITORY, log, environment={"WIREWEAR_CACHE": cache})
    if cost.status != 0:
        click.echo(f"wirewear failed; see {log}")
        return None
    return cost


def _text(folder: Path, suffix: str) -> str:
    path = folder / f"{JOB}.{suffix}"
    return path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""


if __name__ == "__main__":
    main()
