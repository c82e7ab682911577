"""Numbers in text, in bulk: each word becomes the nearest double.

=================  ============================================================  ================
file               question                                                      source
=================  ============================================================  ================
`decimals`         Which double is nearest to a decimal?                         Dekker 1971,
                                                                                 Ziv 1991
`number_words`     Which numbers does a text hold, line by line?
`gocad_lines`      Which vertices and triangles do lines of GOCAD hold?
=================  ============================================================  ================

*Notation*: ``text`` holds eight characters in each int64, the first in the lowest byte, and at
least one line end after the last character; ``at`` and ``end`` count characters.
"""
