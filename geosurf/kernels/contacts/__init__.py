"""Contacts of triangles: how two triangles meet, and the named points where they do.

==================  =========================================================  ==================
file                question                                                   source
==================  =========================================================  ==================
`triangle_contact`  How do two triangles meet?                                 Guigue & Devillers
                    Which contacts could change when points are rounded?
                    How is a contact stored in three numbers?
`cell_contacts`     How do triangles of two cells meet? Heights of corners.
                    Which codes has a contact? A table without branches.
                    Which cells of a patch may meet a cell? Heights of nodes.
`axis_grids`        Where does a grid with straight axes meet another grid?
`aligned_grids`     Where do horizons with equal map coordinates meet?
                    Which points are near a segment?
`naming`            Which named points and segments follow?
                    Where are the points, and which are equal?
==================  =========================================================  ==================
"""
