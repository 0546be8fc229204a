"""All validation cases, by name."""

from __future__ import annotations

from collections.abc import Mapping

from tethernet_sim.validation import block, bounce, capstan, catenary, passive, rotation, sag, waves
from tethernet_sim.validation.case import Case

CASES: Mapping[str, Case] = {
    "sag": sag.REST,
    "swing": sag.SWING_CASE,
    "catenary": catenary.CASE,
    "waves": waves.CASE,
    "capstan": capstan.CASE,
    "block": block.CASE,
    "bounce": bounce.CASE,
    "rotation": rotation.CASE,
    "passive": passive.CASE,
}
