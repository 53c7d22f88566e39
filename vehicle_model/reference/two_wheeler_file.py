"""Section of a vehicle file that describes a two-wheeler, which has no place in the sections of a car."""

from signals.quantities import FileModel, parameter


def _number(unit: str, low: float, high: float, description: str) -> float | None:
    declared: float | None = parameter(unit, None, low=low, high=high, description=description)
    return declared


class TwoWheelerSection(FileModel):
    """Motorcycle with rider (attitude document, 2.0 and 5); left out in files of cars.

    Lengths are those of the upright vehicle. The radii of its wheels are those of the section ``wheels``, its wheelbase
    is the sum of both distances of the sensor.
    """

    sensor_to_rear_axle: float | None = _number(
        "m", 0.05, 3.0, "L: horizontal distance of the sensor to the rear wheel"
    )
    sensor_to_front_axle: float | None = _number("m", 0.05, 3.0, "L': to the front wheel")
    sensor_height: float | None = _number("m", 0.05, 3.0, "h: of the sensor over the road")
    crown_radius: float | None = _number("m", 0.0, 0.3, "R_cr: of the cross-section of both tyres")
    sprung_mass: float | None = _number("kg", 10.0, 5000.0, "M: main body with rider")
    mass_x: float | None = _number("m", -2.0, 2.0, "W_x: mass centre of the main body before the sensor")
    mass_z: float | None = _number("m", -2.0, 2.0, "W_z: above the sensor")
    roll_inertia: float | None = _number("kg m^2", 0.1, 1e4, "I_xx of the main body about its mass centre")
    pitch_inertia: float | None = _number("kg m^2", 0.1, 1e4, "I_yy")
    yaw_inertia: float | None = _number("kg m^2", 0.1, 1e4, "I_zz")
    inertia_product: float | None = _number("kg m^2", -1e3, 1e3, "I_xz, element of the tensor")
    drag_area: float | None = _number("m^2", 0.0, 10.0, "c_d A of the aerodynamic force gamma at the mass centre")
    caster_angle: float | None = _number("rad", 0.0, 1.0, "eps_F of the fork against the vertical")
    arm_angle: float | None = _number("rad", -1.0, 1.0, "eps_R of the rear arm against the horizontal")
    lever_ratio: float | None = _number(
        "1", 0.1, 10.0, "kappa: travel of the rear wheel over that of its shock absorber"
    )
    spring_rate_front: float | None = _number("N/m", 1e3, 1e6, "k_F along the fork")
    spring_rate_rear: float | None = _number("N/m", 1e3, 1e6, "k_R of the shock absorber")
    damping_front: float | None = _number("N s/m", 10.0, 1e5, "C_F along the fork")
    damping_rear: float | None = _number("N s/m", 10.0, 1e5, "C_R of the shock absorber")
    preload_front: float | None = _number("N", 0.0, 1e5, "l_F; left out: the force at rest, which leaves no stroke")
    preload_rear: float | None = _number("N", 0.0, 1e5, "l_R; left out: the force at rest")
    static_elevation: float | None = _number("rad", -0.5, 0.5, "zeta_0: nose-down angle of the body at zero stroke")
