"""States of the replay's car: one array of numbers of the body, one of four columns for the wheels."""

(
    SPEED,
    LATERAL_SPEED,
    YAW_RATE,
    HEAVE,
    HEAVE_RATE,
    PITCH,
    PITCH_RATE,
    ROLL,
    ROLL_RATE,
    DISTANCE,
    STOP_ENERGY,
    ACCELERATION_X,  # specific force along and across, as the accelerometer reports it
    ACCELERATION_Y,
    YAW_ACCELERATION,
    FORCE_X,  # of tyres and air, body axes
    FORCE_Y,
) = range(16)
BODY_STATES = 16

(
    SPIN,
    SPIN_RATE,
    LAGGED_X,
    LAGGED_Y,
    TYRE_X,
    TYRE_Y,
    ALIGNING,
    LOAD,
    TRAVEL,
    ANGLE,  # of the road wheel
    CLAMPING,
    LAGGED_TORQUE,
    BRAKE_TORQUE,
    DISC_TEMPERATURE,
    DISC_ANGLE,
    TYRE_HEAT,  # rise of the tread's temperature
    SLIP_X,
    SLIP_Y,
) = range(18)
WHEEL_STATES = 18
