"""``python -m leadscrew``."""

from leadscrew.cli import main

if __name__ == "__main__":
    main()
