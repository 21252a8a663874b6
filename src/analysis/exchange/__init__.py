"""The exchange folder: what a lab hands to another lab, or to this project from another tracker."""
