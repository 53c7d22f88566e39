"""Sensor cluster: an inertial sensor block on SPI, and the microcontroller that reads it and sends CAN frames.

Friction document 1.3, 1.7 and 5.3: either half may be the real part while the bench plays the other one.
"""
