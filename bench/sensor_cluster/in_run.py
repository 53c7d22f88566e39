"""The sensor cluster in a run: its microcontroller simulated, or a real one that reads the bench's sensor block.

Friction document 1.3: (A) sensor block simulated, real microcontroller; (B) microcontroller simulated. Both stand
between the sensors and the frames of the inertial signals.
"""

import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from bench.codec.codec import Transmitter
from bench.loop.children import Child, on_helper_cores, start_module
from bench.loop.scheduling import plan_cores
from bench.scenario.cluster_choice import SensorClusterChoice
from bench.sensor_cluster.microcontroller import (
    REQUESTS,
    VALUE,
    Microcontroller,
    MicrocontrollerMemory,
    Plausibility,
    take_answers,
)
from bench.sensor_cluster.sensor_block import (
    CHANNELS,
    SERVED,
    STARTUP_TRANSFERS,
    FloatArray,
    SensorBlock,
    set_registers,
    switch_supply,
    transfer,
)
from bench.sensor_cluster.words import WORD_BYTES, IntArray
from signals.catalogue import block_slice, index_of
from signals.errors import RunError

SUPPLY, BIT_ERROR_RATE = "sensor_cluster.supply", "sensor_cluster.bit_error_rate"
START_TIMEOUT_S = 60.0


class SpiLine(NamedTuple):
    """Sensor block and line to it for the compiled calls, which work in place.

    Attributes
    ----------
    registers : int64 array
        Memory of the sensor block.
    answers : int64 array, shape (7,)
        Words that the master read in the cycle.
    uniform : float64 array, shape (7, 32)
        A number from [0, 1) for each bit of a cycle; the bit is wrong where it lies below the bit error rate.
    """

    registers: IntArray
    answers: IntArray
    uniform: FloatArray


@njit(cache=True)
def _wrong_bits(uniform: FloatArray, bit_error_rate: float) -> int:
    """Mask of the bits of a word that arrive wrong."""
    mask = 0
    for k in range(uniform.shape[0]):
        if uniform[k] < bit_error_rate:
            mask |= 1 << k
    return mask


@njit(cache=True)
def _exchange(line: SpiLine, memory: MicrocontrollerMemory, bit_error_rate: float) -> bool:
    """The transfers of 1 ms and what the microcontroller makes of them; True while every channel is valid."""
    for k in range(REQUESTS.shape[0]):
        wrong = _wrong_bits(line.uniform[k], bit_error_rate) if bit_error_rate > 0.0 else 0
        line.answers[k] = transfer(line.registers, REQUESTS[k]) ^ wrong
    return take_answers(memory, line.answers)


@njit(cache=True)
def _tick(
    line: SpiLine,
    memory: MicrocontrollerMemory,
    sensed: FloatArray,
    positions: IntArray,
    supplied: bool,
    bit_error_rate: float,
) -> bool:
    """Sensors' values into the block, through line and microcontroller, and back to where the frames take them."""
    set_registers(line.registers, sensed, positions)
    switch_supply(line.registers, supplied)
    valid = _exchange(line, memory, bit_error_rate)
    for k in range(positions.shape[0]):
        sensed[positions[k]] = memory.channels[k, VALUE]
    return valid


class _Cluster:
    """What both kinds share: the sensor block, its supply, and where the signals stand."""

    hears_the_bus = False

    def __init__(self, block: SensorBlock, sensed: FloatArray, transmitter: Transmitter) -> None:
        first = block_slice("bus").start
        self._block = block
        self._sensed = sensed
        self._positions = np.array([index_of(name) - first for name in CHANNELS])
        self._transmitter = transmitter
        self._rows = transmitter.rows_of(CHANNELS)
        self._parameters = {SUPPLY: 1.0, BIT_ERROR_RATE: 0.0}

    def names(self) -> tuple[str, ...]:
        """Parameters that stimuli can change."""
        return tuple(self._parameters)

    def get(self, path: str) -> float:
        """Value of a parameter."""
        return self._parameters[path]

    def set(self, path: str, value: float) -> None:
        """Change a parameter from the next tick on."""
        self._parameters[path] = value

    def start(self) -> None:
        """Called before the clock starts."""

    def stop(self) -> None:
        """Called when the run is over."""

    def summary(self) -> dict[str, Any]:
        """For the verdict's timing block."""
        return {}


class SimulatedCluster(_Cluster):
    """Case B: SPI line and microcontroller are simulated; frames of implausible values are not sent."""

    def __init__(self, choice: SensorClusterChoice, sensed: FloatArray, transmitter: Transmitter, seed: int) -> None:
        super().__init__(SensorBlock(), sensed, transmitter)
        self._microcontroller = Microcontroller(Plausibility(**choice.plausibility.model_dump()))
        self._random = np.random.default_rng((seed, 0x5C1))
        words = len(REQUESTS)
        self._line = SpiLine(self._block.memory, np.zeros(words, np.int64), np.zeros((words, 8 * WORD_BYTES)))
        self._started = False

    def tick(self, tick: int) -> None:
        """Values of the sensors through SPI, filter and plausibility check to those that are sent."""
        if not self._started:
            self._start_up()
        memory, supplied = self._microcontroller.memory, self._parameters[SUPPLY] > 0.5
        if not _tick(self._line, memory, self._sensed, self._positions, supplied, self._draw_errors()):
            self._transmitter.postpone(self._rows, tick)

    def _start_up(self) -> None:
        """The car's ignition was on before the run: block and check have started when it begins."""
        self._started = True
        self._block.set(self._sensed, self._positions)
        self._block.supply(self._parameters[SUPPLY] > 0.5)
        for _ in range(STARTUP_TRANSFERS // len(REQUESTS) + 100):
            _exchange(self._line, self._microcontroller.memory, self._draw_errors())

    def _draw_errors(self) -> float:
        """Draw the numbers that decide on the bits of a cycle; returns the bit error rate."""
        rate = self._parameters[BIT_ERROR_RATE]
        if rate > 0.0:
            self._random.random(out=self._line.uniform)
        return rate

    def summary(self) -> dict[str, Any]:
        """Counts of the checks."""
        return {"kind": "simulated", **self._microcontroller.counts()}


class ExternalCluster(_Cluster):
    """Case A: a real microcontroller reads the sensor block through an SPI adapter and sends the frames itself."""

    hears_the_bus = True

    def __init__(self, choice: SensorClusterChoice, sensed: FloatArray, transmitter: Transmitter) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="sensor_cluster")
        self._path = Path(self._folder.name) / "registers"
        super().__init__(SensorBlock(self._path), sensed, transmitter)
        self._choice = choice
        self._child: Child | None = None

    def start(self) -> None:
        """Start the process that answers on the serial line.

        Raises
        ------
        RunError
            If it does not come up.
        """
        import time

        arguments = ["--registers", str(self._path), "--device", str(self._choice.device)]
        arguments += ["--baud-rate", str(self._choice.baud_rate)]
        with on_helper_cores(plan_cores()):
            self._child = start_module("SPI slave", "bench.sensor_cluster.slave_process", arguments)
        self.tick(-1)
        deadline = time.monotonic() + START_TIMEOUT_S
        while self._block.memory[SERVED] == 0:
            if self._child.exit_code is not None or time.monotonic() > deadline:
                self.stop()
                raise RunError(
                    f"the SPI slave on {self._choice.device} did not start",
                    mend="check the device and its permission: bench doctor",
                )
            time.sleep(0.01)

    def tick(self, tick: int) -> None:
        """Put the sensors' values where the slave finds them; the microcontroller sends the frames."""
        self._block.set(self._sensed, self._positions)
        self._block.supply(self._parameters[SUPPLY] > 0.5)
        self._transmitter.postpone(self._rows, tick)

    def stop(self) -> None:
        """End the slave."""
        if self._child is not None:
            self._child.stop()
            self._child = None

    def summary(self) -> dict[str, Any]:
        """Counts of the slave."""
        return {"kind": "external", "device": self._choice.device, **self._block.counts()}


SensorCluster = SimulatedCluster | ExternalCluster


def sensor_cluster(
    choice: SensorClusterChoice, sensed: FloatArray, transmitter: Transmitter, seed: int
) -> SensorCluster | None:
    """The cluster that a scenario names, None without one."""
    if choice.kind == "none":
        return None
    if choice.kind == "external":
        return ExternalCluster(choice, sensed, transmitter)
    return SimulatedCluster(choice, sensed, transmitter, seed)
