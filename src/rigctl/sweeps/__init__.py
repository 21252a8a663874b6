"""Sweeps: many shots one after another, durable from step to step."""
