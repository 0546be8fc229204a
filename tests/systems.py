"""Systems that tests fly."""

from tethernet_core.system import System, load_system


def zenit(units: int) -> System:
    """The shipped system of the paper with so many units."""
    return load_system(f"zenit_{units}mu")
