"""`python -m studies.blind` is the command line of the exam."""

from studies.blind.commands import main

if __name__ == "__main__":
    main()
