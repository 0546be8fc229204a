"""Policies that choose aiming points: episodes, rewards, training by PPO, and offsets found by CMA-ES."""
