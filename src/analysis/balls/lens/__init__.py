"""The lens of a camera: from pictures of a board to pictures without distortion."""
