"""A mission seen in three dimensions and as time series, in Rerun: while it is flown, or from its bag."""
