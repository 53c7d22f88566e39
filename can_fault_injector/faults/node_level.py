"""Disturbances of a node on the bus: its error state, its supply."""

from typing import ClassVar

from pydantic import Field

from can_fault_injector.faults.levels import DisturbanceModel, E2EClass, Group, Level, NodeName


class NodeDisturbance(DisturbanceModel):
    """Base of the disturbances of nodes."""

    group: ClassVar[Group] = "node"
    e2e: ClassVar[E2EClass] = "loss"
    realised_as: ClassVar[Level] = "bit_model"
    continuous: ClassVar[bool] = True

    node: NodeName = Field(default="bench", description="whose controller")


class ErrorPassive(NodeDisturbance):
    """The node's transmit error counter stands at 128 or above while the fault lasts."""

    e2e: ClassVar[E2EClass] = "delay"


class BusOff(NodeDisturbance):
    """The node goes bus-off; it comes back after 128 times 11 recessive bits, or stays away while the fault lasts."""

    recovers: bool = Field(default=False, description="true: it comes back by itself after 128 times 11 recessive bits")


class Reset(NodeDisturbance):
    """The node restarts: counters at zero, what it wanted to send is lost, silent until the duration is over."""


class Off(NodeDisturbance):
    """The node sends nothing while the fault lasts."""

    acknowledges: bool = Field(default=False, description="its controller goes on acknowledging the frames of others")
