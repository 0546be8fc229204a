"""A report that anybody can open: one HTML file with the flight in 3-D, plots and tables, which needs no network."""
