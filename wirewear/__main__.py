"""`python -m wirewear` is the command line."""

from wirewear.faces import main

if __name__ == "__main__":
    main()
