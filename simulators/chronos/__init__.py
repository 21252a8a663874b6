"""A camera that records into its own memory and is spoken to over HTTP: Krontech's Chronos.

Written from Krontech's public documentation of the interface; shares no code with the driver.
"""
