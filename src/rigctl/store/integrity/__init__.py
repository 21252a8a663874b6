"""Whether a store still is what was stored: digests, the keyed ledger, copies that are proved."""
