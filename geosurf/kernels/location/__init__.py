"""Location of points in a model: which unit is at a point, decided by exact signs.

A vertical line runs up from the point. Each triangle above the point that the line meets has one
unit below it and one above it. The difference of both, summed over all these triangles, leads from
the outside at the top down to the unit of the point: the order of the triangles is not needed, nor
is the nearest one.

===================  ==========================================================  ===============
file                 question                                                    source
===================  ==========================================================  ===============
`lattice_units`      Which runs of gridded surfaces are above a point?
                     On which side of an edge, or of a plane, is a point?        Edelsbrunner &
                                                                                 Mücke 1990
`triangle_bins`      Which triangles are above a point?
`nearest`            How far is the nearest triangle?
                     How far is the nearest triangle straight above or below?
===================  ==========================================================  ===============
"""
