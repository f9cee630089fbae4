"""python -m jaculus: the command."""
from ._command import main

main()
