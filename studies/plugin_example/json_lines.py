"""A reader of a logger that writes one JSON object per line."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear import RecordError
from wirewear.base.delimited import DelimitedLayout
from wirewear.records.importing.text_reader import Channel, Reader


class JsonLines(Reader):
    """One sample a line: {"t": 0.001, "x": 12.5, "Q": -0.31}."""

    kind = "json-lines"

    def reads(self, head: bytes) -> bool:
        """True if the file begins with an object."""
        return head.lstrip().startswith(b"{")

    def channels(self, path: Path) -> tuple[Channel, ...]:
        """The keys of the first object."""
        first = path.read_text(encoding="utf-8").lstrip().partition("\n")[0]
        return tuple(Channel(name) for name in json.loads(first))

    def columns(
        self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]
    ) -> dict[str, NDArray[np.float64]]:
        """Numbers (n,) under the wanted keys."""
        read: dict[str, list[float]] = {name: [] for name in wanted}
        for number, line in enumerate(path.read_text(encoding=layout.encoding).splitlines(), 1):
            try:
                sample = json.loads(line)
                for name, key in wanted.items():
                    read[name].append(float(sample[key]))
            except (ValueError, TypeError, LookupError):
                keys = ", ".join(map(str, wanted.values()))
                raise RecordError(f"{path}, line {number}: this is no JSON object with numbers {keys}.") from None
        return {name: np.array(values) for name, values in read.items()}
