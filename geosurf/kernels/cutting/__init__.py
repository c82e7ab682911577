"""Cutting: the exact constrained Delaunay triangulation of each face that is cut.

===================  =======================================================  =====================
file                 question                                                 source
===================  =======================================================  =====================
`face_signs`         How do three points of a face turn? Which comes first?   Shewchuk 1997
`face_circles`       Is a point inside a circle? How are ties broken?         Shewchuk 1997
`symbolic`           What do definitions of points prove without arithmetic?
`cached_predicates`  What are exact signs, with integers made once a face?
`delaunay`           What is the unique triangulation of a face?              Lawson 1977
`cavity`             How are triangles that a segment crosses replaced?       Toussaint & Avis 1982
`constraints`        How do segments become edges, with their crossings?
`record_groups`      Which segments and points cut which face?
`cut_faces`          What are the children of all cut faces?
`thin_pieces`        Which pieces are so thin that rounding may invert them?
===================  =======================================================  =====================
"""
