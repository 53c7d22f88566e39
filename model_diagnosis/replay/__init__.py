"""Compact compiled car that replays measured manoeuvres; effects of the catalogue are deviations of its numbers."""
