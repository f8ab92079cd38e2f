"""What every world is to a controller and a log, and the table of worlds by name."""
