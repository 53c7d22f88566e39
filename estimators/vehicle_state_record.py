"""Memory of the compiled vehicle-state observers; wheels and axes are the document's."""

import numpy as np

LATERAL_STATES = 10
"""v_y, w_z, four slopes k_y, four limits mu_m (3.3, order of the listing)."""
MEASUREMENTS = 9
POINTS = 2 * LATERAL_STATES + 1
V_Y, W_Z, SLOPE, LIMIT = 0, 1, 2, 6

CURVES = 8
"""Friction curves: four wheels lateral, then four wheels longitudinal."""
BUFFER = 128
LOG_ROWS = 256
LOG_COLUMNS = (
    "time", "curve", "sign", "points", "objective", "r_squared", "attained", "limit", "stiffness", "share", "early",
)  # fmt: skip

LINEAR, CURVED = 0, 1

STATE_RECORD = np.dtype(
    [
        ("time", "f8"),
        ("ticks", "i8"),
        ("started", "i8"),
        ("resets", "i8"),
        ("verdict", "i8"),
        ("moving", "i8"),
        ("braking", "i8"),
        # motion of the car
        ("v_x", "f8"),
        ("v_y", "f8"),
        ("w_z", "f8"),
        ("a_x", "f8"),  # of the model
        ("a_y", "f8"),
        ("dv_x", "f8"),
        ("odometer", "f8"),
        ("steering", "f8"),
        ("steering_rate", "f8"),
        ("steering_age", "f8"),
        ("theta", "f8", (4,)),
        ("alpha", "f8", (4,)),
        ("load", "f8", (4,)),
        ("force_x", "f8", (4,)),
        ("force_y", "f8", (4,)),
        ("roll", "f8"),
        ("roll_rate", "f8"),
        ("pitch", "f8"),
        ("pitch_rate", "f8"),
        # lateral filter
        ("lateral_runs", "i8"),
        ("innovation", "f8"),
        ("yaw_before", "f8"),
        ("yaw_acceleration", "f8"),
        ("measured_y", "f8"),
        ("sum_y", "f8"),
        ("sum_yaw", "f8"),
        ("gyro_offset", "f8"),
        ("standing_time", "f8"),
        ("filtered_alpha", "f8", (4,)),
        ("wheel_friction", "f8", (4,)),
        ("rejected_y", "i8"),
        ("stuck_value", "f8"),
        ("stuck_time", "f8"),
        # longitudinal observer
        ("longitudinal_runs", "i8"),
        ("omega", "f8", (4,)),
        ("measured", "f8", (4,)),
        ("measured_rate", "f8", (4,)),
        ("measured_age", "f8", (4,)),
        ("error", "f8", (4,)),
        ("error_rate", "f8", (4,)),
        ("slope_rate", "f8", (4,)),
        ("slope", "f8", (4,)),
        ("slip", "f8", (4,)),
        ("torque", "f8", (4,)),
        ("engine_speed", "f8"),
        ("engine_acceleration", "f8"),
        ("engine_age", "f8"),
        ("sum_slip", "f8", (4,)),
        ("sum_used", "f8", (4,)),
        ("running_time", "f8"),
        ("pair_slip", "f8", (4,)),
        ("pair_used", "f8", (4,)),
        ("pair_trend", "f8", (4,)),
        # grade
        ("theta_r", "f8"),
        ("theta_with_pitch", "f8"),
        ("grade_sum", "f8"),
        ("grade_squares", "f8"),
        ("grade_count", "i8"),
        ("grade_variance", "f8"),
        ("grade_known", "i8"),
    ]
)

CURVE_RECORD = np.dtype(
    [
        ("mode", "i8"),
        ("b", "f8"),
        ("d", "f8"),
        ("threshold", "f8"),
        ("start", "f8"),
        ("known_b", "f8"),
        ("now", "f8"),
        ("reach", "f8"),
        ("asked", "f8"),
        ("early", "i8"),
        ("next_try", "f8"),
        ("count", "i8"),
        ("sign", "f8"),
        ("fits", "i8"),
        ("provisional", "i8"),
        ("pending", "i8"),
        ("handed_over", "i8"),
        ("attained", "f8"),
        ("objective", "f8"),
        ("r_squared", "f8"),
        ("share", "f8"),
        ("points", "i8"),
        ("stride", "i8"),
        ("skipped", "i8"),
    ]
)

TUNING_RECORD = np.dtype(
    [
        ("dt", "f8"),
        # lateral filter
        ("lateral", "i8"),
        ("lateral_ticks", "i8"),
        ("redraw", "i8"),
        ("listing_noise", "i8"),
        ("double_projection", "i8"),
        ("centripetal", "i8"),
        ("filtered_yaw", "i8"),
        ("yaw_delay", "f8"),
        ("roll_compensation", "i8"),
        ("sway", "f8"),  # height of the centre of gravity above the axis about which the body rolls
        ("hand_over", "i8"),
        ("spread", "f8"),
        ("curve_c", "f8"),
        ("gate_y", "f8"),
        ("smallest_alpha", "f8"),
        ("signal_weight", "f8"),
        ("process_v_y", "f8"),
        ("process_w_z", "f8"),
        ("process_slope", "f8"),
        ("process_limit", "f8"),
        ("noise_w_z", "f8"),
        ("noise_slope", "f8"),
        ("noise_friction", "f8"),
        ("initial_slope", "f8"),
        ("initial_limit", "f8"),
        ("initial_b", "f8"),
        ("initial_v_y_variance", "f8"),
        ("initial_w_z_variance", "f8"),
        ("initial_slope_variance", "f8"),
        ("initial_limit_variance", "f8"),
        ("hand_over_variance", "f8"),
        ("gyro_weight", "f8"),
        ("stuck_after", "f8"),
        ("stuck_difference", "f8"),
        # longitudinal observer
        ("longitudinal", "i8"),
        ("teeth", "f8"),
        ("window", "f8"),
        ("gate_x", "f8"),
        ("surface_error", "f8"),
        ("surface_rate", "f8"),
        ("gain", "f8"),
        ("largest_slope", "f8"),
        ("slew_time", "f8"),
        ("integrators", "i8"),
        ("reversal", "i8"),
        ("smallest_slip", "f8"),
        ("layer", "f8"),
        ("initial_slope_x", "f8"),
        ("anchor", "f8"),
        ("towing_slip", "i8"),
        ("anchor_rows", "f8", (4,)),
        ("engine_torque_path", "i8"),
        ("engine_weight", "f8"),
        ("brakes", "i8"),
        ("pair_weight", "f8"),
        ("trend_weight", "f8"),
        ("measured_slip", "i8"),
        ("settling_time", "f8"),
        # fit, lateral and longitudinal
        ("fit", "i8", (2,)),
        ("automatic", "i8", (2,)),
        ("start_threshold", "f8", (2,)),
        ("low_threshold", "f8", (2,)),
        ("high_threshold", "f8", (2,)),
        ("threshold_times_b", "f8", (2,)),
        ("start_doubt", "f8"),
        ("agreement", "f8"),
        ("doubt", "f8", (2,)),
        ("doubtful_times_b", "f8", (2,)),
        ("latest_times_b", "f8", (2,)),
        ("hysteresis", "f8"),
        ("fewest_points", "i8"),
        ("lowest_r_squared", "f8"),
        ("largest_straightness", "f8"),
        ("low_d", "f8"),
        ("high_d", "f8"),
        ("low_b", "f8", (2,)),
        ("high_b", "f8", (2,)),
        ("outside_solver", "i8"),
        # grade
        ("grade", "i8"),
        ("block_ticks", "i8"),
        ("pitch_compensation", "i8"),
        ("grade_model", "i8"),
        ("largest_grade", "f8"),
        ("standstill_time", "f8"),
    ]
)
VIRTUAL, INERTIAL = 0, 1
