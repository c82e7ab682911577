"""Contacts of triangles: how they meet, and the named points where they do.

==================  ==========================================================  =================
file                question                                                    source
==================  ==========================================================  =================
`triangle_contact`  how do two triangles meet?                                  Guigue, Devillers
`packed_contact`    contacts in three numbers
`contact_table`     codes of a contact, from a table
`cell_contacts`     how do triangles of two cells meet? heights of corners
`column_pairs`      which cells of a patch may meet a cell? (heights of nodes)
`axis_grids`        where a grid with straight axes meets another grid
`axis_cells`        cells on an axis that reach an interval
`aligned_grids`     contacts of horizons with one map
`stable_pairs`      which pairs could meet otherwise once points are rounded?
`naming`            contacts -> named points, and what cuts each face
`merging`           which of them are one?
`placing`           where are they? sixty-four at a time                        Dekker 1971
`near_segments`     which points are near a segment?
==================  ==========================================================  =================
"""
