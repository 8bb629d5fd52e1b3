"""Detection studies: evaluation of indicators with thresholds on populations of records.

Only here are scores combined with the known labels and severities of their records.
"""
