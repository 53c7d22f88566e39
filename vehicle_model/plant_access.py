"""Access to the parameters and outputs of a plant by name, which every kind of plant offers in the same way."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from signals.errors import InputError, unknown_name
from signals.quantities import FileModel
from vehicle_model import parameters
from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.parameters import ParameterInfo
from vehicle_model.road import RoadTables
from vehicle_model.vehicle_file import VehicleFile


class PlantAccess:
    """Base of the plants: parameters by dotted path, outputs by name.

    A plant names the sections of the vehicle file that it reads, keeps its own copy of the file, its road and its
    numerics, and brings the memory of its compiled step up to date in ``_write``.
    """

    sections: ClassVar[tuple[str, ...]]
    only_when_built: ClassVar[frozenset[str]] = frozenset()
    """Parameters from which others were estimated when the file was read; a plant in use no longer asks for them."""

    outputs: NDArray[np.float64]
    _vehicle: VehicleFile
    _road: RoadTables
    _options: FileModel

    def _write(self, section: str) -> None:
        """Bring the compiled step's memory up to date after a change in a section, "plant" for the numerics."""
        raise NotImplementedError

    def _write_changed(self, path: str) -> None:
        """The same after a change of one parameter."""
        self._write(path.partition(".")[0])

    def names(self) -> tuple[str, ...]:
        """Dotted paths of every parameter, the road's as ``road.…``, the numerics' as ``plant.…``."""
        return tuple(info.path for info in self.parameter_table())

    def parameter_table(self) -> list[ParameterInfo]:
        """Every parameter with unit, value, range and neutral value."""
        return [info for info in self._infos() if info.path not in self.only_when_built]

    def _infos(self) -> Iterator[ParameterInfo]:
        for section in self.sections:
            yield from parameters.parameter_infos(getattr(self._vehicle, section), f"{section}.", self._vehicle.sources)
        yield from parameters.parameter_infos(self._road.road, "road.")
        yield from parameters.parameter_infos(self._options, "plant.")

    def _owner(self, path: str) -> tuple[BaseModel, str]:
        section = path.partition(".")[0]
        if section == "road":
            return self._road.road, "road."
        if section == "plant":
            return self._options, "plant."
        if section in self.sections:
            return getattr(self._vehicle, section), f"{section}."
        raise unknown_name("section of the plant", section, (*self.sections, "road", "plant"))

    def get(self, path: str) -> float:
        """Value of a parameter in SI units; InputError if there is none of that path."""
        model, prefix = self._owner(path)
        return parameters.get_parameter(model, path, prefix)

    def set(self, path: str, value: float | str) -> None:
        """Change a parameter from the next tick on; InputError if there is none or the value is refused."""
        if path in self.only_when_built:
            raise InputError(
                f"{path}: only used when the car is built",
                mend="change it in the vehicle file, or change what follows from it (inertias, vertical stiffness)",
            )
        if path.startswith("road."):
            self._road.set(path, value)
            return
        model, prefix = self._owner(path)
        before = parameters.get_parameter(model, path, prefix)
        parameters.set_parameter(model, path, value, prefix)
        try:
            self._write_changed(path)
        except InputError:
            parameters.set_parameter(model, path, before, prefix)
            raise

    def state(self) -> dict[str, float]:
        """Outputs of the last tick by name."""
        return dict(zip(PLANT_OUTPUTS, self.outputs.tolist(), strict=True))
