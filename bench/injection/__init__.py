"""The fault injector on the bench's bus: inside a run, and as a process between two channels."""
