"""What may go wrong in a campaign for reasons that its user can remove."""

from __future__ import annotations

from tethernet_core.errors import InputError


class CampaignError(InputError):
    """A file or an option cannot be used: says what was given, what is allowed and what to do."""
