"""Ackermann control: a wheel angle, a speed and an acceleration instead of pedals.

Two PID controllers in a row, from speed to acceleration and from that to the pedals, with CARLA's gains, limits and
order of steps (public source of 0.9.15, `AckermannController`), run once in each tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

MAX_ACCELERATION_MPS2 = 3.0
"""Largest acceleration (m/s²). As in CARLA."""
MAX_DECELERATION_MPS2 = 8.0
"""Largest deceleration (m/s²). As in CARLA."""
STANDING_MPS = 0.1
"""Speed below which the vehicle counts as stopped (m/s). As in CARLA."""
GAINS = (0.15, 0.0, 0.25, 0.01, 0.0, 0.01)
"""Speed kp, ki, kd, acceleration kp, ki, kd. As in CARLA."""


@dataclass
class _Controller:
    integral: float = 0.0
    last: float = 0.0

    def run(self, gains: Sequence[float], error: float, value: float, dt: float) -> float:
        kp, ki, kd = gains
        self.integral = _clip(self.integral + ki * error * dt, 1.0)
        out = kp * error + self.integral - kd * (value - self.last) / dt
        self.last = value
        return _clip(out, 1.0)


@dataclass
class Ackermann:
    """The controller of one vehicle."""

    gains: tuple[float, ...] = GAINS
    active: bool = False
    """True if the last command was an Ackermann command; any other kind replaces it."""
    target: tuple[float, ...] = (0.0,) * 5
    """Wheel angle (rad), its rate (rad/s), speed (m/s), acceleration (m/s²), jerk."""
    speed: float = 0.0
    acceleration: float = 0.0
    wanted: float = 0.0
    """Acceleration (m/s²)."""
    pedal: float = 0.0
    """Throttle above zero, brake below."""
    reverse: bool = False
    by_speed: _Controller = field(default_factory=_Controller)
    by_acceleration: _Controller = field(default_factory=_Controller)

    def command(self, target: Sequence[float]) -> None:
        """Accept a command. The controllers are reset if another kind of control was active."""
        if not self.active:
            self.acceleration = self.wanted = self.pedal = 0.0
            self.by_speed, self.by_acceleration = _Controller(last=self.speed), _Controller()
        self.active, self.target = True, tuple(target)

    def control(self, ahead: float, steer: float, max_steer: float, dt: float) -> tuple[float, ...]:
        """Return the pedals and switches of this tick at speed `ahead` (m/s) and wheel position `steer`."""
        change = (ahead - self.speed) / dt
        self.speed, self.acceleration = ahead, (4.0 * self.acceleration + change) / 5.0
        angle = self._angle(steer * max_steer, max_steer, dt)
        if abs(ahead) < STANDING_MPS and abs(self.target[2]) < STANDING_MPS:
            return (0.0, angle / max_steer, 1.0, 0.0, float(self.reverse), 0.0, 1.0)
        self._pedals(ahead, dt)
        push = -self.pedal if self.reverse else self.pedal
        return (max(push, 0.0), angle / max_steer, max(-push, 0.0), 0.0, float(self.reverse), 0.0, 1.0)

    def _angle(self, now: float, max_steer: float, dt: float) -> float:
        wanted, rate = _clip(self.target[0], max_steer), abs(self.target[1])
        return wanted if rate < 0.001 else now + _clip(wanted - now, rate * dt)

    def _pedals(self, ahead: float, dt: float) -> None:
        speed = self.target[2]
        if abs(ahead) < STANDING_MPS:
            self.reverse = speed < 0.0
        elif ahead * speed < 0.0:
            speed = 0.0
        bound = abs(self.target[3])
        low, high = (-bound, bound) if bound > 1e-4 else (-MAX_DECELERATION_MPS2, MAX_ACCELERATION_MPS2)
        self.wanted += self.by_speed.run(self.gains[:3], speed - ahead, ahead, dt)
        self.wanted = min(max(self.wanted, low), high)
        error = self.wanted - self.acceleration
        self.pedal = _clip(self.pedal + self.by_acceleration.run(self.gains[3:], error, self.acceleration, dt), 1.0)


def _clip(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)
