"""Kernels: arrays in, arrays out. numba compiles them; the same code runs as plain Python.

=================  =====================================================  =========================
file               question                                               source
=================  =====================================================  =========================
`limbs`            exact integers of any length                           schoolbook, 26-bit limbs
`exact`            exact signs and correctly rounded points               Attene 2020
`predicates`       on which side is it? (filter first)                    Shewchuk 1997
`doubled`          constructed points in double-double, with a bound      Dekker 1971
`points`           one id per point, whatever it is called                Levy 2024
`voxels`, `tree`   which triangles are near?                              Lo & Wang 2004
`crowns`           which of many trees can meet at all?
`aligned`          the same for horizons with one map
`upright`          the same for grids with straight axes, and what floats settle of it
`under`            which cells of a patch may meet a cell? (heights of nodes)
`sided`, `ways`    how do triangles of two cells meet? (heights of corners; a table of codes)
`wide`             the same beside triangles that are far wider than others
`sure`             which pairs could meet otherwise once points are rounded?
`apart`            which neighbours surely meet in common corners only?   a plane between them
`contact`          how do two triangles meet?                             Guigue & Devillers 2003
`packed`           contacts in three numbers
`naming`           contacts -> named points, and what cuts each face
`placing`          where are they? sixty-four at a time                   Dekker 1971
`merging`          which of them are one?
`byname`           what the names of a face's points tell of them
`kept`             signs of integers that are made once a face
`signs`, `circle`  signs of a face's points: doubles, names, integers     Shewchuk 1997
`delaunay`         the unique triangulation of a face's points            Lawson 1977
`order`            a face's points along Hilbert's curve
`cavity`           what a segment crosses, triangulated on both sides     Toussaint & Avis 1982
`segments`         segments into it, crossings and all
`cut`              all cut faces -> children
`thin`             pieces so thin that rounding could turn them
`mesh`             welding, edges, patches
`radial`           in which order are triangles around an edge?           Weiler 1985
`parts`            what hangs together -> cells
`measures`         volume below faces, area and bounds                    Knuth's two-sum
`ranking`          places and segments in one order
`linking`          segments that cannot overlap
`chains`           segments -> curves
`polylines`        curves -> segments
`patch`            cubics between the nodes of a lattice, their trust
`pyramid`          where can two smooth surfaces meet?
`near`, `quarters` from pairs of blocks to pairs of cells
`land`, `walk`     all curves of two smooth lattices, without triangles   Newton
`arcs`, `knots`    cubics between points of a curve, chords along them    Hermite
`doubt`            how far curves of cubics may be from the true ones
`lift`             plain points -> points on both cubics                  Newton
`resample`         as few points as a chord error allows                  Douglas & Peucker 1973
`cover`, `trace`   loops that triangles do not show                       Sederberg & Meyers 1988
`survey`           what is a lattice like? boxes, holes, how cells lie
`clear`            how do cells lie, as far as bounds of their edges tell?
`listed`           the same for a list of triangles; Morton order         Morton 1966
`strips`, `expand` what no curve touches of a lattice; as triangles again
`draped`           where a fault meets a drape                            marching triangles
`lines`, `nodes`   lines of links and what is near them; bands of a lattice
`bending`, `envelope` the smoothest surface: its equations, in a narrow band   Cuthill & McKee 1969
`products`         sums of products of a few columns
`axis`, `ahead`    cells on an axis; memory that is asked for before it is read
`torn`, `remains`  corners of the pieces of a torn sheet; which of them stay
`coarsen`          fewer triangles within a tolerance                     Evans et al. 2001
=================  =====================================================  =========================

Letters are the same in all of them. What decides exactly takes the six arrays of one frame,
always in this order: ``x`` coordinates, ``t`` triangles, ``e`` edge planes, ``d`` definitions of
constructed points, ``m`` the frame's integers, ``w`` the limb workspace; one bundle of arrays
would read better, but a tuple of arrays costs 145 ns a call instead of 10 (measured). The
triangulation of a face adds ``h``, ``q``, ``f``, ``s``, ``k``: see `delaunay`.
"""

from geosurf.kernels._pages import keep_pages

keep_pages()
