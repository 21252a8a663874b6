"""What the theory predicts from the state of each shot, with derivatives."""
