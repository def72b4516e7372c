"""Condensation of a wire by quarters and by nested substructures beside scipy's sparse factorisation.

Usage: python -m studies.benchmarks.bench_condensation [--contact-mesh-um 10 --contact-mesh-um 7]

Both compute the Schur complement of the same stiffness matrix onto the nodes of the contact patch, each in a process
of its own on one thread. scipy's splu gets METIS's nested-dissection order of the inner nodes with the patch's nodes
last and pivots on the diagonal, the fastest way that it has; the Schur complement is then the product of the trailing
blocks of its factors (Golub & Van Loan, Matrix Computations, 4th ed., 3.2.11). By quarters, four Schur complements of a
quarter of the wire are computed by the same nested substructures, as wirewear does. Assembly of the matrix is not
timed; memory is the whole process's.
"""

import json
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from wirewear.faces.study_script import StudyScript
from wirewear.simulation.workbench import (
    Elastic,
    build_body,
    compliance_of,
    piece_to_condense,
    schur_complement,
    schur_complements,
    stiffness_matrix,
)

from .crossed_wires import discretised, of_contact_meshes, study
from .measured_process import run_measured

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

REPOSITORY = Path(__file__).resolve().parents[2]
METHODS = {"by quarters": "quarters", "nested substructures": "whole", "scipy splu": "splu"}


@dataclass(frozen=True)
class Solution:
    """One method's Schur complement, the CPU seconds it took and the largest memory of its process."""

    seconds: float
    memory_MB: float
    schur: Array


def splu_schur_complement(matrix: csr_matrix, kept: IntArray, eliminated: IntArray, unknowns_per_node: int) -> Array:
    """Schur complement onto the kept nodes by scipy's splu, shapes and order as those of `schur_complement`.

    RuntimeError when splu left the order that it was given, as then the trailing blocks are not those of the patch.
    """
    import pymetis
    from scipy.sparse.linalg import splu

    d = unknowns_per_node
    rows, columns = matrix[_unknowns(eliminated, d)][:, _unknowns(eliminated, d)].nonzero()
    off = rows // d != columns // d
    n = len(eliminated)
    graph = csr_matrix((np.ones(off.sum(), dtype=np.int8), (rows[off] // d, columns[off] // d)), shape=(n, n))
    graph.sum_duplicates()
    order, _ = pymetis.nested_dissection(pymetis.CSRAdjacency(graph.indptr, graph.indices))
    unknowns = _unknowns(np.concatenate([eliminated[np.asarray(order)], kept]), d)
    factors = splu(
        matrix[unknowns][:, unknowns].tocsc(),
        permc_spec="NATURAL",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    if not (
        np.array_equal(factors.perm_r, factors.perm_c) and np.array_equal(factors.perm_c, np.arange(len(unknowns)))
    ):
        raise RuntimeError("splu changed the order of the unknowns")
    first = d * n
    return np.asarray((factors.L[first:, first:] @ factors.U[first:, first:]).toarray())


def solve_one(method: str, contact_mesh_um: float, folder: Path) -> None:
    """Condense the moving wire of the benchmarks; leave schur.npy and result.json in the folder."""
    of = study(contact_mesh_um)
    wire = build_body(discretised(of).moving)
    steel = Elastic(of.bodies[0].youngs_modulus_MPa, of.bodies[0].poissons_ratio)
    gripped = wire.mesh.surface_nodes("grip")
    kept = wire.patch.nodes.ravel()
    eliminated = np.setdiff1d(np.arange(len(wire.mesh.points)), np.union1d(kept, gripped))
    if method == "quarters":
        piece = piece_to_condense(wire.mesh, wire.patch, gripped)
        matrix = stiffness_matrix(piece.mesh, steel)
        start = time.process_time()
        schurs = schur_complements(matrix, piece.contact, piece.inner, 3, piece.held)
        seconds = time.process_time() - start
        schur = np.linalg.inv(compliance_of(piece, wire.patch, schurs).dense)
    else:
        matrix = stiffness_matrix(wire.mesh, steel)
        start = time.process_time()
        way = schur_complement if method == "whole" else splu_schur_complement
        schur = way(matrix, kept, eliminated, 3)
        seconds = time.process_time() - start
    np.save(folder / "schur.npy", schur)
    figures = {"seconds": seconds, "unknowns": 3 * (len(kept) + len(eliminated)), "kept": 3 * len(kept)}
    (folder / "result.json").write_text(json.dumps(figures), encoding="utf-8")


def compare(contact_mesh_um: float) -> list[str]:
    """Lines of the table for one mesh; RuntimeError with what a process printed when it failed."""
    solutions = {}
    for name, method in METHODS.items():
        with tempfile.TemporaryDirectory() as given:
            folder = Path(given)
            asked = ["--one", method, str(folder), "--contact-mesh-um", str(contact_mesh_um)]
            command = [sys.executable, "-m", "studies.benchmarks.bench_condensation", *asked]
            cost = run_measured(command, REPOSITORY, folder / "log")
            if cost.status != 0:
                raise RuntimeError(f"{name} failed:\n{(folder / 'log').read_text(encoding='utf-8', errors='replace')}")
            figures = json.loads((folder / "result.json").read_text(encoding="utf-8"))
            solutions[name] = Solution(figures["seconds"], cost.peak_memory_MB, np.load(folder / "schur.npy"))
    peer = solutions["scipy splu"]
    lines = [f"{contact_mesh_um:g} um: {figures['unknowns']} unknowns, {figures['kept']} of them kept"]
    for name, one in solutions.items():
        lines.append(f"  {name:22}{one.seconds:9.2f} s of CPU{one.memory_MB:9.0f} MB")
        if one is not peer:
            difference = np.abs(one.schur - peer.schur).max() / np.abs(peer.schur).max()
            ratios = f"{peer.seconds / one.seconds:.1f} in time, {peer.memory_MB / one.memory_MB:.1f} in memory"
            lines[-1] += f"; splu / this: {ratios}; differs by {difference:.1e} of the largest entry"
    return lines


def _unknowns(nodes: IntArray, d: int) -> IntArray:
    return np.asarray((d * nodes[:, None] + np.arange(d)).ravel())


@click.command(cls=StudyScript)
@of_contact_meshes
@click.option(
    "--one",
    type=(click.Choice(tuple(METHODS.values())), click.Path(exists=True, file_okay=False, path_type=Path)),
    metavar="METHOD FOLDER",
    help="One method on the first mesh in this process; its matrix goes to FOLDER.",
)
def main(contact_mesh_um: tuple[float, ...], one: tuple[str, Path] | None) -> None:
    """Compare nested substructures and quarters with scipy's splu, and print."""
    if one is not None:
        solve_one(one[0], contact_mesh_um[0], one[1])
        return
    for mesh_um in contact_mesh_um:
        click.echo("\n".join(compare(mesh_um)))


if __name__ == "__main__":
    main()
