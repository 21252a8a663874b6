"""From motion before and after to the impact and its coefficients."""
