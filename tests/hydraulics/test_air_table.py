"""The table of a bubble's compliance against the power it stands for."""

import numpy as np
import pytest

from hydraulics.fluid import ATMOSPHERE_PA, POLYTROPIC_EXPONENT, compliance_share


@pytest.mark.parametrize(("pressure_bar", "largest_error"), [(0.0, 0.0), (10.0, 1e-10), (50.0, 1e-8), (200.0, 2e-6)])
def test_compliance_by_the_table_is_the_power(pressure_bar: float, largest_error: float) -> None:
    """Cubic pieces of width h err by h^4 f''''/384, which grows towards small ratios: so at the highest pressure."""
    pressures = np.linspace(0.0, pressure_bar * 1e5, 2001)
    ratios = ATMOSPHERE_PA / (ATMOSPHERE_PA + pressures)
    shares = np.array([compliance_share(ratio) for ratio in ratios])
    powers = ratios ** (1.0 + 1.0 / POLYTROPIC_EXPONENT)
    assert np.max(np.abs(shares / powers - 1.0)) <= largest_error
