"""What files state of bodies: described once for all kinds, in studies and records alike."""

import pickle

import pytest

from wirewear.records.contact_tables import RECORDS, RecordBody
from wirewear.records.importing.mapping import MAPPINGS
from wirewear.test.bodies import MountedBody, StatedBody
from wirewear.test.kinds import KINDS
from wirewear.test.line_bodies import Pad, Specimen
from wirewear.test.points import BallTable
from wirewear.test.shapes import SHAPES, GrippedBody, ShapedBody
from wirewear.test.wires import WireOverride


@pytest.mark.parametrize("table", [Pad, Specimen, BallTable, GrippedBody, ShapedBody, WireOverride, RecordBody])
def test_a_key_of_every_body_is_described_in_one_place(table: type[StatedBody]) -> None:
    assert issubclass(table, StatedBody)
    own = {
        key
        for one in table.__mro__
        if one.__module__ != StatedBody.__module__
        for key in vars(one).get("__annotations__", {})
    }
    assert own.isdisjoint({*MountedBody.model_fields} - {*WireOverride.__annotations__})


@pytest.mark.parametrize("name", SHAPES)
def test_the_keys_of_a_shape_are_keys_of_a_body(name: str) -> None:
    shape = SHAPES[name]
    assert {*shape.needs, *shape.takes, *shape.idle} <= {*ShapedBody.model_fields}


@pytest.mark.parametrize("name", KINDS)
def test_records_and_mappings_of_a_kind_follow_from_its_description(name: str) -> None:
    for tables in (RECORDS[name], MAPPINGS[name]):
        assert (tables.contact_kind, tables.body_names) == (name, KINDS[name].body_names)
        assert pickle.loads(pickle.dumps(tables)) is tables  # as other processes are sent it
