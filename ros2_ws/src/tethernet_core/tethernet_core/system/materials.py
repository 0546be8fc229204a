"""Thread materials by name, with their sources."""

from __future__ import annotations

from typing import NamedTuple


class Material(NamedTuple):
    """A fibre that nets are made of."""

    modulus_pa: float
    """Young's modulus of a fibre [Pa]."""
    density_kg_m3: float
    """[kg/m^3]."""
    strength_pa: float
    """Tensile strength [Pa]."""
    source: str
    """Where the numbers come from."""


MATERIALS = {
    "technora": Material(
        7.0e10, 1390.0, 3.4e9, "Teijin Aramid, Technora product data: 70 GPa [A: lower end], 1390 kg/m^3, 3.4 GPa"
    ),
    "kevlar": Material(
        7.05e10, 1440.0, 2.92e9, "DuPont, Kevlar Technical Guide, Kevlar 29: 70.5 GPa, 1440 kg/m^3, 2.92 GPa"
    ),
    "dyneema": Material(
        1.16e11, 975.0, 3.6e9, "DSM, Dyneema SK75 fibre properties: 109 to 132 GPa, 970 to 980 kg/m^3, 3.3 to 3.9 GPa"
    ),
}
"""Known materials."""
