"""The `surefoot` command: one file per command."""
