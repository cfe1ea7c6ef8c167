"""Grade a class: a trusted judge outside, student code inside a sandbox."""
