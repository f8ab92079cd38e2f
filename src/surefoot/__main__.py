"""`python -m surefoot` is the `surefoot` command."""

from surefoot.app.cli.main import run

if __name__ == "__main__":
    run()
