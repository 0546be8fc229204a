"""Trained models as a mission uses them: files, forward passes, what they see. NumPy only, no training."""
