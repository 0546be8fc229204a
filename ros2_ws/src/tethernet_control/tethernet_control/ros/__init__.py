"""What every node of the project shares: topic names, QoS profiles, the executor, parameters, checked messages."""
