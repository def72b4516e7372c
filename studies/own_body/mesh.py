"""Make ball.msh: half a steel ball of half an inch with a cone to its holder, of tetrahedra of ten nodes.

Run as `python -m studies.own_body.mesh`. Any other program may make such a file: what wirewear needs of it are solid
elements and names of the surfaces that may touch and that are held.
"""

from pathlib import Path

import gmsh

RADIUS_mm = 6.35
CONE_mm, NECK_mm = 6.0, 3.5  #: Height of the cone behind the ball, and the radius of its held end.
NEAR_mm, FAR_mm = 0.7, 2.2  #: Elements at the contact and far from it.


def write_ball(path: Path) -> None:
    """Mesh the ball, whose contact is at the origin and looks along +z, and write it with its named surfaces."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    solids = gmsh.model.occ
    ball = solids.addSphere(0.0, 0.0, -RADIUS_mm, RADIUS_mm)
    box = solids.addBox(-10.0, -10.0, -RADIUS_mm, 20.0, 20.0, 10.0)
    (half,), _ = solids.intersect([(3, ball)], [(3, box)])
    cone = solids.addCone(0.0, 0.0, -RADIUS_mm, 0.0, 0.0, -CONE_mm, RADIUS_mm, NECK_mm)
    solids.fuse([half], [(3, cone)])
    solids.synchronize()
    faces = [tag for _, tag in gmsh.model.getEntities(2)]
    gmsh.model.addPhysicalGroup(2, [tag for tag in faces if gmsh.model.getType(2, tag) == "Sphere"], name="face")
    gmsh.model.addPhysicalGroup(2, [tag for tag in faces if gmsh.model.getType(2, tag) == "Plane"], name="holder")
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="ball")
    sizes = gmsh.model.mesh.field
    near = sizes.add("Ball")
    for key, value in {"Radius": 1.5, "Thickness": 6.0, "VIn": NEAR_mm, "VOut": FAR_mm}.items():
        sizes.setNumber(near, key, value)
    sizes.setAsBackgroundMesh(near)
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{name}", 0)
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(path))
    gmsh.finalize()


if __name__ == "__main__":
    write_ball(Path(__file__).with_name("ball.msh"))
