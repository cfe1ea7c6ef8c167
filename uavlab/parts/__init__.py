"""What flies: glue around the functions that the exercises ask for; no answers inside."""
