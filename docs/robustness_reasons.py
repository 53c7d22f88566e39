"""What the robustness pages say beside their tables: how the runs were made, and why the figures move."""

_OTHERS = "Other groups: "
_LINKS = {
    "friction": "[friction](estimators_robustness.md)",
    "cornering": "[cornering stiffness](estimators_robustness_cornering.md)",
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
        "assume. Figures are taken over the braking phase. Forces are in N: 10 % of m g/2, the target of a stop with\n"
        "locked wheels (A14), are 636 N.",
    ),
    "cornering": _head(
        "cornering",
        "cornering-stiffness method",
        "Every run is `friction/e2_double_lane_change_33` (33 km/h, lanes\n"
        "3.5 m apart, car of Table 4 on the MuJoCo plant), with one thing other than the method assumes. Slopes are\n"
        "the smallest of the run while the window spans its slip angles; an alarm (`limit_reached`) is a slope of 0\n"
        "and less. The front axle uses at most 0.82 of its limit, the rear one 0.55, but in the tables of less grip,\n"
        "so that alarms elsewhere are false. Both variants know the body's lean (`roll_gradient`). Beside the shipped\n"
        "span of 1 deg stands the 2 deg with which the document's criterion A16 is met on this car.\n"
        "Not tried: torques and the ABS, of which the method hears nothing and which are not in the run.",
    ),
    "state": _head(
        "state",
        "vehicle-state observers",
        "Every run is `state/slalom_dry_asphalt` (60 km/h, six sines of 100 degrees\n"
        "at the steering wheel, the document's planar car), with one thing other than assumed; the two\n"
        "of braking are stops of the same car on the MuJoCo plant. `vehicle_state_ukf` has the wheels' odometer for\n"
        "its speed. Friction limits are means over the run from the start value 0.6 on (-37 % of 0.95): they show\n"
        "when a fit came and what it gave; a run without a fit stays there.",
    ),
    "load": _head(
        "load",
        "observers of the vertical loads",
        "Every run is `state/vertical_load_lane_change` (70 km/h, the document's\n"
        "own car), with one thing other than the observers assume. At rest the loads are 5.5 kN in front, 3.7 kN\n"
        "behind. Not tried: torques, the ABS and the tyres' stiffness, of which these observers hear nothing.",
    ),
    "force": _head(
        "force",
        "observers of the axle forces",
        "Every run is `state/neural_force_slalom` (the document's 700 kg car under\n"
        "a steady steering sine), with one thing other than the observers assume. The sum of the forces is compared:\n"
        "how it is shared between the axles cannot be observed while the wheels stand straight\n"
        "([models/neural_force.md](models/neural_force.md), with the table of a wrong car and its tyres). Not tried:\n"
        "the longitudinal accelerometer, torques and the ABS, which are no inputs, and no braking is in it.",
    ),
    "attitude": _head(
        "attitude",
        "attitude filters",
        "Every run is `state/attitude_slalom` (the MuJoCo car on a flat road), with\n"
        "one thing other than the filters assume. The bank stands beside the document's three references (8 item 57):\n"
        "one filter with the bank's noise, one with the noise that suits it best (chosen without a disturbance),\n"
        "one with the offset as one more state. The second, which trusts the roll balance, is the best of them\n"
        "wherever that balance holds, that is but for the mass; offsets of 100 mG:\n"
        "[models/attitude_bank.md](models/attitude_bank.md).\n"
        "Not tried: torques and tyres, of which they hear nothing; the ABS, which holds the weights\n"
        "(`state/attitude_abs_stop`).",
    ),
}

_FRICTION = {
    "mass": (
        "With torques the wheel equations tell the true tyre force, which a heavier car needs more of, while "
        "the accelerometer times the believed mass tells less. The filter resolves the contradiction by a "
        "lower speed, hence less slip, and a higher limit. Without torques force and load scale alike and the "
        "ratio stays. In the document's rows of the force EKF (`rolling_speed: none`, below it) the speed hangs on the "
        "drag alone (observability: `tests/estimators/test_force_ekf_contradiction.py`); wheels and accelerometer "
        "contradict each other by 2 m/s² at +20 %, which its equations explain by a lower speed: the linear filter "
        "rests below standstill. Wheels that roll before the brake leave little doubt about the speed, so that the "
        "contradiction moves it less; it is told as not to be trusted all the same (`speed_confidence`, 0.1 to 0.4 s "
        "after the brake). The forces err by what the accelerometer contradicts."
    ),
    "wheel_radius": (
        "Smaller wheels turn faster: while rolling the speed is too high by as much, and the error lasts "
        "through the stop. Speed and rim speed are wrong alike, so that slip and friction stay nearly right."
    ),
    "grade": (
        "An accelerometer on a slope feels g sin(grade), 0.49 m/s² at 5 %; the filter integrates it. Downhill "
        "its speed falls below that of the wheels, the slip that is left cannot make the force, and the limit "
        "rises to its guard (`largest_friction_limit`). The document assumes a level road (3.6.1); "
        "`road_grade` estimates the slope. The force EKF takes a slope on which its wheels roll for an offset of the "
        "accelerometer: its speed gains by that, its forces lose, for on a slope the accelerometer is right about them."
    ),
    "accelerometer_offset": (
        "Integrated by row 8 and read as force by row 1, as on a slope. Without torques nothing but the "
        "accelerometer tells the force, so that the error is twice as large. To the document's rows of the force EKF "
        "(`rolling_speed: none`) 0.1 m/s² are the drag of 6.7 m/s more or less at 20 m/s, no contradiction: the speed "
        "moves there within a second, mostly before the brake. As shipped it finds the offset while an axle rolls "
        "(`acceleration_offset`, in some 0.15 s) and takes it out (`tests/estimators/test_force_ekf_offset.py`)."
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
        "the swing away. In the document's rows of the force EKF the speed runs off as with an offset, upwards."
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

_CORNERING = {
    "mass": (
        "Force and load are believed from the file's mass alike, so that the friction in use stays. The heavier car "
        "leans more than it was told, which the accelerometer feels as force that never came: the side-slip angle's "
        "integral goes wrong by it, the rear axle's pairs bend, and the span of 1 deg sounds false alarms."
    ),
    "centre_of_gravity_height": "It only matters by the lean, as with the mass.",
    "wheel_radius": (
        "Wheels that are smaller by 3 % make the speed 3 % too high and a_y/v - yaw rate too small, against the lean "
        "of the body that is left: the nominal error has the other sign."
    ),
    "grade": (
        "A car that is turned by 13 degrees across a slope of 5 % needs side force against 0.11 m/s² of weight, which "
        "turns it nowhere: the side-slip angle's integral takes it for a drift, twice the nominal error."
    ),
    "bank": (
        "A bank is a lateral acceleration that turns no car: 5 % are 0.49 m/s², and 0.49/v for two seconds (the time "
        "constant of `side_slip_time_constant`) make 0.08 rad of side slip. Slopes are differences and bear a constant "
        "error; what is left while the angle drifts are false alarms."
    ),
    "lateral_accelerometer_offset": "The same as a bank of that size, and in the friction in use besides.",
    "yaw_gyroscope_offset": (
        "Integrated like the accelerometer's: 2 deg/s for two seconds are 0.05 rad. The drift counts as slip angle in "
        "the regression, and a sixth of the run is a false alarm with a span of 1 deg, none with 2 deg."
    ),
    "accelerometer_offset": "It only moves load between the axles: half a per cent of friction.",
    "sensor_noise": (
        "Friction in use follows the noise of accelerometer and yaw rate, whose derivative it contains; the span of "
        "1 deg gives 1.5 % of false alarms at five times the noise, 2 deg none."
    ),
    "latency": "Everything late alike: slopes do not change.",
    "lost_frames": "Values are held; next to nothing.",
    "adaptive_damper": "A body that leans with less delay makes the slopes smoother.",
    "other_car": "The car of Table 8 with its file and the first car's lean: no worse.",
    "less_grip": (
        "On 0.6 the front axle comes to 95 % of its limit, and the smallest slope falls to a quarter. On 0.3 it is "
        "beyond 97 % for a tenth of the run: true alarms, but only for a fifth of that time with a span of 1 deg and "
        "hardly any with 2 deg, whose windows still contain the way up. The rear axle stays below its limit."
    ),
    "grip_jump": (
        "The fall to 0.3 in the middle of the change brings the front axle beyond 97 % of its limit for 6 % of the "
        "run; 1 deg tells of it for 0.1 %, 2 deg only by a slope of 0.13."
    ),
    "rubber": (
        "A harder curve needs smaller slip angles for the same force: windows that span 1 or 2 deg become long and "
        "few, and an error of the side-slip angle is a larger part of what they span. False alarms behind, where the "
        "slip angle is all side slip."
    ),
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
        "times yaw rate would be. A car that stands first learns it; this one does not."
    ),
    "sensor_noise": "All noises times 2 and 5: the filters average them.",
    **_LINE,
    "wheel_radius": (
        "Speed is wheel speed times radius: too high by as much, 0.5 m/s at 3 %. Speed times yaw rate is then more "
        "than the accelerometer tells, and slip angle and lateral acceleration pay for it."
    ),
    "grade": (
        "The cascade reads 5 % within 1.1 %, uphill better than downhill. `road_grade` alone knows no lateral speed: "
        "in a slalom the part v_y w of the accelerometer counts as a slope, 0.05 on the level road too."
    ),
    "accelerometer_offset": (
        "Nobody but the grade observer hears the longitudinal accelerometer, and its grade is wrong by the offset "
        "over g, 0.031 at 0.3 m/s². The cascade's lateral figures move with it, since the grade is in "
        "its loads and its speed; that they get better is chance, the nominal ones have the other sign."
    ),
    "adaptive_damper": (
        "The step from the first to the second level is the MuJoCo car: load transfer by axles, a compliant steering, "
        "tyres that share their friction ([vehicle state](models/vehicle_state.md)). Its slip angles stay below the "
        "first threshold's, so that no fit comes. Adaptive dampers take a little of the error away."
    ),
    "unknown_torque": (
        "With ABS on dry asphalt. Known: nominal gain times wheel pressures (`longitudinal.brake_torque: pressure`). "
        "Unknown: the observers are defined for traction only and say so (`traction_only` 1, confidences 0): a wheel "
        "model without the brake's torque is 14 m/s off, while the odometer of the lateral filter is 2.5 m/s off, its "
        "wheels slip. Known is no better than that odometer, since all four wheels slip and nothing else ties the "
        "speed; the grade then gets what is missing. The grade of the second column is held while braking."
    ),
    "other_car": (
        "A rear-driven SUV of 1862 kg (`longitudinal.driven_axle: rear`), its file known: nothing was tuned to the "
        "first car. The same steering turns it less (longer wheelbase, ratio 17), and the errors are smaller."
    ),
    "grip_jump": (
        "At 8 s, from 0.95 to 0.76 and 0.57. Slip angles and yaw rate stay; the lateral acceleration of the cascade "
        "errs up to twice as much, until its next fit it believes the old limit."
    ),
    "rubber": (
        "B of the lateral curve: softer 5.0 in front and 6.3 behind, two kinds 7.2 and 18, harder 14.4 and 18 (as "
        "assumed 7.2 and 9). Nobody is told: slopes and fits find it. Slip angles stay; two kinds cost the "
        "limits most."
    ),
    "abs_calibration": (
        "As in the column of known torques above the speed is the trouble, with the coarser control by 0.3 m/s less."
    ),
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
    "wheel_radius": "The speed is 1.5 and 3 % too high, and matters by little: the accelerometer tells what counts.",
    "grade": (
        "The accelerometer feels 5 % as 0.49 m/s², and the observers move load between the axles for it as for an "
        "offset of that size (next table)."
    ),
    "accelerometer_offset": "It moves load between the axles: 0.3 m/s² are some 70 N for each wheel, with any filter.",
    "grip_jump": "At 2 s, in the middle of the lane change. The car turns less, and the sensors tell all of it.",
    "adaptive_damper": (
        "The step from the first to the second level is the MuJoCo car (see the rough road). The other damping is not "
        "in the roll model: it costs the filters with a roll gyroscope 30 N, the one of two sensors next to nothing."
    ),
    "other_car": (
        "Both on the MuJoCo car. With the Vesta's file the filters with a roll gyroscope do as well as on the SUV; the "
        "one of two sensors, which is the best there, is worse than they."
    ),
}

_FORCE = {
    "mass": "The sum of forces is mass times what the speed tells: what the file lacks is missing in it.",
    "yaw_gyroscope_offset": "The yaw rate is a measured state; its offset becomes lateral speed.",
    "sensor_noise": (
        "All noises times 2 and 5. The observer's gain passes noise of the yaw rate to the lateral speed, and noise of "
        "the wheel speeds is learned as force: at five times the noise the sum is worse than without learning."
    ),
    **_LINE,
    "wheel_radius": "The speed is wheel speed times radius: at 3 % the lateral speed pays, the forces hardly.",
    "mujoco": (
        "The document's car has linear tyres, a level road and no dampers, so these are tried on the MuJoCo car with "
        "the same numbers. At 0.7 rad its front tyres carry up to 4.1 kN across, and F_yf sin(delta), 1.07 kN RMS, "
        "pulls the car back; with C_f = 1000 N/rad the observer expects 0.06 kN. The speed tells of the rest, and "
        "the network learns it as a force along the wheels: from 5 s on its sum is 533 N too low, the pull that the "
        "model lacks is 538 N on the mean. The mean rim speed, in bends up to 0.46 m/s above the car's, adds 0.24 kN "
        "RMS. One constant neuron errs alike (875 N). Without a network the sum is always told to be zero: its error "
        "is the true sum, 249 N here, and the smaller figure is no merit. A grade of 5 % is 340 N of weight that no "
        "input tells; dampers and less grip change little."
    ),
}

_ATTITUDE = {
    "mass": (
        "A heavier car leans more. That the errors fall says that the filters, with the file's stiffness, believe a "
        "little more lean than the plant shows at its nominal mass. The filter with its own noise takes the lean "
        "nearly alone from the roll balance, where the mass is wrong: five times its error."
    ),
    "bank": "The forms of a flat road have no bank: its angle counts as lean of the body.",
    "lateral_accelerometer_offset": (
        "What the bank is made for: with an offset of 0.3 m/s² (31 mG) its roll angle stays, that of one filter with "
        "its noise does not. One filter with the offset as a state does as well here, where nothing else is wrong; one "
        "with the noise that suits it hardly asks the accelerometer: half more error, still less than the bank's."
    ),
    "roll_gyroscope_offset": "Offsets of the gyroscopes are states of every filter and are found.",
    "yaw_gyroscope_offset": "As the roll gyroscope's.",
    "latency": (
        "Everything late alike: the estimates belong to the past, and nobody can tell. The roll balance is that of a "
        "body without roll damping, whose lean is ahead of the true one: the filter that trusts it gains by the delay."
    ),
    "lost_frames": _LINE["lost_frames"],
    "sensor_noise": "All noises times 2 and 5: they are averaged, and cost next to nothing.",
    "wheel_radius": (
        "A speed that is too high makes speed times yaw rate too large, and with it the lean. The errors fall, as with "
        "the mass: the nominal ones have the other sign."
    ),
    "grade": "The forms of a flat road have no slope; uphill errors fall and downhill they grow, by up to a half.",
    "accelerometer_offset": (
        "The shipped form does not take the longitudinal accelerometer: the figures are the same to the last digit."
    ),
    "adaptive_damper": (
        "Of the suspension mostly the stiffness counts in a slalom this slow: a tenth either way, half more for the "
        "filter that takes the lean from the roll balance."
    ),
    "other_car": "The Lada Vesta with its file: nothing was tuned to the first car; errors are no larger.",
    "grip_jump": (
        "At 30 s, from 0.9 to 0.72 and 0.54, of which the 6 m/s² of this slalom are 85 and more than 100 %. All "
        "filters err up to five times as much, the bank no less than the others; the one with its own noise stays at "
        "half of that, since the roll balance knows no friction."
    ),
}

REASONS = {
    "friction": _FRICTION,
    "cornering": _CORNERING,
    "state": _STATE,
    "load": _LOAD,
    "force": _FORCE,
    "attitude": _ATTITUDE,
}
