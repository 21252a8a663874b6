"""How a pair of spheres looks, learned from the first shots."""
