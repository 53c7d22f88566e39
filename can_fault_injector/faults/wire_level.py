"""Faults of the conductors on the ECU's side of the injector, from a model of differential levels."""

from typing import ClassVar, Literal

from pydantic import Field

from can_fault_injector.faults.levels import DisturbanceModel, E2EClass, Group, Level


class WireDisturbance(DisturbanceModel):
    """Base of the wire faults."""

    group: ClassVar[Group] = "wire"
    e2e: ClassVar[E2EClass] = "loss"
    realised_as: ClassVar[Level] = "bit_model"
    continuous: ClassVar[bool] = True


class Open(WireDisturbance):
    """A break of CAN_H, of CAN_L or of both in the line to the ECU (F5 of the friction document)."""

    conductor: Literal["can_h", "can_l", "both"] = Field(default="both", description="broken conductor")

    @property
    def wire_fault(self) -> str:
        """Name of the fault in `wire_faults`."""
        return f"{self.conductor}_open"


class Short(WireDisturbance):
    """A conductor is connected with something it should not be."""

    e2e: ClassVar[E2EClass] = "blocking"
    between: Literal[
        "can_h_to_can_l",
        "can_h_to_ground",
        "can_h_to_battery",
        "can_h_to_supply",
        "can_l_to_ground",
        "can_l_to_battery",
        "can_l_to_supply",
    ] = Field(description="what is connected")

    @property
    def wire_fault(self) -> str:
        """Name of the fault in `wire_faults`."""
        return self.between


class StuckDominant(WireDisturbance):
    """A transceiver, or a line, holds the bus dominant."""

    e2e: ClassVar[E2EClass] = "blocking"
