"""Tyre models and tyre files."""
