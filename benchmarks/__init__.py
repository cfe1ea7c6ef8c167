"""Side by side with what a user would pick instead: one command, one table, ratios from one run."""
