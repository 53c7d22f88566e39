"""Speed of the bench: run each module with ``python -m benchmarks.NAME``; every figure is printed, none asserted."""
