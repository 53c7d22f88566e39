"""From named causes to a vehicle file that the plant runs.

from model_diagnosis.extension.extended_vehicle import extensions_of, write_extended_vehicle
"""
