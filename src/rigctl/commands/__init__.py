"""What each command does, one module for each; `rigctl.command_line` holds their options."""
