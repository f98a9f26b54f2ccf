"""The command line: arguments in, library calls, text and files out."""
