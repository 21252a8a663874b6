"""What a fit leaves over, held against what it may depend on."""
