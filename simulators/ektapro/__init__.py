"""The EktaPro 1000 as a device: tape, processor, remote trigger, link and digitiser.

After thesis appendix A. Its real host protocol is not public; the link is this project's own.
"""
