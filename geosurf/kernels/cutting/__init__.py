"""Cutting: the exact constrained Delaunay triangulation of each face that is cut.

===================  ==================================================  =====================
file                 question                                            source
===================  ==================================================  =====================
`face_signs`         signs of the points of a face                       Shewchuk 1997
`face_circles`       is a point inside a circle? ties included           Shewchuk 1997
`symbolic`           what the names of a face's points tell of them
`cached_predicates`  signs of integers that are made once a face
`delaunay`           the unique triangulation of a face's points         Lawson 1977
`hilbert_order`      a face's points along Hilbert's curve
`cavity`             what a segment crosses, triangulated on both sides  Toussaint & Avis 1982
`constraints`        segments into it, crossings and all
`cut_faces`          all cut faces -> children
`thin_pieces`        pieces so thin that rounding could turn them
===================  ==================================================  =====================
"""
