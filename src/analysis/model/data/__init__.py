"""Measured poses and tabulated contacts of a campaign, as arrays."""
