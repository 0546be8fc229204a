"""Facts about a run that its recording carries: names of those that other programs read."""

DESCRIPTION = "system_description"
"""The complete description of the system that was flown, YAML."""
PARAMETERS = "parameters"
"""The run's parameters, YAML."""
IDENTIFYING = ("system", "mus", "policy", "seed")
"""Which mission it was. A recording of another recorder has none of them."""
TEXTS = frozenset((DESCRIPTION, PARAMETERS))
"""Facts that are texts of many lines."""
