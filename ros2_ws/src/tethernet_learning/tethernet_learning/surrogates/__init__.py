"""Training of surrogates, and what they come to on data they have not seen."""
