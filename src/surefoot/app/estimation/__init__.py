"""A stranger's log of sensors becomes one of states, contacts and trust."""
