"""The 1 ms loop: what happens in a tick, how ticks are paced, and the processes around them."""
