"""Arguments and options of the commands, one file a group; `rigctl.cli` puts them together."""
