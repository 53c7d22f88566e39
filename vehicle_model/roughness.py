"""Road roughness: two wheel tracks with the spectra of ISO 8608 and the coherence of an isotropic surface.

The displacement spectrum of a track over spatial frequency n is G_d(n) = G_d(n_0) (n/n_0)^-w with n_0 = 0.1 cycles/m
(ISO 8608:2016, eq. 1 and table C.1: classes A to H, w = 2). Two parallel tracks a lateral distance b apart on a surface
whose statistics are the same in every direction have the coherence (Dodds and Robson 1973)

    γ(n) = 2 (π b n)^ν K_ν(2 π b n) / Γ(ν),   ν = w/2:   long waves lift both wheels alike, short ones do not.
"""

import numpy as np
from numpy.typing import NDArray

REFERENCE_FREQUENCY = 0.1
"""n_0 of ISO 8608, cycles/m."""
LOWEST_FREQUENCY, HIGHEST_FREQUENCY = 0.011, 2.83
"""Range of spatial frequencies for which ISO 8608 states the classes, cycles/m."""

SPACING_M = 0.05
POINTS = 16384  # a power of two, so that the track repeats by a mask: 819.2 m


def spectrum(frequency: NDArray[np.float64], level: float, waviness: float = 2.0) -> NDArray[np.float64]:
    """One-sided displacement spectrum G_d(n) [m^3] at spatial frequencies [cycles/m]; ISO 8608, eq. 1."""
    return np.asarray(level * (frequency / REFERENCE_FREQUENCY) ** -waviness)


def coherence(frequency: NDArray[np.float64], track: float, waviness: float = 2.0) -> NDArray[np.float64]:
    """Coherence (not squared) of two tracks ``track`` metres apart; 1 at zero frequency or distance."""
    from scipy.special import gamma, kv

    order = 0.5 * waviness
    argument = np.pi * track * np.asarray(frequency, float)
    result = np.ones_like(argument)
    apart = argument > 1e-9
    near = argument[apart]
    result[apart] = 2.0 * near**order * kv(order, 2.0 * near) / gamma(order)
    return result


def two_tracks(level: float, waviness: float, track: float, realisation: int) -> NDArray[np.float64]:
    """Heights of the left and the right track.

    Parameters
    ----------
    level : m^3
        G_d(n_0).
    track : m
        Lateral distance of the tracks.
    realisation : int
        Seed: another stretch of road with the same statistics.

    Returns
    -------
    shape (2, POINTS), m
        At multiples of ``SPACING_M``, periodic, without mean.
    """
    generator = np.random.default_rng([realisation, 8608])
    frequency = np.fft.rfftfreq(POINTS, SPACING_M)
    inside = (frequency >= LOWEST_FREQUENCY) & (frequency <= HIGHEST_FREQUENCY)
    n = np.asarray(frequency[inside], np.float64)
    # amplitude of the cosine of each line: half its square is G_d times the distance of the lines
    amplitude = np.sqrt(2.0 * spectrum(n, level, waviness) * frequency[1])
    phases = generator.uniform(0.0, 2.0 * np.pi, (2, n.size))
    own, other = np.exp(1j * phases)
    shared = coherence(n, track, waviness)
    lines = np.zeros((2, frequency.size), complex)
    lines[0, inside] = amplitude * own
    lines[1, inside] = amplitude * (shared * own + np.sqrt(1.0 - shared**2) * other)
    return np.asarray(np.fft.irfft(lines, POINTS) * (0.5 * POINTS))
