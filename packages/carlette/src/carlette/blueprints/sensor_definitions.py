"""The sensors' blueprints, with CARLA's attributes and defaults (its `Docs/ref_sensors.md`, 0.9.15).

`carlette.sensors` contains the class of each; `docs/carlette-sensors.md` describes the effect of each attribute here.
"""

from __future__ import annotations

from carlette.blueprints.definitions import Attribute, AttributeType, Definition, option

BOOL = AttributeType.BOOL
INT = AttributeType.INT
FLOAT = AttributeType.FLOAT
STRING = AttributeType.STRING

IN_THE_CLIENT = ("sensor.other.lane_invasion",)
"""Sensors that the client's library implements itself. The server sends no data for them."""

_PLACES = ("front", "back", "left", "right", "front_left", "front_right", "back_left", "back_right")
_TICK = {"sensor_tick": "0.0"}
_AXES = ("x", "y", "z")


def sensor_definitions() -> list[Definition]:
    """Return all sensors, in the order in which a client gets them."""
    image = {"image_size_x": "800", "image_size_y": "600"}
    return [
        _sensor("sensor.camera.depth", ints=image, floats=_TICK | _LENS),
        _sensor("sensor.camera.instance_segmentation", ints=image, floats=_TICK | _LENS),
        _rgb(image),
        _sensor("sensor.camera.semantic_segmentation", ints=image, floats=_TICK | _LENS),
        _sensor("sensor.lidar.ray_cast", ints=_LASERS | {"noise_seed": "0"}, floats=_TICK | _SWEEP | _LOSSES),
        _sensor("sensor.lidar.ray_cast_semantic", ints=_LASERS, floats=_TICK | _SWEEP),
        _sensor("sensor.other.collision"),
        _sensor("sensor.other.gnss", ints={"noise_seed": "0"}, floats=_TICK | _GNSS),
        _sensor("sensor.other.imu", ints={"noise_seed": "0"}, floats=_TICK | _IMU),
        _sensor("sensor.other.lane_invasion"),
        _sensor(
            "sensor.other.obstacle",
            floats=_TICK | {"distance": "5.0", "hit_radius": "0.5"},
            flags={"only_dynamics": "false", "debug_linetrace": "false"},
        ),
        _sensor(
            "sensor.other.radar",
            ints={"points_per_second": "1500"},
            floats=_TICK | {"horizontal_fov": "30.0", "vertical_fov": "30.0", "range": "100.0"},
        ),
    ]


_LENS = {
    "fov": "90.0",
    "lens_circle_falloff": "5.0",
    "lens_circle_multiplier": "0.0",
    "lens_k": "-1.0",
    "lens_kcube": "0.0",
    "lens_x_size": "0.08",
    "lens_y_size": "0.08",
}
_PICTURE = {
    "gamma": "2.2",
    "shutter_speed": "200.0",
    "iso": "100.0",
    "fstop": "1.4",
    "min_fstop": "1.2",
    "exposure_compensation": "0.0",
    "exposure_min_bright": "10.0",
    "exposure_max_bright": "12.0",
    "exposure_speed_up": "3.0",
    "exposure_speed_down": "1.0",
    "calibration_constant": "16.0",
    "focal_distance": "1000.0",
    "blur_amount": "1.0",
    "blur_radius": "0.0",
    "motion_blur_intensity": "0.45",
    "motion_blur_max_distortion": "0.35",
    "motion_blur_min_object_screen_size": "0.1",
    "lens_flare_intensity": "0.1",
    "bloom_intensity": "0.675",
    "slope": "0.88",
    "toe": "0.55",
    "shoulder": "0.26",
    "black_clip": "0.0",
    "white_clip": "0.04",
    "temp": "6500.0",
    "tint": "0.0",
    "chromatic_aberration_intensity": "0.0",
    "chromatic_aberration_offset": "0.0",
}
_LASERS = {"channels": "32", "points_per_second": "56000"}
_SWEEP = {
    "range": "10.0",
    "rotation_frequency": "10.0",
    "upper_fov": "10.0",
    "lower_fov": "-30.0",
    "horizontal_fov": "360.0",
}
_LOSSES = {
    "atmosphere_attenuation_rate": "0.004",
    "dropoff_general_rate": "0.45",
    "dropoff_intensity_limit": "0.8",
    "dropoff_zero_intensity": "0.4",
    "noise_stddev": "0.0",
}
_GNSS = {f"noise_{axis}_{what}": "0.0" for axis in ("lat", "lon", "alt") for what in ("stddev", "bias")}
_IMU = {
    **{f"noise_accel_stddev_{axis}": "0.0" for axis in _AXES},
    **{f"noise_gyro_stddev_{axis}": "0.0" for axis in _AXES},
    **{f"noise_gyro_bias_{axis}": "0.0" for axis in _AXES},
}


def _rgb(image: dict[str, str]) -> Definition:
    exposure = Attribute("exposure_mode", STRING, "histogram", ("manual", "histogram"), True, True)
    effects = {"enable_postprocess_effects": "true"}
    usual = _sensor(
        "sensor.camera.rgb", ints=image | {"blade_count": "5"}, floats=_TICK | _LENS | _PICTURE, flags=effects
    )
    return Definition(usual.id, (*usual.attributes, exposure))


def _sensor(
    id: str,
    ints: dict[str, str] | None = None,
    floats: dict[str, str] | None = None,
    flags: dict[str, str] | None = None,
) -> Definition:
    typed = ((INT, ints), (FLOAT, floats), (BOOL, flags))
    named = [option(item, kind, value, value) for kind, values in typed for item, value in (values or {}).items()]
    return Definition(id, (option("role_name", STRING, "front", *_PLACES), *named))
