"""Errors that frames share: how large they are, and how a fit holds them."""
