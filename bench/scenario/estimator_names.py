"""Names of estimators in a run: that of the estimator, or that name with ``_`` and anything behind it.

``friction_ekf`` and ``friction_ekf_printed_sign`` are two filters of the kind ``friction_ekf`` in one run.
"""

from functools import lru_cache


@lru_cache(maxsize=256)
def kind_of(name: str) -> str:
    """Kind of the estimator of that name in a run.

    Raises
    ------
    InputError
        If the name begins with no estimator's.
    """
    from estimators import names
    from signals.errors import unknown_name

    known = names()
    fitting = [kind for kind in known if name == kind or name.startswith(f"{kind}_")]
    if not fitting:
        raise unknown_name("estimator", name, known)
    return max(fitting, key=len)


def estimator_units(estimator_names: list[str]) -> dict[str, str]:
    """Unit of every output, by its name in the run (``<name>.<output>``)."""
    from estimators import describe

    return {
        f"{name}.{output.name}": output.unit for name in estimator_names for output in describe(kind_of(name)).outputs
    }
