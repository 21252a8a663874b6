"""What survives: the catalogue of shots and one folder for each shot."""
