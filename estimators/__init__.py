"""Estimators that see only measured signals: Kalman core, tyre-road friction, vehicle state."""

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

from estimators.registry import create, describe, groups, names  # noqa: E402

__all__ = ["create", "describe", "groups", "names"]
