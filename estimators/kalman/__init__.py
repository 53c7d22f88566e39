"""Kalman core: linear, extended, unscented and cubature filters on plain arrays, compiled and allocation-free.

Every function is a kernel that works in place on the arrays of its caller; a filter is a few calls in a row. States
are vectors of length n, covariances n by n; scratch arrays come from the caller.
"""
