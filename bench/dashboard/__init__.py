"""The terminal dashboard: a process of its own that reads the run's ring, and the same view for recordings."""
