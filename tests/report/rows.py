"""What people read in a table."""


def rows(table):
    return [[text for text, _ in row] for row in table.texts()]
