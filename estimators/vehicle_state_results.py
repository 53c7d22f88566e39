"""Writes the quantities of the vehicle-state observers in bench axes and wheel order, compiled."""

import math
from typing import Any

from numba import njit

from estimators.kalman.covariance import FloatArray
from estimators.vehicle_state_axes import BENCH_INDEX, bench_slip, mirrored
from estimators.vehicle_state_outputs import first_of
from estimators.vehicle_state_record import CURVED, LIMIT, SLOPE, V_Y, W_Z

_ACTIVE, _INPUTS, _RESETS, _TRACTION = range(4)
_SPEED, _A_X = first_of("speed"), first_of("longitudinal_acceleration")
_V_Y, _YAW_RATE, _A_Y = first_of("lateral_speed"), first_of("yaw_rate"), first_of("lateral_acceleration")
_ROLL, _INNOVATION = first_of("roll_angle"), first_of("innovation")
_REJECTED, _GRADE = first_of("lateral_acceleration_rejected"), first_of("road_grade")
_WITH_PITCH, _PITCH = first_of("road_grade_with_pitch"), first_of("pitch_angle")
_LOAD, _ALPHA, _ALPHA_GOOD = first_of("vertical_load"), first_of("slip_angle"), first_of("slip_angle_confidence")
_K_Y, _K_Y_STD = first_of("slope_lateral"), first_of("slope_lateral_std")
_USED_Y, _LIMIT_Y = first_of("friction_used_lateral"), first_of("friction_limit_lateral")
_LIMIT_Y_STD, _LIMIT_Y_GOOD = first_of("friction_limit_lateral_std"), first_of("friction_limit_lateral_confidence")
_B_Y = first_of("stiffness_lateral")
_OMEGA, _SLIP, _SLIP_GOOD = first_of("wheel_speed"), first_of("slip"), first_of("slip_confidence")
_K_X, _K_X_GOOD = first_of("slope_longitudinal"), first_of("slope_longitudinal_confidence")
_USED_X, _USED_X_GOOD = first_of("friction_used"), first_of("friction_used_confidence")
_LIMIT_X, _LIMIT_X_GOOD = first_of("friction_limit"), first_of("friction_limit_confidence")
_B_X = first_of("stiffness_longitudinal")


@njit(cache=True)
def _write_fit(curve: Any, out: FloatArray, at: int) -> None:
    """B, R^2, share, fits and law: five quantities in a row."""
    out[at] = curve.b if curve.fits > 0 else 0.0
    out[at + 4], out[at + 8] = curve.r_squared, curve.share
    out[at + 12], out[at + 16] = curve.fits, 1.0 if curve.mode == CURVED else 0.0


@njit(cache=True)
def _write_lateral_wheel(s: Any, curve: Any, m: Any, i: int, out: FloatArray, wheel: int) -> None:
    out[_LOAD + wheel] = s.load[i]
    out[_ALPHA + wheel], out[_ALPHA_GOOD + wheel] = s.alpha[i], s.lateral_runs
    out[_K_Y + wheel] = m.x[SLOPE + i]
    out[_K_Y_STD + wheel] = math.sqrt(max(m.covariance[SLOPE + i, SLOPE + i], 0.0))
    out[_USED_Y + wheel] = mirrored(s.force_y[i] / s.load[i]) if s.load[i] > 0.0 else 0.0
    out[_LIMIT_Y + wheel] = m.x[LIMIT + i]
    out[_LIMIT_Y_STD + wheel] = math.sqrt(max(m.covariance[LIMIT + i, LIMIT + i], 0.0))
    out[_LIMIT_Y_GOOD + wheel] = 1.0 if curve.fits > 0 and s.braking == 0 else 0.0
    _write_fit(curve, out, _B_Y + wheel)


@njit(cache=True)
def _write_longitudinal_wheel(s: Any, curve: Any, t: Any, i: int, out: FloatArray, wheel: int) -> None:
    good = 1.0 if s.longitudinal_runs == 1 and (s.braking == 0 or t.brakes == 1) else 0.0
    out[_OMEGA + wheel] = s.omega[i] if t.longitudinal == 1 else s.measured[i]
    out[_SLIP + wheel], out[_SLIP_GOOD + wheel] = bench_slip(s.slip[i]), good
    out[_K_X + wheel] = s.slope[i]
    out[_K_X_GOOD + wheel] = good if abs(s.slip[i]) > t.smallest_slip else 0.0
    out[_USED_X + wheel], out[_USED_X_GOOD + wheel] = s.slope[i] * s.slip[i], good
    out[_LIMIT_X + wheel] = curve.d
    out[_LIMIT_X_GOOD + wheel] = 1.0 if curve.fits > 0 and s.braking == 0 else 0.0
    _write_fit(curve, out, _B_X + wheel)


@njit(cache=True)
def write_results(s_rows: Any, curves: Any, m: Any, t_rows: Any, active: bool, out: FloatArray) -> None:
    """Fill ``out`` (layout of ``ALL_OUTPUTS``); zeros while nothing runs."""
    s, t = s_rows[0], t_rows[0]
    out[:] = 0.0
    out[_ACTIVE], out[_INPUTS], out[_RESETS] = 1.0 if active else 0.0, s.verdict, s.resets
    if not active:
        return
    known = 0.0 if s.braking == 1 and t.brakes == 0 else 1.0
    out[_TRACTION] = 1.0 - known
    out[_SPEED], out[_SPEED + 1] = s.v_x, known
    out[_A_X], out[_A_X + 1] = s.a_x, known if s.longitudinal_runs == 1 else 0.0
    out[_V_Y], out[_V_Y + 1] = mirrored(s.v_y), math.sqrt(max(m.covariance[V_Y, V_Y], 0.0))
    out[_YAW_RATE], out[_YAW_RATE + 1] = mirrored(s.w_z), math.sqrt(max(m.covariance[W_Z, W_Z], 0.0))
    out[_A_Y], out[_A_Y + 1] = mirrored(s.a_y), s.lateral_runs
    out[_ROLL], out[_INNOVATION], out[_REJECTED] = mirrored(s.roll), s.innovation, s.rejected_y
    out[_GRADE], out[_GRADE + 1] = math.tan(s.theta_r), math.sqrt(s.grade_variance)
    out[_GRADE + 2] = known if s.grade_known == 1 else 0.0
    out[_WITH_PITCH] = math.tan(s.theta_with_pitch)
    # the catalogue's pitch is positive nose down
    out[_PITCH] = -s.pitch
    for i in range(4):
        _write_lateral_wheel(s, curves[i], m, i, out, BENCH_INDEX[i])
        _write_longitudinal_wheel(s, curves[4 + i], t, i, out, BENCH_INDEX[i])
