"""Builds the arrays that the compiled friction filters work with from vehicle file and settings."""

import math
from collections.abc import Mapping

import numpy as np

from estimators import friction_model as model
from estimators import friction_step as step
from estimators.friction_settings import (
    FrictionSettings,
    holds_inputs,
    initial_deviations,
    measurement_deviations,
    minimum_speed,
    process_deviations,
)
from estimators.kalman.covariance import FloatArray
from estimators.post_filter import LOW_PASS, MEDIAN, NO_FILTER, memory_size
from estimators.vehicle_numbers import GRAVITY_M_S2, LongitudinalCar, longitudinal_car, tone_ring

_REFERENCE_STEP_S = 1e-3
_POST_FILTERS = {"none": NO_FILTER, "low_pass": LOW_PASS, "median": MEDIAN}


def model_parameters(car: LongitudinalCar, settings: FrictionSettings) -> FloatArray:
    """Parameters of :mod:`estimators.friction_model`, shape (19,)."""
    curve = settings.tyre_curve
    values = np.zeros(model.MODEL_PARAMETERS)
    values[model.MASS], values[model.WEIGHT] = car.mass, car.weight
    values[model.WHEELBASE], values[model.FRONT_LENGTH] = car.wheelbase, car.front_length
    values[model.HEIGHT], values[model.DRAG_HEIGHT] = car.height, car.drag_height
    values[model.DRAG_FACTOR], values[model.ROLLING_FORCE] = car.drag_factor, car.rolling_force
    values[model.RADIUS_F], values[model.RADIUS_R] = car.radius
    values[model.INERTIA_F], values[model.INERTIA_R] = car.inertia
    values[model.SHAPE_F], values[model.STIFFNESS_F] = curve.shape_front, curve.stiffness_front
    values[model.SHAPE_R], values[model.STIFFNESS_R] = curve.shape_rear, curve.stiffness_rear
    values[model.SLIP_RATE_SIGN] = settings.slip_rate_sign
    values[model.EXACT_LOADS] = settings.exact_load_transfer
    values[model.SPEED_FLOOR] = settings.speed_floor
    return values


def friction_tuning(vehicle: Mapping[str, float], settings: FrictionSettings, sample_time_s: float) -> FloatArray:
    """Model parameters, noise and switches in one array for the compiled step.

    The process noise is given per millisecond; its variance grows with the step.
    """
    known = settings.torque_mode == "known"
    car = longitudinal_car(vehicle, with_brakes=known)
    values = np.zeros(step.TUNING_SIZE)
    values[: model.MODEL_PARAMETERS] = model_parameters(car, settings)
    values[step.SAMPLE_TIME] = sample_time_s
    values[step.TORQUE_KNOWN] = known
    values[step.KINEMATIC_WHEELS] = settings.torque_mode == "z2"
    values[step.BRAKE_IS_CAPACITY] = settings.brake_torque == "capacity"
    values[step.HOLD_INPUTS] = holds_inputs(settings)
    values[step.BRAKE_GAIN_F], values[step.BRAKE_GAIN_R] = car.brake_gain
    values[step.MINIMUM_SPEED] = minimum_speed(settings)
    values[step.HYSTERESIS] = settings.speed_hysteresis
    values[step.SMALLEST_LIMIT] = settings.smallest_friction_limit
    values[step.LARGEST_LIMIT] = settings.largest_friction_limit
    values[step.SPEED_ROW_DELAY] = settings.speed_row_delay
    values[step.BRAKING_START] = settings.braking_start
    values[step.PRIOR_LIMIT] = settings.prior_friction_limit
    values[step.CONFIDENCE_RATIO] = settings.confidence_ratio
    values[step.CONFIDENCE_TIME] = settings.confidence_time
    values[step.POST_FILTER] = _POST_FILTERS[settings.post_filter]
    values[step.POST_FILTER_WEIGHT] = min(1.0, sample_time_s / settings.post_filter_time_constant)
    values[step.LOCKED_RATE_DECAY] = math.exp(-sample_time_s / settings.locked_rate_time_constant)
    values[step.PITCH_FACTOR] = 1.0 / (1.0 + GRAVITY_M_S2 * settings.pitch_gradient)
    ring = tone_ring(vehicle, settings.wheel_speed_teeth, settings.wheel_speed_window)
    values[step.TEETH], values[step.WINDOW] = ring if known else (0.0, 0.0)
    values[step.SUBSTEPS] = 1
    process = np.square(process_deviations(settings)) * (sample_time_s / _REFERENCE_STEP_S)
    values[step.PROCESS_VARIANCE : step.PROCESS_VARIANCE + model.STATES] = process
    rows = np.square(measurement_deviations(settings))
    values[step.MEASUREMENT_VARIANCE : step.INITIAL_VARIANCE] = rows
    values[step.INITIAL_VARIANCE : step.INITIAL_VARIANCE + model.STATES] = np.square(initial_deviations(settings))
    return values


def post_filter_memory(settings: FrictionSettings) -> FloatArray:
    """Memories of the three post-filters (front, rear, mean)."""
    return np.zeros((3, memory_size(settings.post_filter_window)))


def post_filter_delay(settings: FrictionSettings, sample_time_s: float) -> float:
    """Delay of the ``..._filtered`` outputs for slow changes [s]."""
    if settings.post_filter == "low_pass":
        return settings.post_filter_time_constant
    if settings.post_filter == "median":
        return 0.5 * (settings.post_filter_window - 1) * sample_time_s
    return 0.0
