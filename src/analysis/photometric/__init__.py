"""Measurement by rendering: poses whose image fits the pixels best, at the noise limit."""
