"""Cutting: the exact constrained Delaunay triangulation of each face that is cut.

===================  =======================================================  =====================
file                 question                                                 source
===================  =======================================================  =====================
`face_signs`         How do three points of a face turn? Which comes first?   Shewchuk 1997
                     Is a point inside a circle? How are ties broken?         Shewchuk 1997
                     What do definitions of points prove without arithmetic?
`cached_predicates`  What are exact signs, with integers made once a face?
`delaunay`           What is the unique triangulation of a face?              Lawson 1977
`constraints`        How do segments become edges, with their crossings?
                     How are triangles that a segment crosses replaced?       Toussaint & Avis 1982
`cut_faces`          What are the children of all cut faces?
                     Which segments and points cut which face?
                     Which pieces are so thin that rounding may invert them?
===================  =======================================================  =====================
"""
