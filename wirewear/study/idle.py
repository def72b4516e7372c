"""Keys that a study states and that act in none of its runs, as others decide in their place; they are refused."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from wirewear.base.errors import StudyError
from wirewear.study.any_study import AnyStudy
from wirewear.study.drive import BulkTable
from wirewear.study.keys import Inconsistency, Table
from wirewear.study.messages import place, table_above
from wirewear.study.points import ShapedBody
from wirewear.study.surfaces import StatedSurface
from wirewear.study.tables import CommonTables

Rule = Callable[[CommonTables], Iterator[Inconsistency]]


def require_no_idle_key(study: AnyStudy[Any], where: str) -> None:
    """See that every key that a study states acts in one of its variants and blocks at least.
    Raises StudyError, in one sentence, for one that does not.
    """
    runs = tuple(_runs(study))
    for rule in _RULES:
        idle = [{found.keys: found for found in rule(tables)} for tables in runs]
        for keys, found in idle[0].items():
            if all(keys in other for other in idle):
                raise StudyError(f"{keys[-1]} {place(keys, where, table_above)} {found.problem}.")


def _runs(study: AnyStudy[Any]) -> Iterator[CommonTables]:
    """The tables of every variant, under every block of its programme."""
    for own in [study.variant(name) for name in study.variant_names] or [study]:
        yield from {id(stretch.study): stretch.study.tables for stretch in own.schedule.stretches}.values()


def _pivot(tables: CommonTables) -> Iterator[Inconsistency]:
    holder = tables.holder
    key = next(key for key in type(holder).model_fields if key.startswith("rotational_stiffness"))
    if holder.pivot_height_mm is not None and getattr(holder, key) == "rigid":
        yield Inconsistency(
            ("holder", "pivot_height_mm"),
            f"is {holder.pivot_height_mm:g}, but without {key} nothing turns about that pivot: give both, or neither",
        )


def _nodes(tables: CommonTables) -> Iterator[Inconsistency]:
    mesh = tables.mesh
    if getattr(mesh, "move_nodes_at_stages", False) and mesh.move_nodes_every_um is not None:
        yield Inconsistency(
            ("mesh", "move_nodes_at_stages"),
            "is true, but move_nodes_every_um says when nodes are moved: give one of the two",
        )


def _averaging(tables: CommonTables) -> Iterator[Inconsistency]:
    life = tables.life
    if life is None:
        return
    if life.averaging_length_um is not None:
        for key, given in (
            ("critical_distance_um", life.critical_distance_um is not None),
            ("averaging", life.averaging != "volume"),
        ):
            if given:
                yield Inconsistency(
                    ("life", key), "is given, but averaging_length_um takes its place: give one of the two"
                )


def _shapes(tables: CommonTables) -> Iterator[Inconsistency]:
    for keys, body in _inner(tables, ShapedBody):
        if body.shape in ("wire", "tube"):
            if body.height_mm is not None:
                yield Inconsistency((*keys, "height_mm"), f"is of blocks, but a {body.shape} is as high as it is thick")
            if body.held_at == "ends" and body.grip_angle_deg != _GRIP_deg:
                yield Inconsistency((*keys, "grip_angle_deg"), 'is of a back that is held, but held_at is "ends"')
        elif body.grip_angle_deg != _GRIP_deg:
            yield Inconsistency(
                (*keys, "grip_angle_deg"), f"is of wires and tubes, but a {body.shape} is held at its back and sides"
            )


_GRIP_deg = ShapedBody.model_fields["grip_angle_deg"].default


def _phases(tables: CommonTables) -> Iterator[Inconsistency]:
    for keys, bulk in _inner(tables, BulkTable):
        if bulk.phase_deg and not any(value for key, value in bulk if "amplitude" in key):
            yield Inconsistency(
                (*keys, "phase_deg"), "is given, but no amplitude of the stress, which alone has a phase"
            )


def _inner(tables: Table, kind: type[Any], *above: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The tables of a kind within others, with their places."""
    for key, value in tables:
        if isinstance(value, kind):
            yield (*above, key), value
        if isinstance(value, Table) and not isinstance(value, StatedSurface):
            yield from _inner(value, kind, *above, key)


_RULES: Sequence[Rule] = (_pivot, _nodes, _averaging, _shapes, _phases)
