"""``bench diagnose``: logs or recordings in, files and words out.

from bench.diagnosis.diagnosing import diagnose
"""
