"""Catalogue of effects: what a simulation of a braking car usually gets wrong, an effect a named record."""
