"""Keys and outputs of the attitude filters: the bank, the single filter and the one with an extra state."""

from typing import Literal

from pydantic import Field, model_validator

from estimators.attitude_forms import FORMS, Form
from estimators.description import Output, with_deviation
from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS

FormName = Literal[
    "1A",
    "1B",
    "1C",
    "1D",
    "2A",
    "2B",
    "2C",
    "2A-light",
    "2B-light",
    "2C-light",
    "car",
    "car_x",
    "car_y",
    "car_z",
]
SpeedSource = Literal["usual", "rear", "front", "all", "external"]
Rows = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
_IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_P = "attitude document 3.5, proposed there"
_CAR = "attitude document 6"
SMALLEST_DETERMINANT = 0.05
"""Of a sensor matrix: its axes would lie in a plane at 0."""


def _form_value(unit: str, description: str) -> float | None:
    declared: float | None = parameter(
        unit, None, low=1e-9, description=f"{description}; left out: the form's", source=_P
    )
    return declared


class AttitudeSettings(FileModel):
    """Settings that all attitude filters share."""

    form: FormName = Field(
        default="car_y",
        description="1A to 1D: two-wheeler without pitch gyroscope; 2A to 2C: with it, wheel loads and road slope; "
        "-light: without the wheel loads; car: the document's car, lateral offset virtual; car_x, car_y, car_z: with "
        "pitch and all offsets, that accelerometer's virtual",
    )
    speed_source: SpeedSource = Field(
        default="usual",
        description="rear, front: wheels of that axle; all: mean of the wheels; external: speed that the bus reports, "
        "no state then; usual: rear for a two-wheeler, all for a car",
    )
    characteristic_equation: bool = Field(default=True, description="use the balance of the roll moment, Q_x = 0")
    roll_balance: bool = Field(default=True, description="car: use the balance of the roll moment, a flat road")
    characteristic_value: float = parameter("N m", 0.0, description="constant value of Q_x", source="l. 1769")
    aerodynamic_force: bool = Field(default=False, description="drag in the forces of the road (gamma)")
    gyro_matrix: Rows = Field(default=_IDENTITY, description="from what the gyroscopes measure to rates about x, y, z")
    accelerometer_matrix: Rows = Field(default=_IDENTITY, description="the same for the accelerometers")
    low_pass: float = parameter(
        "Hz", 8.0, low=0.1, high=200.0, description="second-order low-pass of each sensor", source=_P
    )
    low_pass_speed: float = parameter("Hz", 0.0, low=0.0, high=200.0, description="of the speed, 0 for none", source=_P)
    elevation_low_pass: float = parameter(
        "Hz", 3.0, low=0.1, high=50.0, description="of the elevation angle", source="5"
    )
    period: float = parameter(
        "s", 0.01, low=0.0005, high=0.1, description="time between two steps of the filters", source=_P
    )
    cycle: Literal["middle", "document"] = Field(
        default="middle",
        description="middle: a prediction takes its inputs half way between two steps, where the differences of the "
        "rates over a step belong; document: its cycle as written (3.6, FIG. 3): those of the last step, the rates "
        "differentiated from sample to sample behind their low-passes",
    )
    measurement_lateral_acceleration: float | None = _form_value("m/s^2", "noise of G_y")
    measurement_vertical_acceleration: float | None = _form_value("m/s^2", "noise of G_z")
    measurement_speed: float | None = _form_value("m/s", "noise of the speed")
    measurement_roll_balance: float | None = _form_value("m/s^2", "error of the roll balance, scaled")
    measurement_yaw_balance: float | None = _form_value("m/s^2", "error of the yaw balance of the car, scaled")
    measurement_pitch_balance: float | None = _form_value("m/s^2", "error of the pitch balance of the car, scaled")
    process_angle: float | None = _form_value("rad", "noise of roll and pitch per root second")
    process_speed: float | None = _form_value("m/s", "noise of the speed per root second")
    process_lateral_speed: float = parameter(
        "m/s", 0.02, low=0.0, description="of the car per root second", source=_CAR
    )
    process_gyro_offset: float | None = _form_value("rad/s", "noise of gyroscope offsets per root second")
    process_acceleration_offset: float | None = _form_value("m/s^2", "noise of accelerometer offsets per root second")
    initial_angle: float = parameter("rad", 0.05, low=1e-6, description="deviation at the start", source=_P)
    initial_speed: float = parameter("m/s", 0.5, low=1e-6, description="deviation at the start", source=_P)
    initial_gyro_offset: float = parameter("rad/s", 0.02, low=1e-6, description="deviation at the start", source=_P)
    initial_acceleration_offset: float = parameter(
        "m/s^2", 0.5, low=1e-6, description="deviation at the start", source=_P
    )
    minimum_speed: float = parameter(
        "m/s", 3.0, low=0.1, high=30.0, description="below it the filters rest and keep their offsets", source="5"
    )
    largest_roll: float = parameter("rad", 1.309, low=0.1, high=1.5, description="limit of the roll angle", source="5")
    roll_gradient: float | None = parameter(
        "rad/(m/s^2)", None, low=0.0, high=0.1, description="car: roll per lateral acceleration; left out: its springs"
    )
    pitch_gradient: float | None = parameter(
        "rad/(m/s^2)", None, low=0.0, high=0.1, description="car: nose up per acceleration; left out: its springs"
    )
    cornering_stiffness_front: float | None = parameter(
        "N/rad", None, low=100.0, high=1e6, description="car: of the axle; left out: slope of its tyres"
    )
    cornering_stiffness_rear: float | None = parameter("N/rad", None, low=100.0, high=1e6, description="likewise")
    friction: float = parameter(
        "1", 0.9, low=0.05, high=2.0, description="car: friction of its tyre model", source=_CAR
    )
    abs_signal: Literal["bus", "none"] = Field(
        default="bus", description="bus: weights are held while the ECU reports ABS control; none: nobody tells"
    )
    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )

    @model_validator(mode="after")
    def _axes(self) -> "AttitudeSettings":
        for name in ("gyro_matrix", "accelerometer_matrix"):
            value = abs(_determinant(getattr(self, name)))
            if not value >= SMALLEST_DETERMINANT:
                raise FieldError(
                    f"{name}: axes that do not span the three directions",
                    at=(name,),
                    found=f"a determinant of {value:.3g}",
                    allowed=f"at least {SMALLEST_DETERMINANT:g}",
                )
        return self

    @property
    def chosen(self) -> Form:
        """The form by its name."""
        return FORMS[self.form]


class AttitudeBankSettings(AttitudeSettings):
    """Settings of the bank: its virtual offsets, likelihood and weights."""

    sensor_range: float = parameter(
        "m/s^2",
        0.980665,
        low=1e-3,
        high=50.0,
        description="largest offset of the virtual one's sensor; the outer virtual offsets lie at 1.5 times it",
        source="l. 1225: 100 mG",
    )
    virtual_offsets: list[float] = Field(
        default_factory=list,
        max_length=64,
        description="virtual offset of each filter; left out: above, within and below the sensor's range",
        json_schema_extra={"unit": "m/s^2"},
    )
    likelihood: Literal["gaussian", "student"] = Field(
        default="gaussian", description="gaussian: (27); student: with heavy tails, which outliers move less"
    )
    degrees_of_freedom: float = parameter("1", 4.0, low=1.0, high=100.0, description="of the student likelihood")
    likelihood_time_constant: float = parameter(
        "s", 5.0, low=0.0, high=120.0, description="low-pass 58 of the likelihood, 0 switches it off", source="5"
    )
    weighting: Literal["averaged", "accumulated"] = Field(
        default="averaged",
        description="averaged: by the mean likelihood (28); accumulated: by the mean of its logarithm (3.7)",
    )
    effective_samples: float = parameter(
        "1", 5.0, low=0.1, high=1000.0, description="N_eff of the accumulated weighting", source="3.7"
    )
    output: Literal["weighted", "best"] = Field(
        default="weighted", description="weighted: (28), (29); best: the most likely filter alone"
    )
    recentring: bool = Field(default=False, description="virtual offsets follow the estimate (3.7)")
    recentring_time_constant: float = parameter("s", 8.0, low=0.5, high=600.0, description="of that loop", source="3.7")
    recentring_start: float = parameter(
        "s", 12.0, low=0.0, high=600.0, description="rest before that loop", source="3.7"
    )
    largest_friction_share: float = parameter(
        "1", 0.8, low=0.05, high=2.0, description="car: share of the friction above which weights are held", source=_CAR
    )
    suspicious_weight: float = parameter(
        "1",
        0.2,
        low=0.0,
        high=1.0,
        description="weight of the zero offset below which a sensor is suspicious",
        source=_CAR,
    )
    suspicious_time: float = parameter("s", 5.0, low=0.0, high=600.0, description="for so long", source=_CAR)

    @model_validator(mode="after")
    def _spread(self) -> "AttitudeBankSettings":
        given = self.virtual_offsets
        if given and (len(given) < 2 or min(given) == max(given)):
            raise FieldError(
                "virtual_offsets: a bank whose filters are all told the same",
                at=("virtual_offsets",),
                found=str(given),
                allowed="2 or more numbers of which two differ",
            )
        return self

    @property
    def offsets(self) -> tuple[float, ...]:
        """Virtual offset of each filter [m/s^2]; by default as in claim 4."""
        outer = 1.5 * self.sensor_range
        return tuple(sorted(self.virtual_offsets)) or (-outer, 0.0, outer)


class AttitudeSingleSettings(AttitudeSettings):
    """Settings of one filter alone, the first reference of the bank."""

    form: FormName | Literal["comparison"] = Field(  # type: ignore[assignment]
        default="car_y", description="as of the bank; comparison: the comparison device of the document's example 4"
    )
    virtual_offset: float = parameter("m/s^2", 0.0, description="constant that it is told")


class AttitudeAugmentedSettings(AttitudeSettings):
    """Settings of one filter with the virtual offset as one more state, the fair reference of the bank."""

    augment: Literal["virtual", "all"] = Field(
        default="virtual",
        description="virtual: the form's virtual offset; all: the three accelerometers' offsets; 2A then takes the "
        "noise of 2B, which has its states",
    )


def _determinant(m: Rows) -> float:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


_AXLES = {"rear": WHEELS[2:], "front": WHEELS[:2], "all": WHEELS}
SENSORS = (
    "roll_rate",
    "pitch_rate",
    "yaw_rate",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "vertical_acceleration",
)


def speed_wheels(settings: AttitudeSettings) -> tuple[str, ...]:
    """Wheels whose mean gives the speed; none where it comes from outside."""
    source = settings.speed_source
    if source == "usual":
        source = "all" if settings.chosen.car else "rear"
    return _AXLES.get(source, ())


def guarded_inputs(settings: AttitudeSettings) -> tuple[str, ...]:
    """Inputs without which the filters rest; without a matrix the first embodiment reads no pitch gyroscope."""
    form = settings.chosen
    needs_pitch = form.pitches or settings.gyro_matrix != _IDENTITY
    sensors = tuple(name for name in SENSORS if needs_pitch or name != "pitch_rate")
    steering = ("road_wheel_angle",) if form.car else ()
    wheels = tuple(f"wheel_speed_{wheel}" for wheel in speed_wheels(settings)) or ("ecu_reference_speed",)
    return (*sensors, *steering, *wheels)


def attitude_inputs(settings: AttitudeSettings) -> tuple[str, ...]:
    """The same with the report of the ABS, which may stay away."""
    first, *others = guarded_inputs(settings)
    return (first, "abs_active", *others) if settings.abs_signal == "bus" else (first, *others)


_STATUS = (
    Output("active", "1", "1 while the filters run, 0 while inputs are lost and at walking pace"),
    Output("resets", "1", "returns to the initial state so far"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
)
ATTITUDE_OUTPUTS: tuple[Output, ...] = (
    *_STATUS,
    *with_deviation("pitch_angle", "rad", "pitch angle of the body, positive nose down", ("pitch_angle",)),
    *with_deviation("roll_angle", "rad", "roll angle of the body, positive to the right", ("roll_angle",)),
    *with_deviation("speed", "m/s", "speed along x", ("speed",)),
    *with_deviation("lateral_speed", "m/s", "lateral speed of the centre of gravity, car", ("lateral_speed",)),
    *with_deviation("roll_rate_offset", "rad/s", "offset of the roll gyroscope"),
    *with_deviation("yaw_rate_offset", "rad/s", "offset of the yaw gyroscope"),
    *with_deviation("pitch_rate_offset", "rad/s", "offset of the pitch gyroscope"),
    *with_deviation("longitudinal_acceleration_offset", "m/s^2", "offset of the accelerometer x"),
    *with_deviation("lateral_acceleration_offset", "m/s^2", "offset of the accelerometer y"),
    *with_deviation("vertical_acceleration_offset", "m/s^2", "offset of the accelerometer z"),
    *with_deviation("side_slip_angle", "rad", "side-slip angle of the centre of gravity, car", ("side_slip_angle",)),
    Output("roll_angle_age", "s", "age of the roll angle: delay of the low-pass, of the frame and since the last step"),
    Output("virtual_offset", "m/s^2", "estimate of the virtual offset (28), or of the extra state"),
    Output("zero_weight", "1", "weight of the filter whose virtual offset is nearest to zero"),
    Output("largest_weight", "1", "weight of the most likely filter"),
    Output("separation", "1", "k of neighbouring filters, 1.5 to 2.3 wanted; 0 with less than three filters"),
    Output("weights_held", "1", "1 while ABS control or too much of the friction holds the weights"),
    Output("sensor_suspicious", "1", "1 while the zero offset has been unlikely for long"),
    Output("vertical_load_front", "N", "load of the front wheel, forms 2A to 2C"),
    Output("vertical_load_rear", "N", "load of the rear wheel, forms 2A to 2C"),
    Output("elevation_angle", "rad", "angle of the body to the road by its springs, positive nose down, 2A to 2C"),
    Output("road_slope", "rad", "slope of the road, positive downhill, forms 2A to 2C-light"),
    Output("innovation", "1", "normalised innovation squared of the last step, weighted mean of the filters"),
)
