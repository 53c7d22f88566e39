"""Runs beside each other: the table of what is in a folder, and two runs compared."""
