"""Section ``sensor_cluster`` of a scenario: what stands between the inertial sensors and their frames."""

from typing import Literal

from pydantic import Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from vehicle_model.parameters import ParameterInfo

CLUSTER_PARAMETERS = (
    ParameterInfo(
        "sensor_cluster.supply", "1", 1.0, 1.0, 0.0, 1.0, 1.0, "relay in the supply of the sensor block: 1 closed", ""
    ),
    ParameterInfo(
        "sensor_cluster.bit_error_rate",
        "1",
        0.0,
        0.0,
        0.0,
        0.5,
        0.0,
        "of the sensor block's answers on the SPI line",
        "",
    ),
)
"""What stimuli can change of a cluster."""


class PlausibilityChoice(FileModel):
    """Low-pass and plausibility check of the simulated microcontroller (friction document 1.3; numbers are ours)."""

    cutoff_hz: float = parameter("Hz", 100.0, low=1.0, high=400.0, description="corner of the first-order low-pass")
    range_share: float = parameter(
        "1", 0.95, low=0.01, high=1.0, description="share of the measuring range beyond which a value is out of range"
    )
    step_share: float = parameter(
        "1", 0.25, low=0.001, high=2.0, description="share of the measuring range that a value may change in 1 ms"
    )
    bad_samples: int = Field(default=5, ge=1, le=1000, description="in a row until a channel is invalid")
    good_samples: int = Field(default=20, ge=1, le=1000, description="in a row until it is valid again")
    frozen_samples: int = Field(
        default=500, ge=2, le=100_000, description="without change, while other channels change, until it is frozen"
    )


class SensorClusterChoice(FileModel):
    """The inertial sensor cluster: not modelled, simulated, or a real microcontroller on the bench's SPI slave."""

    kind: Literal["none", "simulated", "external"] = Field(
        default="none",
        description="none: the sensors' values go into the frames; simulated: through SPI and a simulated "
        "microcontroller; external: a real one reads the bench's sensor block and sends the frames itself",
    )
    device: str | None = Field(default=None, description="serial line of the SPI adapter, for external")
    baud_rate: int = Field(default=1_000_000, ge=9600, le=4_000_000, description="of that line")
    plausibility: PlausibilityChoice = Field(
        default_factory=PlausibilityChoice, description="of the simulated microcontroller"
    )

    @model_validator(mode="after")
    def _device_where_needed(self) -> "SensorClusterChoice":
        if self.kind == "external" and not self.device:
            raise FieldError(
                "an external cluster without its serial line", at=("device",), allowed="device: /dev/ttyUSB0"
            )
        return self
