"""``python -m nonsmooth``."""

from nonsmooth.cli import program

if __name__ == "__main__":
    program()
