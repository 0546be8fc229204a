"""What all nodes share: checked subscriptions, quality of service, executor, parameters."""
