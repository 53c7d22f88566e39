"""Fault campaigns: a scenario under many faults, and what each of them does to the car.

    campaign file ─► fault space ─► strategy ─► jobs ─► executor (local processes, dask) ─► rows ─► store ─► report
                                       ▲                                                     │
                                       └──────────────── outcomes, severities ◄──────────────┘

A job is the text of a resolved scenario and a seed, a row is plain data, and every run is named by a key that follows
from what it is: a campaign goes on where a killed one stopped, and each run can be repeated alone.
"""
