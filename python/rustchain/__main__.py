"""`python -m rustchain`: the command `rustchain`."""

from rustchain.cli.app import main

if __name__ == "__main__":
    main()
