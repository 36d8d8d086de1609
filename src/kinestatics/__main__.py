"""`python -m kinestatics` is the command `kinestatics`."""

from .cli import main

main()
