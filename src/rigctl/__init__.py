"""The daemon: fires the rig, takes the frames, has each shot analysed, answers operators."""
