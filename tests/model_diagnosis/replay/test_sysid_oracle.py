"""Oracle of a plain parameter fit: MuJoCo's own system identification (`mujoco.sysid`) on the same drive.

Mass and rolling resistance are the plain parameters of a straight drive. The oracle knows a mass on a slide with dry
friction that a measured force pushes, and nothing of tyres, suspension or our replay.
"""

import mujoco
import numpy as np
import pytest
from mujoco import sysid
from numpy.typing import NDArray
from plant_log import drive, ideal_sensors

from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

FloatArray = NDArray[np.float64]
HEAVIER, STICKIER = 0.12, 0.6
GRAVITY = 9.81
SLIDE = """
<mujoco>
  <option timestep="0.01" gravity="0 0 0"/>
  <worldbody>
    <body name="car">
      <inertial pos="0 0 0" mass="1500" diaginertia="1 1 1"/>
      <joint name="way" type="slide" axis="1 0 0"/>
      <geom type="sphere" size="1" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator><motor joint="way"/></actuator>
  <sensor><jointvel name="speed" joint="way"/></sensor>
</mujoco>
"""


def pulses(time: float) -> tuple[list[float], float, float]:
    """Coast and drive in turn, straight, without brakes."""
    return [0.0] * 4, 700.0 * max(np.sin(1.4 * (time - 1.0)), 0.0) * (time > 1.0), 0.0


def changed(vehicle: VehicleFile) -> VehicleFile:
    """The car that is driven: heavier, and on tyres that roll worse."""
    copied = vehicle.model_copy(deep=True)
    copied.body.mass *= 1.0 + HEAVIER
    for wheel in WHEELS:
        getattr(copied.wheels, wheel).rolling_resistance *= 1.0 + STICKIER
    return copied


@pytest.fixture(scope="module")
def nominal() -> VehicleFile:
    return ideal_sensors(load_vehicle("asphalt_car"))


@pytest.fixture(scope="module")
def log(nominal: VehicleFile) -> Manoeuvre:
    return drive(changed(nominal), pulses, 12.0, 22.0, name="pulses")


def by_sysid(log: Manoeuvre, vehicle: VehicleFile) -> tuple[float, float]:
    """Mass [kg] and friction of rolling [N] that MuJoCo's system identification finds."""
    speed, torque = log.channels["speed"], log.channels["drive_torque_f"] + log.channels["drive_torque_r"]
    numbers = vehicle.numbers()
    drag = 0.5 * numbers["aerodynamics.air_density"] * numbers["aerodynamics.drag_coefficient"]
    force = torque / vehicle.wheels.rl.radius - drag * numbers["aerodynamics.frontal_area"] * speed**2
    spec = mujoco.MjSpec.from_string(SLIDE)
    model = spec.compile()
    start = sysid.create_initial_state(model, np.zeros(1), speed[:1], np.zeros(0))
    sequence = sysid.ModelSequences(
        "car",
        spec,
        "log",
        start,
        sysid.TimeSeries(log.time, force[:, None]),
        sysid.TimeSeries.from_names(log.time[1:], speed[1:, None], model),
    )
    parameters = sysid.ParameterDict()
    parameters.add(sysid.Parameter("mass", 1500.0, 500.0, 4000.0, modifier=_set_mass))
    parameters.add(sysid.Parameter("friction", 200.0, 1.0, 2000.0, modifier=_set_friction))
    residual = sysid.build_residual_fn(models_sequences=[sequence])
    found, _ = sysid.optimize(initial_params=parameters, residual_fn=residual, optimizer="mujoco", verbose=False)
    # the wheels turn with the car: their inertia acts like mass at the rim
    wheels = sum(getattr(vehicle.wheels, w).inertia / getattr(vehicle.wheels, w).radius ** 2 for w in WHEELS)
    return float(found["mass"].value[0]) - wheels, float(found["friction"].value[0])


def _set_mass(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
    spec.body("car").mass = parameter.value[0]


def _set_friction(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
    spec.joint("way").frictionloss = parameter.value[0]


def by_replay(log: Manoeuvre, vehicle: VehicleFile) -> tuple[float, float]:
    """Mass [kg] and friction of rolling [N] that the fit of the diagnosis finds, every other number held."""
    replay = Replay(vehicle, [log])
    problem = fit_base(replay, Priors.of(replay.parameters)).problem
    free = [replay.columns.index(name) for name in ("mass_change.factor", "rolling_resistance.constant")]
    held = [column for column in range(len(replay.columns)) if column not in free]
    nothing = np.zeros(len(replay.columns))
    fit = problem.fit(problem.linearise(nothing), problem.scale, nothing, fixed=held)
    mass = vehicle.body.mass * (1.0 + fit.theta[free[0]])
    return mass, mass * GRAVITY * vehicle.wheels.fl.rolling_resistance * (1.0 + fit.theta[free[1]])


def test_a_plain_fit_of_mass_and_rolling_resistance_is_that_of_mujoco_s_system_identification(
    log: Manoeuvre, nominal: VehicleFile
) -> None:
    mass, friction = by_replay(log, nominal)
    oracle_mass, oracle_friction = by_sysid(log, nominal)
    # a slide has neither slip nor suspension: 0.1 % is what they make here, three times that the bound
    assert mass == pytest.approx(oracle_mass, rel=3e-3)
    assert friction == pytest.approx(oracle_friction, rel=3e-3)
    assert mass == pytest.approx(changed(nominal).body.mass, rel=3e-3)
