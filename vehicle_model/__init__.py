"""The car and its road: files, parameters, plants, tyres, powertrain, driver and sensors."""

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()
