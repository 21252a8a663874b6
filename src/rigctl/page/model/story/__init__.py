"""The model as a story of four steps, each shown before it is named."""
