"""Estimators outside the loop: on recordings and measured logs, compared with each other, tried on worse conditions."""
