"""Cutting: the exact constrained Delaunay triangulation of each face that is cut.

===================  =========================================================  ==================
file                 question                                                         source
===================  =========================================================  ==================
`face_signs`         How do three points of a face turn? Which comes first?           Shewchuk 1997
`face_circles`       Is a point inside a circle? How are ties broken?                 Shewchuk 1997
`symbolic`           What do the definitions of points prove without arithmetic?
`cached_predicates`  What are exact signs, with integers computed once a face?
`delaunay`           What is the unique triangulation of a face's points?             Lawson 1977
`hilbert_order`      In which order are a face's points inserted?                     Hilbert curve
`cavity`             How are the triangles that a segment crosses replaced?           Toussaint 1982
`constraints`        How do segments become edges, with their crossings?
`cut_faces`          What are the children of all cut faces?
`thin_pieces`        Which pieces are so thin that rounding could invert them?
===================  =========================================================  ==================
"""
