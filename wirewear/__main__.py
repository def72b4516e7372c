"""`python -m wirewear` is the command line."""

from wirewear.app.cli import main

if __name__ == "__main__":
    main()
