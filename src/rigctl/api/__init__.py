"""The Python interface, `import rigctl`: campaigns opened, measured, fitted and explained.

A thin layer over the analysis and the store, for notebooks and scripts. It shares no code with the
commands, which stand beside it.
"""
