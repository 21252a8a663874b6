"""How well a fit agrees with its campaign: by stage and quantity, in the noise and in units."""
