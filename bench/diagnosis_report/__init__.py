"""``diagnosis.html``: what a diagnosis found, pictures first.

from bench.diagnosis_report.page import build
"""
