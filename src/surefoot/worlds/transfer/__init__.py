"""Whether a success is its simulator's: the same controller in worlds of other contacts, `sf.transfer`."""
