"""Many tests on one sheet: running conditions, the material's response, worn volume against friction energy."""

from wirewear.maps.page import PAGE_NAME, write_maps
from wirewear.maps.reading import fretting_tests
from wirewear.maps.tables import maps_json, sentences, tests_table
from wirewear.maps.values import MappedTest, SlidingMap, WornTest
from wirewear.report.regression import RegressionLine, line_through_origin, line_with_threshold

__all__ = [
    "PAGE_NAME",
    "MappedTest",
    "RegressionLine",
    "SlidingMap",
    "WornTest",
    "fretting_tests",
    "line_through_origin",
    "line_with_threshold",
    "maps_json",
    "sentences",
    "tests_table",
    "write_maps",
]
