"""Devices on the wire: models of each protocol, faults on command, and the ports they sit behind.

A model answers one command at a time and knows no port, no thread and no fault. Between a model
and its port stand the framing, which cuts bytes into commands, and the faults.
"""
