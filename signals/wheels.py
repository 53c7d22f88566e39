"""Wheel order used everywhere: front-left, front-right, rear-left, rear-right."""

WHEELS: tuple[str, str, str, str] = ("fl", "fr", "rl", "rr")
FRONT_LEFT, FRONT_RIGHT, REAR_LEFT, REAR_RIGHT = range(4)
