"""What else is known of a test: its surroundings, its surfaces, and where it comes from."""

from datetime import date
from typing import Annotated, Literal, get_args

from pydantic import Field, PlainValidator

from wirewear.base.errors import Quantity, shown
from wirewear.study.keys import Table, checked_text, one_of


def _checked_date(value: object) -> str:
    text = value.isoformat() if isinstance(value, date) else value
    try:
        return date.fromisoformat(text).isoformat() if isinstance(text, str) else str(date.fromisoformat(""))
    except ValueError:
        raise ValueError(f"is {shown(value)}, but must be a date such as 2026-11-22") from None


#: Where a record may come from: a rig, or a simulation that was read as a rig's sensors would.
Source = Literal["measured", "simulated"]

Text = Annotated[str, PlainValidator(checked_text)]
DateOfTest = Annotated[str, PlainValidator(_checked_date)]
Temperature = Annotated[float, PlainValidator(Quantity("1", -273.15, 2000.0))]
Humidity = Annotated[float, PlainValidator(Quantity("1", 0.0, 100.0))]
Hardness = Annotated[float, PlainValidator(Quantity("1", 1.0, 10_000.0))]
Roughness = Annotated[float, PlainValidator(Quantity("um", 0.0, 1000.0))]


class Metadata(Table):
    """Keys that no computation asks for; all are optional."""

    source: Annotated[Source, PlainValidator(one_of(*get_args(Source)))] | None = Field(
        None, description='whether the test was "measured" or "simulated"; unknown where nothing is said'
    )
    laboratory: Text | None = Field(None, description="who made the test")
    date: DateOfTest | None = Field(None, description="day of the test")
    licence: Text | None = Field(None, description="what others may do with the data")
    temperature_C: Temperature | None = Field(None, description="temperature of the surroundings in degrees Celsius")
    relative_humidity_percent: Humidity | None = Field(None, description="relative humidity of the air")
    atmosphere: Text | None = Field(None, description="gas about the contact")
    lubricant: Text | None = Field(None, description="lubricant; none where it is dry")
    hardness_HV: Hardness | None = Field(None, description="Vickers hardness of the specimens")
    roughness_Ra_um: Roughness | None = Field(None, description="arithmetic mean roughness of the specimens")
    cracks: Annotated[str, PlainValidator(one_of("found", "none"))] | None = Field(
        None, description='whether cracks were looked for and "found", or "none" were', examples=["none"]
    )
    comment: Text | None = Field(None, description="anything else")

    @property
    def lines(self) -> tuple[str, ...]:
        """What is known, one ``key: value`` a line."""
        return tuple(f"{key}: {value}" for key, value in self.model_dump(exclude_none=True).items())
