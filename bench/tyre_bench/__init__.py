"""Tyres beside the car: pictures of any tyre, and Magic Formula files fitted to measurements of a test rig."""
