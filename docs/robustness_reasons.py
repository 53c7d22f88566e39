"""What the robustness pages say beside their tables: how the runs were made, and why the figures move."""

_OTHERS = "Other groups: "
_LINKS = {
    "friction": "[friction](estimators_robustness.md)",
    "state": "[vehicle state](estimators_robustness_state.md)",
    "load": "[vertical loads](estimators_robustness_load.md)",
    "force": "[axle forces](estimators_robustness_force.md)",
    "attitude": "[attitude](estimators_robustness_attitude.md)",
}


def _head(group: str, title: str, text: str) -> str:
    others = ", ".join(link for name, link in _LINKS.items() if name != group)
    return (
        f"# Robustness of the {title}\n\nMade by `python docs/generate_robustness.py {group}`. {text}\n"
        "The estimators keep their shipped settings and the nominal car; nothing is tuned to a case.\n"
        f"What the settings mean: [estimators.md](estimators.md). {_OTHERS}{others}.\n"
    )


HEADS = {
    "friction": _head(
        "friction",
        "friction estimators",
        "Every run is the stop of `friction/e10_abs_grip_jump` (95 km/h, ABS, car\n"
        "of Table 8 on the document's single-track plant) without its jump, with one thing other than the estimators\n"
        "assume. Figures are taken over the braking phase.",
    ),
    "state": _head(
        "state",
        "vehicle-state observers",
        "Every run is `state/slalom_dry_asphalt` (60 km/h, six sines of 100 degrees\n"
        "at the steering wheel, the document's planar car), with one thing other than the observers assume.",
    ),
    "load": _head(
        "load",
        "observers of the vertical loads",
        "Every run is `state/vertical_load_lane_change` (70 km/h, the document's\n"
        "own car), with one thing other than the observers assume. At rest the loads are 5.5 kN in front, 3.7 kN\n"
        "behind.",
    ),
    "force": _head(
        "force",
        "observers of the axle forces",
        "Every run is `state/neural_force_slalom` (the document's 700 kg car under\n"
        "a steady steering sine), with one thing other than the observers assume. The sum of the forces is compared:\n"
        "how it is shared between the axles cannot be observed while the wheels stand straight\n"
        "([models/neural_force.md](models/neural_force.md)).",
    ),
    "attitude": _head(
        "attitude",
        "attitude filters",
        "Every run is `state/attitude_slalom` (the MuJoCo car on a flat road), with\n"
        "one thing other than the filters assume. The bank stands beside its references: one filter\n"
        "alone, and one filter with the offset as one more state.",
    ),
}

_FRICTION = {
    "mass": (
        "With torques the wheel equations tell the true tyre force, which a heavier car needs more of, while "
        "the accelerometer times the believed mass tells less. The filter resolves the contradiction by a "
        "lower speed, hence less slip, and a higher limit. Without torques force and load scale alike and the "
        "ratio stays."
    ),
    "wheel_radius": (
        "Smaller wheels turn faster: while rolling the speed is too high by as much, and the error lasts "
        "through the stop. Speed and rim speed are wrong alike, so that slip and friction stay nearly right."
    ),
    "grade": (
        "An accelerometer on a slope feels g sin(grade), 0.49 m/s² at 5 %; the filter integrates it. Downhill "
        "its speed falls below that of the wheels, the slip that is left cannot make the force, and the limit "
        "rises to its guard (`largest_friction_limit`). The document assumes a level road (3.6.1); "
        "`road_grade` estimates the slope."
    ),
    "accelerometer_offset": (
        "Integrated by row 8 and read as force by row 1, as on a slope. Without torques nothing but the "
        "accelerometer tells the force, so that the error is twice as large."
    ),
    "sensor_noise": (
        "All noises times 2 and 5: accelerometer 0.25 m/s², pressures 0.5 bar, teeth of the rings misplaced "
        "by 1.5 %. The simple model passes the accelerometer's noise on, the filters average it."
    ),
    "latency": (
        "Everything late alike: speed and friction belong to the past, 0.2 m/s at 20 ms and 10 m/s². The "
        "limit does not move."
    ),
    "lost_frames": "Values are held and rows without a new sample are left out; single losses cost next to nothing.",
    "adaptive_damper": (
        "On the MuJoCo car the body pitches into the accelerometer and the loads swing: that is the step from "
        "the first to the second level ([reasons](acceptance.md#reasons)). Adaptive dampers take a little of "
        "the swing away."
    ),
    "unknown_torque": (
        "Rows 1 to 3 with `torque_mode: z2`: only the load-weighted mean is observable then (3.6.9), and it is as good."
    ),
    "other_car": "Mass, wheelbase, wheels and brakes of the other car are known to the estimators from its file.",
    "grip_jump": "The phase contains the time after the jump in which the estimate follows.",
    "rubber": (
        "k1 and k2 are believed (14.34 in the filter, front 20 and rear 10 in the column of two kinds). A "
        "softer curve needs more slip for the same force: the filter takes the road for a worse one, and a "
        "harder curve for a better."
    ),
    "abs_calibration": "A coarser control swings further; the simple regression follows the swings less well.",
}

_LINE = {
    "latency": "Everything late alike: the estimates belong to the past, and nobody can tell.",
    "lost_frames": "Values are held and rows without a new sample are left out; single losses cost next to nothing.",
}

_STATE = {
    "mass": (
        "Loads and slopes are believed from the file's mass. At +10 % most errors stay or fall, since the nominal ones "
        "have the other sign; at +20 % the cascade's lateral acceleration is twice as far off."
    ),
    "lateral_accelerometer_offset": (
        "The virtual accelerometer of the front axle is the filter's main measurement. An offset is a lateral force "
        "that never turns the car; the filter puts it into slip angle and curve slope."
    ),
    "yaw_gyroscope_offset": (
        "It is believed: 2 deg/s come out as the 0.035 rad/s that went in, and as the lateral acceleration that speed "
        "times yaw rate would be."
    ),
    "sensor_noise": "All noises times 2 and 5: the filters average them.",
    **_LINE,
}

_LOAD = {
    "mass": (
        "The static loads come from the file: 10 % of mass are 548 N in front. None of these observers estimates the "
        "mass."
    ),
    "centre_of_gravity_height": "In a lane change it only matters through the roll arm, and by little.",
    "roll_gyroscope_offset": (
        "The price of the third sensor: the roll angle is the integral of what model and gyroscope agree on, so that "
        "0.2 deg/s move the front load by 110 N. The filter of two sensors, which has no roll gyroscope, does not see "
        "it. With noise set a the gyroscope is trusted less (41 N per 0.005 rad/s, "
        "[models/vertical_load.md](models/vertical_load.md))."
    ),
    "lateral_accelerometer_offset": "A steady lateral acceleration tilts the body and moves load.",
    "sensor_noise": "All noises times 2 and 5; the roll damping turns noise of the roll rate into load.",
    "rough_road": (
        "On the MuJoCo car the suspension has four springs in place of one roll spring, and the tyres deflect. On the "
        "rough road (ISO 8608, left and right profiles unlike) the wheels' own motion changes the loads by some 400 N, "
        "which no sensor of these observers hears."
    ),
    **_LINE,
}

_FORCE = {
    "mass": "The sum of forces is mass times what the speed tells: what the file lacks is missing in it.",
    "yaw_gyroscope_offset": "The yaw rate is a measured state; its offset becomes lateral speed.",
    "sensor_noise": "All noises times 2 and 5. The observer's gain passes noise of the yaw rate to the lateral speed.",
    **_LINE,
}

_ATTITUDE = {
    "mass": (
        "A heavier car leans more. That the errors fall says that the filters, with the file's stiffness, believe a "
        "little more lean than the plant shows at its nominal mass."
    ),
    "bank": "The forms of a flat road have no bank: its angle counts as lean of the body.",
    "lateral_accelerometer_offset": (
        "What the bank is made for: with an offset of 0.3 m/s² (31 mG) its roll angle stays, that of one filter alone "
        "does not. One filter with the offset as a state does as well here, where nothing else is wrong."
    ),
    "roll_gyroscope_offset": "Offsets of the gyroscopes are states of every filter and are found.",
    "yaw_gyroscope_offset": "As the roll gyroscope's.",
    **_LINE,
}

REASONS = {"friction": _FRICTION, "state": _STATE, "load": _LOAD, "force": _FORCE, "attitude": _ATTITUDE}
