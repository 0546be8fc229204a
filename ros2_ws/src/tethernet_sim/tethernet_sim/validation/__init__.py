"""The engine against others: analytic solutions, published set-ups, figures that the literature compares."""
