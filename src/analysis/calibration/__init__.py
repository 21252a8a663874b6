"""What the shots of a campaign say of the camera that filmed them."""
