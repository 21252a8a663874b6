"""What several pages are made of: tables, plots, fields, dialogs, readings."""
