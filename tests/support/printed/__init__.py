"""What the documents print, run as it is printed: blocks of Python, lines of the shell."""
