"""The catalogue: one small file for each physical effect that the base model leaves out."""
