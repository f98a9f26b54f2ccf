"""The ways through time, one family a folder: frozen options, the arrays they need, and the compiled loop.

``records`` has what all carry along and write down.
"""
