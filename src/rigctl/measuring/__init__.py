"""From stored frames to results: processes, what they learn, and what is kept."""
