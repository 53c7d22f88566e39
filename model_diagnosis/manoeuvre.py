"""One manoeuvre of measured data as the diagnosis sees it: equal steps, SI units, a weight for each sample."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.result import DataFault

FloatArray = NDArray[np.float64]

SAMPLE_TIME_S = 0.01


@dataclass(frozen=True)
class Manoeuvre:
    """Channels of one manoeuvre on one time base.

    Attributes
    ----------
    time : (n,) array [s], equal steps of ``SAMPLE_TIME_S`` from 0
    channels : catalogue name -> (n,) array in the catalogue's unit (finite everywhere)
    weights : catalogue name -> (n,) array; 0 where the sample is missing, held or invalid, else 1
    source : file and stretch it was cut from, for messages
    origins : catalogue name -> "<logger>" or "<logger>:<CAN message>" that the channel came with
    start_s : the log's own time of the first sample [s], from the drive's begin
    reading_faults : what was wrong with the samples before they were put on this time base
    drive : logs of the drive that it was cut from; manoeuvres of one drive follow each other in time
    phases : catalogue name -> how far behind its instant of ``time`` each sample of a channel was taken [s], up to half
        a step to either side; 0 where it is not named
    set_back_s : logger -> by how much its clock was set back in this drive alone when it was read [s]
    """

    name: str
    time: FloatArray
    channels: Mapping[str, FloatArray]
    weights: Mapping[str, FloatArray]
    source: str
    origins: Mapping[str, str] = field(default_factory=dict)
    start_s: float = 0.0
    reading_faults: tuple[DataFault, ...] = ()
    drive: str = ""
    phases: Mapping[str, float] = field(default_factory=dict)
    set_back_s: Mapping[str, float] = field(default_factory=dict)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.time)

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

    def weight(self, channel: str) -> FloatArray:
        """Weights (n,) of a channel; zeros where the channel is missing altogether."""
        return self.weights.get(channel, np.zeros(self.samples))

    def part(self, begin: int, end: int) -> "Manoeuvre":
        """Samples ``begin`` to ``end`` as a manoeuvre of the same name."""
        return replace(
            self,
            time=self.time[begin:end] - self.time[begin],
            channels={name: values[begin:end] for name, values in self.channels.items()},
            weights={name: values[begin:end] for name, values in self.weights.items()},
            start_s=self.start_s + SAMPLE_TIME_S * begin,
        )

    def on_one_raster(self) -> "Manoeuvre":
        """The same with every channel at the instants of ``time``, by straight lines between its samples."""
        if not self.phases:
            return self
        moved = {
            name: np.interp(self.time, self.time + self.phases[name], values) if name in self.phases else values
            for name, values in self.channels.items()
        }
        return replace(self, channels=moved, phases={})
