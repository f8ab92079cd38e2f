"""Getting up from lying: postures drawn at random and rolled out, and who executes them."""
