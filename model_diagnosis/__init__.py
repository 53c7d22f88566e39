"""Given measured data: what the simulation gets wrong, its cause, the extended vehicle file and the gain.

from model_diagnosis.diagnosis import diagnose
"""
