"""gmsh session that sweeps a cross-section of transfinite quadrilaterals into hexahedra."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_HEXAHEDRON = 5


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """A quiet, reproducible gmsh session; gmsh's own errors become GeometryError."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        for name, value in {"General.Terminal": 0, "General.NumThreads": 1, "Mesh.RandomSeed": 1}.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    except GeometryError:
        raise
    except Exception as error:
        raise GeometryError(f"gmsh could not mesh the body: {error}") from error
    finally:
        gmsh.finalize()


def extruded_hexahedra(section: Array, quads: IntArray, lines_mm: Array) -> tuple[Array, IntArray]:
    """Sweep a section along x.

    section: (n, 2) points (y, z) in mm; quads: (m, 4) counter-clockwise; lines_mm: (k,) mesh lines on x, first one 0.
    Returns points (n k, 3) and cells (m (k - 1), 8) in VTK order; GeometryError when gmsh leaves anything but
    hexahedra.
    """
    with gmsh_session() as gmsh:
        geo = gmsh.model.geo
        vertices = [geo.addPoint(y, z, 0.0) for y, z in section]
        lines: dict[tuple[int, int], int] = {}

        def line(a: int, b: int) -> int:
            if (b, a) in lines:
                return -lines[b, a]
            if (a, b) not in lines:
                lines[a, b] = int(geo.addLine(vertices[a], vertices[b]))
            return lines[a, b]

        surfaces = []
        for quad in quads.tolist():
            loop = geo.addCurveLoop([line(quad[i], quad[(i + 1) % 4]) for i in range(4)])
            surfaces.append((2, int(geo.addPlaneSurface([loop]))))
        for tag in lines.values():
            geo.mesh.setTransfiniteCurve(tag, 2)
        for _, tag in surfaces:
            geo.mesh.setTransfiniteSurface(tag)
            geo.mesh.setRecombine(2, tag)
        # Else gmsh looks for coincident entities after every single quadrilateral.
        gmsh.option.setNumber("Geometry.AutoCoherence", 0)
        length = float(lines_mm[-1])
        layers = [1] * (len(lines_mm) - 1)
        geo.extrude(surfaces, 0.0, 0.0, length, layers, list(lines_mm[1:] / length), recombine=True)
        geo.removeAllDuplicates()
        geo.synchronize()
        gmsh.model.mesh.generate(3)
        return _collect(gmsh)


def _collect(gmsh: Any) -> tuple[Array, IntArray]:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    types, _, _ = gmsh.model.mesh.getElements(3)
    if list(types) != [_HEXAHEDRON]:
        raise GeometryError("gmsh left other elements than hexahedra in the body; please report this study")
    cells = gmsh.model.mesh.getElementsByType(_HEXAHEDRON)[1].astype(np.int64).reshape(-1, 8)
    row = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    used = np.unique(row[cells])
    new = np.full(len(tags), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    y, z, x = coordinates.reshape(-1, 3)[used].T
    return np.column_stack([x, y, z]), new[row[cells]]
