"""Layout of the row that holds for one step of the car: what every formula gives, then what each keeps for itself."""

PEAK_FORCE_X, PEAK_FORCE_Y, PEAK_SLIP_X, PEAK_SLIP_Y, STIFFNESS_X, STIFFNESS_Y = range(6)
"""Both slips are 0 in a row whose peaks nobody has asked for yet: ``kernel.peak_slips`` gives them."""
KIND, DIRECTION = 6, 7
"""Formula that acts (that of the road's own curve included); 1 when travelling forwards, -1 backwards."""

KEPT = 8
PREPARED_SIZE = 64

SPEED_OF_BRISTLES = 10.0
"""Speed [m/s] above which no bristles act, whatever the contact's limits (``Contact.none_above``)."""
