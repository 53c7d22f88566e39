"""A diagnosis of a made-up car whose pads have lost a fifth of their friction, for tests of the page.

Point mass with four wheels that follow it: v̇ = -(k λ p + drag)/m; the vehicle file has λ = 1, the car 0.8.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.findings import Findings, ManoeuvreFindings
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import (
    Cause,
    DataFault,
    Diagnosis,
    DiscoveredTerm,
    Gain,
    NextManoeuvre,
    OverallGain,
    ParameterEstimate,
    SignalGain,
)
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

MASS_KG, RADIUS_M, DRAG_N_S2_M2 = 1300.0, 0.3, 0.45
FORCE_PER_PRESSURE_N_PA = 1.2e-3
STD = {"longitudinal_acceleration": 0.08, "speed": 0.05, **{f"wheel_speed_{wheel}": 0.1 for wheel in WHEELS}}
SIGNALS = tuple(STD)
TRUE_FRICTION = 0.8


def _drive(pressure: FloatArray, speed: float, friction: float) -> FloatArray:
    """(n, 6) signals of a car with this share of its pad friction."""
    values = np.empty((len(pressure), len(SIGNALS)))
    for row, value in enumerate(pressure):
        force = FORCE_PER_PRESSURE_N_PA * friction * value + DRAG_N_S2_M2 * speed**2
        acceleration = -force / MASS_KG if speed > 0 else 0.0
        slip = 2e-5 * force / 4.0
        values[row] = [acceleration, speed, *[speed / RADIUS_M * (1.0 - slip)] * 4]
        speed = max(0.0, speed + SAMPLE_TIME_S * acceleration)
    return values


def _pressure(bar: float, seconds: float) -> FloatArray:
    time = SAMPLE_TIME_S * np.arange(round(seconds / SAMPLE_TIME_S))
    return 1e5 * bar * np.clip((time - 1.0) / 0.4, 0.0, 1.0)


def manoeuvre(name: str, bar: float, seconds: float, seed: int, *, held_out: bool = False) -> ManoeuvreFindings:
    """Measured with noise, replayed with the vehicle file and with the friction that was found."""
    pressure = _pressure(bar, seconds)
    generator = np.random.default_rng(seed)
    truth = _drive(pressure, 30.0, TRUE_FRICTION)
    noise = generator.normal(size=truth.shape) * np.array([STD[signal] for signal in SIGNALS])
    measured = truth + noise
    weights = np.ones_like(measured)
    weights[150:180, 1] = 0.0
    columns = dict(zip(SIGNALS, measured.T, strict=True))
    time = SAMPLE_TIME_S * np.arange(len(pressure))
    source = Manoeuvre(
        name=name,
        time=time,
        channels={**columns, **{f"brake_pressure_{wheel}": pressure for wheel in WHEELS}},
        weights=dict(zip(SIGNALS, weights.T, strict=True)),
        source=f"{name}.mf4, 0.00 s to {time[-1]:.2f} s",
    )
    before, after = _drive(pressure, 30.0, 1.0), _drive(pressure, 30.0, 0.795)
    # an observer keeps the replay at the measurement: speeds come back with 0.3 s
    drawn = 0.97 * (truth - before)[:, 1:].cumsum(axis=0) / (1.0 + np.arange(len(before))[:, None])
    observed = before.copy()
    observed[:, 1:] += drawn
    return ManoeuvreFindings(
        manoeuvre=source,
        signals=SIGNALS,
        measured=measured,
        before=observed,
        after=after,
        weights=weights,
        free_before=before,
        free_after=after,
        restarted_before=measured + 0.25 * (before - measured),
        restarted_after=after,
        states={
            "speed": truth[:, 1],
            **{f"slip_ratio_{wheel}": truth[:, 2] * RADIUS_M / np.maximum(truth[:, 1], 1.0) - 1.0 for wheel in WHEELS},
            **{f"brake_disc_temperature_{wheel}": 20.0 + np.cumsum(pressure * truth[:, 1]) * 6e-9 for wheel in WHEELS},
        },
        held_out=held_out,
    )


def manoeuvres() -> Sequence[ManoeuvreFindings]:
    """Four stops, the last one held out."""
    return [
        manoeuvre("coast", 0.0, 8.0, 1),
        manoeuvre("gentle_stop", 20.0, 9.0, 2),
        manoeuvre("firm_stop", 45.0, 6.0, 3),
        manoeuvre("hard_stop", 70.0, 4.0, 4, held_out=True),
    ]


def cause() -> Cause:
    """What was found."""
    return Cause(
        effect="brake_pad_friction",
        probability=0.83,
        parameters={
            "factor": ParameterEstimate(value=0.318, low=0.314, high=0.322, unit="1", nominal=0.4),
        },
        group=["brake_pad_friction", "pressure_sensor_scale"],
        equation="T_b ← λ T_b at all wheels",
        evidence=92.4,
        remarks=["Carried by three of three manoeuvres that brake."],
    )


def diagnosis() -> Diagnosis:
    """The whole answer."""
    return Diagnosis(
        verdict="effect_found",
        causes=[cause()],
        data_faults=[
            DataFault(
                kind="channel_sign", channel="lateral_acceleration", value=-1.0, unit="1", repaired=True,
                message="counts to the right; ours is positive to the left",
            ),
            DataFault(
                kind="gap", channel="speed", value=0.3, unit="s", message="no samples from 1.50 s to 1.80 s",
            ),
        ],
        discovered_terms=[],
        gain=Gain(
            held_out={
                "longitudinal_acceleration": SignalGain(
                    before=0.92, after=0.09, low=0.085, high=0.12, unit="m/s^2", noise_floor=0.08
                ),
                "speed": SignalGain(before=1.9, after=0.11, low=0.08, high=0.16, unit="m/s", noise_floor=0.05),
                "wheel_speed_fl": SignalGain(before=6.2, after=6.4, low=5.1, high=7.2, unit="rad/s", noise_floor=0.1),
            },
            overall=OverallGain(ratio=0.12, low=0.09, high=0.16),
            against_refit=OverallGain(ratio=0.2, low=0.15, high=0.27),
            user_figures={"stopping distance from 100 km/h, m": {"before": 41.2, "after": 50.9, "measured": 50.6}},
        ),
        next_manoeuvre=NextManoeuvre(
            name="hold_at_standstill",
            description="Press the pedal at standstill and compare the wheel pressures with the master pressure.",
            separates=["brake_pad_friction", "pressure_sensor_scale"],
            expected_evidence=14.2,
        ),
        extension_file="extended_vehicle.yaml",
        insufficient=["tyre_temperature_fade", "steering_ratio"],
        guilty_equations={
            "longitudinal force": 4.0,
            "lateral force": 0.4,
            "yaw moment": 1.0,
            "load transfer": 7.0,
            "wheel torque fl": 310.0,
            "wheel torque fr": 402.0,
            "wheel torque rl": 120.0,
            "wheel torque rr": 95.0,
            "hydraulics fl": 3.0,
            "speed": 52.0,
        },
        threshold=4.2,
        timing_s={"reading": 1.2, "replay": 8.4, "evidence": 21.0},
        versions={"brake-control-bench": "0.1.0"},
    )  # fmt: skip


def findings() -> Findings:
    """Diagnosis and arrays."""
    return Findings(
        diagnosis=diagnosis(),
        vehicle="made-up car",
        manoeuvres=manoeuvres(),
        sensor_std=STD,
        evidence={"brake_pad_friction": 90.0, "pressure_sensor_scale": 89.1, "mass_change": 11.0, "aero_drag": 0.4,
                  "tyre_friction": -1.2},
        logs=["coast.mf4", "stops.mf4"],
    )  # fmt: skip


def discovered() -> DiscoveredTerm:
    """A term as discovery states it."""
    return DiscoveredTerm(
        formula="a · T_b · v²", target="wheel torque", coefficients=[-2.1e-4], low=[-2.6e-4], high=[-1.7e-4],
        units=["s²/m²"], inclusion=0.93,
    )  # fmt: skip
