"""What stands in for the laboratory: devices on the wire and the world behind them.

Own physics and own renderer; nothing here is shared with `analysis` or `rigctl`.
"""
