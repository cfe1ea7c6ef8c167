"""One file per lab: see CONTRIBUTING."""
