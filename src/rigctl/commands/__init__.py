"""What each command does, one module for each; `rigctl.cli` holds their options."""
