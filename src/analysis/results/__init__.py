"""What a campaign has measured: coefficients of every shot, and the laws they follow."""
