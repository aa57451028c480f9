"""The papers, one module each: their instruments, derivations, figures, and the values of their rows in the ledger.

Each has a function ``values()`` from row id to what computes it; `fogkit.claims` compares that with the print.
"""
