"""The benchmarks of scaling, of condensation and of the half-space."""

import ast
import time

import numpy as np
import pytest

from studies.benchmarks import bench_calculix
from studies.benchmarks.bench_condensation import splu_schur_complement
from studies.benchmarks.bench_half_space import periodic_correction
from studies.benchmarks.bench_scaling import PARTS, Increments, SizeClass, fitted_exponent, size_classes
from studies.benchmarks.bench_scaling import table as scaling_table
from studies.benchmarks.sampled_time import SampledTime
from tests.bodies import STEEL, brick, patch_on
from wirewear.simulation.workbench import (
    schur_complement,
    stiffness_matrix,
)


def test_the_exponent_of_a_power_law_is_found() -> None:
    assert fitted_exponent([10.0, 20.0, 40.0], [1.0, 4.0, 16.0]) == pytest.approx(2.0)
    with pytest.raises(ValueError, match="two sizes"):
        fitted_exponent([10.0], [1.0])


def test_images_matter_less_on_a_larger_domain() -> None:
    assert periodic_correction(2.0, 1e5) == pytest.approx(0.5 * periodic_correction(1.0, 1e5))


def test_time_goes_to_the_innermost_named_function() -> None:
    sampled = SampledTime({"outer": ((__file__, "outer_work"),), "inner": ((__file__, "inner_work"),)})
    with sampled:
        outer_work(0.2)
    seconds = sampled.seconds
    assert seconds["inner"] == pytest.approx(0.4, abs=0.1)
    assert seconds["outer"] == pytest.approx(0.2, abs=0.1)
    assert seconds["rest"] < 0.05


def outer_work(cpu_s: float) -> None:
    spin(cpu_s)
    inner_work(2.0 * cpu_s)


def inner_work(cpu_s: float) -> None:
    spin(cpu_s)


def spin(cpu_s: float) -> None:
    end = time.process_time() + cpu_s
    while time.process_time() < end:
        pass


def test_the_parts_of_a_run_are_functions_that_exist() -> None:
    for functions in PARTS.values():
        for file, name in functions:
            tree = ast.parse((bench_calculix.REPOSITORY / file).read_text(encoding="utf-8"))
            assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_increments_are_averaged_over_classes_of_doubled_size() -> None:
    increments = Increments(
        np.array([8.0] * 10 + [12.0] * 10 + [40.0] * 3), np.array([1.0] * 10 + [2.0] * 10 + [9.0] * 3)
    )
    assert size_classes(increments) == [SizeClass(20, 10.0, 1.5)]


def test_the_table_of_scaling_ends_with_the_exponent() -> None:
    rows = scaling_table([SizeClass(20, 10.0, 0.001), SizeClass(20, 20.0, 0.002), SizeClass(20, 40.0, 0.008)])
    assert rows[-2].endswith("power 1.50 (all)")
    assert rows[-1].endswith("power 2.00 (the larger half)")


def test_splu_and_nested_substructures_give_the_same_schur_complement() -> None:
    mesh = brick((6, 5, 4), (1.0, 0.9, 0.7), distortion=0.2)
    kept = patch_on(mesh).nodes.ravel()
    eliminated = np.setdiff1d(np.arange(len(mesh.points)), np.union1d(kept, mesh.surface_nodes("grip")))
    matrix = stiffness_matrix(mesh, STEEL)
    direct = splu_schur_complement(matrix, kept, eliminated, 3)
    assert direct == pytest.approx(schur_complement(matrix, kept, eliminated, 3), abs=1e-12 * np.abs(direct).max())
