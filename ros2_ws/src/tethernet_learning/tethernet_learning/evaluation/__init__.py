"""Trained models on unseen scenarios; their cards."""
