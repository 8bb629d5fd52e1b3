"""``python -m hydrofdi``."""

from hydrofdi.cli.app import main

if __name__ == "__main__":
    main()
