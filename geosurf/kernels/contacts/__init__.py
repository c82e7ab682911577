"""Contacts of triangles: how two triangles meet, and the named points where they do.

==================  =========================================================  ==================
file                question                                                   source
==================  =========================================================  ==================
`triangle_contact`  How do two triangles meet?                                 Guigue & Devillers
                    Which contacts could change when points are rounded?
                    How is a contact stored in three numbers?
`axis_grids`        Where may a grid with straight axes meet another grid?
                    Which cells of a patch may meet a cell? Heights of nodes.
`aligned_grids`     Where do horizons with equal map coordinates meet?
                    Which points are near a segment?
`naming`            Which named points and segments follow?
                    Where are the points, and which are equal?
==================  =========================================================  ==================
"""
