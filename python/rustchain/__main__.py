"""`python -m rustchain`: the command `rustchain`."""

from rustchain.cli import main

if __name__ == "__main__":
    main()
