"""A toy integrator that follows the recipe of CONTRIBUTING: one folder, one row of the table in test_contract.py."""
