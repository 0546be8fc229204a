"""What may go wrong in a campaign for reasons that its user can remove."""


class CampaignError(ValueError):
    """A file or an option cannot be used: says what was given, what is allowed and what to do."""
