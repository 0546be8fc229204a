"""Campaigns, data sets, training and evaluation of models: everything that is offline."""
