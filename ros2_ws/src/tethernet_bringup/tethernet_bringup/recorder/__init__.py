"""The recorder's node and what it records."""
