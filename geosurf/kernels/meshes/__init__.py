"""Meshes: welding, edges, parts, chains, orders and volumes, by integer keys.

================= ======================================================= ===============
file              question                                                source
================= ======================================================= ===============
`mesh`            Which vertices are equal, which edges shared? Patches.  union-find
                  Which number has each key among the distinct ones?
`parts`           Which parts do surfaces have, and at which edges do they end?
                  What of a torn sheet do faults part, and on which side of them is it?
                  Which corners of torn triangles are one vertex?         Molino 2004
`seams`           Which parts face each other around their edges? Cells.
                  In which order are triangles around an edge?            Weiler 1985
`volumes`         What are the volume below faces, area and bounds?       Knuth's two-sum
                  What volume of faces is above and below a level?        Knuth's two-sum
`shells`          In which order are triangles? Which edges are open?     Hibbard 1963
`lattice_units`   Which unit is at a point?                               Edelsbrunner & Mücke
`nearest`         How far is the nearest boundary?
`linking`         Which curves do segments form?
================= ======================================================= ===============
"""
