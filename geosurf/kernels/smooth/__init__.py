"""Smooth curves: where the cubics through two lattices meet, to a tolerance.

================  =====================================================  =======================
file              question                                               source
================  =====================================================  =======================
`cubic_patch`     What are the cubics, and how accurate are they?        Lagrange
`patch_pyramid`   Where can two smooth surfaces meet? Bounds of blocks.
`near_blocks`     Which blocks need bounds at all? Boxes of nodes.
`patch_pairs`     Which pairs of cells follow from pairs of blocks?
`quadtree`        Which box and slab hold a block or its quarter?
`control_nets`    Are two Bernstein nets separated by a plane?
`newton_seeds`    Where is a curve in a pair of cells?                   Newton
`curve_walk`      What are all curves of two smooth lattices?            predictor, corrector
`hermite_arcs`    Which cubics connect points of a curve?                Hermite
`knots`           What is stored at a knot? Which chords connect knots?
`error_estimate`  How far are curves of cubics from the true ones?
`lift`            Where are points of plain curves on both cubics?       Newton
`resample`        Which few points keep a chord error?                   Douglas & Peucker 1973
`coverage`        Which loops do triangles not show?                     Sederberg & Meyers 1988
`trace`           How does a curve continue from one of its points?      Newton
================  =====================================================  =======================
"""
