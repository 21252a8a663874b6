"""Campaigns in the forms of other systems: NeXus files, event-model documents."""
